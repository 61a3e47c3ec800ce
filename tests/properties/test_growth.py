"""What grows with an input that others wrote: announced or refused before it is begun, and read in linear time."""

import re
import zipfile
from pathlib import Path

import numpy as np
import pytest
from stopwatch import takes_less_than

from jkrcli.adhesion.slopes import smoothed
from jkrcli.base.errors import InputError
from jkrcli.base.process import SILENCE
from jkrcli.case.models import parse_case
from jkrcli.cli import MOST_WORDS
from jkrcli.cli.inputs import TABLE_PER_ROW
from jkrcli.measured import files as measured
from jkrcli.measured import instruments
from jkrcli.measured.afm_formats import estimate_rows
from jkrcli.resolve import foreign
from jkrcli.series import RawSeries
from jkrcli.tables.text import MOST_COLUMNS, read_table

ROWS = "".join(f"{i}e-6\t{i * i}e-6\n" for i in range(1, 31))
HALF_SPACE = """
method = "{method}"
indenter = {{ shape = "paraboloid", radius = "1 mm" }}
specimen.half_space = {{ E = "1 MPa", nu = 0.3 }}
loading = {{ {loading} }}
adhesion.w = 0.05
"""


def problem(loading: str, method: str = "closed-form"):
    return parse_case(HALF_SPACE.format(method=method, loading=loading).encode(), "x").model.problem()


def test_a_long_command_line_is_refused_before_it_is_taken_apart(jkr) -> None:
    with takes_less_than(1):
        done = jkr("transform", "s.h5", *["--w", "1"] * (MOST_WORDS // 2))
    assert done.code == 2
    assert done.err == "jkr: error: the command line holds 100,002 words, at most 100,000 are read\n"


@pytest.mark.parametrize(
    ("verb", "seconds"),
    [(("look",), "3 s"), (("work", "s.toml"), "11 s"), (("fit", "s.toml"), "53 s"), (("compare", "none.csv"), "3 s")],
    ids=str,
)
def test_long_tables_are_announced_before_they_are_read(jkr, tmp_path, monkeypatch, verb, seconds) -> None:
    stopped(monkeypatch, "jkrcli.measured.work.each", "jkrcli.measured.files.each",  # imports first
            "jkrcli.report.forward.read_curve", "jkrcli.measured.fits.fitted_body")  # fmt: skip
    Path("s.toml").write_text(HALF_SPACE.format(method="closed-form", loading='radius = "0.1 mm"'))
    Path("long.csv").write_text("delta_m,P_N\n" + "1e-6,12345e-6\n" * 1_000_000)
    done = jkr(*verb, "long.csv")
    assert done.code == 130
    assert f"jkr: {verb[0]} of about 1,000,000 rows takes about {seconds} of CPU time\n" in done.err


def stopped(monkeypatch: pytest.MonkeyPatch, *names: str) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    for name in names:
        monkeypatch.setattr(name, interrupt)


@pytest.mark.parametrize(
    ("verb", "first"),
    [
        ("show", "report.archive.is_archive"),
        ("transform", "cli.inputs.series_file"),
        ("pull-off", "cli.inputs.series_file"),
    ],
)
def test_many_files_are_announced_before_the_first_is_opened(jkr, monkeypatch, verb, first) -> None:
    stopped(monkeypatch, f"jkrcli.{first}")
    done = jkr(verb, *(f"{i}.h5" for i in range(3_000)))
    assert done.err.startswith(f"jkr: {verb} of 3,000 files: about 36 s of CPU time\n")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--confidence", "bootstrap", "--samples", "100000"), " takes about 10 min of CPU time"),
        (("--confidence", "bootstrap", "--samples", "100000", "--surface", "both"), " takes about 21 min of CPU time"),
        (("--confidence", "profile", "--uncertain", "nu=0.01", "--uncertain", "radius=1%"), "error: interrupted"),
    ],
)
def test_intervals_are_announced_and_refused_before_anything_is_read(jkr, monkeypatch, words, told) -> None:
    """A bootstrap of 100,000 samples took 22 min without a word."""
    stopped(monkeypatch, "jkrcli.measured.work.each", "jkrcli.measured.files.each", "jkrcli.measured.fits.fitted_body")
    Path("s.toml").write_text(HALF_SPACE.format(method="closed-form", loading='radius = "0.1 mm"'))
    Path("x.csv").write_text("delta_m,P_N\n" + "1e-6,12345e-6\n" * 50)
    assert told in jkr("fit", "s.toml", "x.csv", *words).err
    jkr("fit", "s.toml", "x.csv", *words, "--limit-time", "1e-4").refused(
        "use fewer rows, curves or samples, or raise the limit by --limit-time"
    )


def test_intervals_of_many_curves_are_refused_when_these_are_known(jkr) -> None:
    Path("s.toml").write_text(HALF_SPACE.format(method="closed-form", loading='radius = "0.1 mm"'))
    with zipfile.ZipFile("map.zip", "w") as file:
        for i in range(40):
            file.writestr(f"{i}.csv", f"delta_m\tP_N\n{ROWS}")
    done = jkr("fit", "s.toml", "map.zip", "--confidence", "bootstrap", "--limit-time", "0.01")
    assert done.code == 2
    assert "jkr: error: fit of 40 curves would need about 0.00137 GiB of memory and 50 s of CPU time" in done.err


def test_a_long_program_is_announced_and_refused_before_it_is_read(jkr, monkeypatch: pytest.MonkeyPatch) -> None:
    """30 s for 10,000 rows."""
    Path("s.toml").write_text(HALF_SPACE.format(method="closed-form", loading='radius = "0.1 mm"'))
    Path("x.csv").write_text("t_s,x_m\n" + "".join(f"{i:05d},1e-6\n" for i in range(10_000)))
    stopped(monkeypatch, "jkrcli.resolve.foreign.read_program")
    words = ("cycle", "s.toml", "--rate", "v0=1e-6,n=0.6", "--program", "x.csv")
    assert "cycle --program of about 10,000 rows takes about 2 min" in jkr(*words).err
    jkr(*words, "--limit-time", "0.01").refused(
        "fewer rows of the program, or fewer --points, or raise the limit by --limit-time 0.0"
    )


def test_devices_count_in_what_is_announced_and_refused(jkr, monkeypatch: pytest.MonkeyPatch) -> None:
    """40 s for 2,000 of them."""
    Path("s.toml").write_text(HALF_SPACE.format(method="closed-form", loading='radius = "0.1 mm"'))
    stopped(monkeypatch, "jkrcli.resolve.analysis.where_lost")
    words = ("pull-off", "s.toml", *(word for i in range(2_000) for word in ("--stiffness", f"{i + 1}")))
    assert "pull-off of 100 rows for 1 work of adhesion under 2,000 controls takes about " in jkr(*words).err
    jkr(*words, "--limit-time", "1e-3").refused(
        "use fewer rows, files, controls or works of adhesion, or leave out the plots, or raise"
    )


SWEEP = """
base = "s.toml"
outputs.radii = [{}]
[[axes]]
key = "specimen.half_space.nu"
from = 0.1
to = 0.4
count = {}
"""


@pytest.mark.parametrize(
    ("radii", "cases", "said"),
    [
        (250_000, 2, "x.toml: is larger than 2 MiB"),
        (2_000, 2, "make 12,000 columns, at most 10,000 are written; use fewer"),
        (1_000, 20_000, "20,000 cases of 6,024 columns, 120,480,000 cells, at most 100,000,000 are written"),
    ],
)
def test_tables_of_sweeps_too_large_to_write_are_refused(jkr, radii: int, cases: int, said: str) -> None:
    Path("s.toml").write_text(HALF_SPACE.format(method="closed-form", loading='radius = "0.1 mm"'))
    Path("x.toml").write_text(SWEEP.format(",".join(f"{1e-5 + i * 1e-9:.6e}" for i in range(radii)), cases))
    jkr("sweep", "x.toml").refused(said)


def test_rows_are_told_from_size_and_first_lines(tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_text("delta_m,P_N\n" + "1e-6,12345e-6\n" * 10_000)
    assert estimate_rows(tmp_path / "x.csv") == pytest.approx(10_000, rel=1e-3)
    (tmp_path / "utf16.csv").write_text("delta_m,P_N\n" + "1e-6,12345e-6\n" * 10_000, encoding="utf-16")
    assert estimate_rows(tmp_path / "utf16.csv") == pytest.approx(10_000, rel=1e-3)
    with zipfile.ZipFile(tmp_path / "x.zip", "w", zipfile.ZIP_DEFLATED) as file:
        file.write(tmp_path / "x.csv", "x.csv")
    assert 1 / 3 < estimate_rows(tmp_path / "x.zip") / 10_000 < 3
    (tmp_path / "wide.csv").write_text(("1," * 999 + "1\n") * 100)
    assert 1000 < estimate_rows(tmp_path / "wide.csv") < 2000  # as many take as long
    assert estimate_rows(tmp_path / "none.csv") == 0
    assert TABLE_PER_ROW * 10_000 < SILENCE


def test_an_import_of_more_rows_than_a_case_can_name_is_refused(tmp_path, monkeypatch) -> None:
    """It ended in a traceback."""
    with pytest.raises(InputError):
        problem(f'radius = "0.1 mm", points = {foreign.MOST_ROWS + 1}')
    monkeypatch.setattr(foreign, "MOST_ROWS", 100)
    a = np.linspace(1e-5, 9e-5, 101)
    table = np.column_stack([a, a**2 / 1e-3, a**3])
    np.savetxt(tmp_path / "h.csv", table, delimiter=",", header="a_m,delta_m,P_N", comments="")
    with pytest.raises(InputError, match=r"holds 101 rows, at most 100 are imported: leave some out"):
        foreign.read_series(tmp_path / "h.csv", problem('radius = "0.1 mm"'), foreign.SeriesReading())


@pytest.mark.parametrize("wrong", [1e-30, 1e30])
def test_a_radius_out_of_all_range_is_named_rather_than_fitted(wrong: float) -> None:
    """The grid of the fit grows with the decades between radii: it took 10 s."""
    a = np.linspace(1e-6, 2e-5, 20)
    delta, P = a**2, a**3
    a[8] = wrong
    with pytest.raises(InputError, match=rf"point 9 has a = {re.escape(f'{wrong:g}')} m, radii .* decades, at most 12"):
        smoothed(RawSeries(a, delta, P, np.arange(1, 21)))


def test_of_a_very_long_head_of_comments_both_ends_are_read(tmp_path: Path) -> None:
    """Three million were asked one after the other for segments, constants and names, by every dialect."""
    lines = [f"# remark {i}\n" for i in range(3 * MOST_COLUMNS)]
    lines[0] = "# springConstant: 0.25\n"
    path = tmp_path / "x.txt"
    path.write_text("".join([*lines, "# delta (um)\tP (nN)\n", ROWS]))
    table = read_table(path, least=2)
    assert table.names == ("delta (um)", "P (nN)")
    assert len(table.head) == 2 * MOST_COLUMNS
    assert table.lines[0] == 3 * MOST_COLUMNS + 2
    assert instruments.constants(table.head) == {"stiffness": 0.25}


@pytest.mark.first(3)
@pytest.mark.parametrize("line", [
    "k" + " " * 30_000 + "x", "1" * 30_000 + "x", "-" * 30_000, "(" * 30_000 + "N/m", "a" + "\t" * 30_000 + "b",
    "m" * 30_000, "_" * 30_000, ":" * 30_000, "N/" * 15_000,
], ids=["blanks", "digits", "dashes", "brackets", "tabs", "letters", "underscores", "colons", "units"])  # fmt: skip
def test_long_lines_before_the_numbers_are_read_at_once(tmp_path: Path, line: str) -> None:
    """Patterns that backtrack took minutes of each of them."""
    (tmp_path / "head.txt").write_text(f"{line}\ndelta_m\tP_N\n{ROWS}")
    (tmp_path / "title.txt").write_text(f"delta_m\tP_N\t{line.strip()}\n" + ROWS.replace("\n", "\t1\n"))
    with takes_less_than(1):
        assert len(measured.read(tmp_path / "head.txt")[0]) == 30
        if "\t" not in line:
            assert len(measured.read(tmp_path / "title.txt")[0]) == 30


def test_decimal_commas_are_read_as_exactly(tmp_path: Path) -> None:
    text = "delta [m];P [N];t [s]\n" + "".join(f"{i / 7e6!r};{i / 3e6!r};{i / 10}\n" for i in range(1, 1000))
    (tmp_path / "points.csv").write_text(text)
    (tmp_path / "commas.csv").write_text(text.replace(".", ","))
    plain, commas = (measured.read(tmp_path / f"{name}.csv")[0] for name in ("points", "commas"))
    for name in ("delta", "P", "t"):
        assert np.array_equal(getattr(plain, name), getattr(commas, name))


def test_archives_of_many_tables_are_opened_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Their list of members was read again for each of them: hours for 20,000."""
    with zipfile.ZipFile(tmp_path / "many.zip", "w") as file:
        for i in range(20):
            file.writestr(f"{i}.csv", f"delta_m\tP_N\n{ROWS}")
    opened = []
    whole = zipfile.ZipFile.__init__

    def counted(self: zipfile.ZipFile, *words: object, **options: object) -> None:
        opened.append(words)
        whole(self, *words, **options)

    monkeypatch.setattr(zipfile.ZipFile, "__init__", counted)
    assert len(measured.read(tmp_path / "many.zip")) == 20
    assert len(opened) == 2


def test_an_archive_with_a_name_twice_is_refused(tmp_path: Path) -> None:
    """The last of them was read as both."""
    with zipfile.ZipFile(tmp_path / "x.zip", "w") as file:
        file.writestr("a.csv", f"delta_m\tP_N\n{ROWS}")
        with pytest.warns(UserWarning, match="Duplicate name"):
            file.writestr("a.csv", f"delta_m\tP_N\n{ROWS}".replace("e-6", "e-7"))
    with pytest.raises(InputError, match=r"x\.zip: holds a\.csv 2 times"):
        measured.read(tmp_path / "x.zip")


@pytest.mark.parametrize("title", ["curve", "segment"])
def test_a_title_of_words_below_numbers_is_refused(tmp_path: Path, title: str) -> None:
    """What fuzzing by coverage found: a second head, after a row that ends the first, was a KeyError."""
    numbers = "1e-5;1e-8;1e-6\n"
    (tmp_path / "x.csv").write_text(f"1;2;x\n{title} (m);delta (m);P (N)\n{numbers * 20}")
    with pytest.raises(InputError, match=rf'column 1 "{title} \(m\)" would hold words, but numbers stand above'):
        measured.read(tmp_path / "x.csv")


@pytest.mark.parametrize(("mark", "other"), [(",", "."), (".", ",")])
def test_a_column_that_passes_a_thousand_is_not_read_as_falling_to_one(tmp_path: Path, mark: str, other: str) -> None:
    """990, 1,000: a thousandth of the size without a word."""
    rows = [f"{i:,}\t{2 * i:,}" for i in range(900, 1400, 10)]
    path = tmp_path / "x.txt"
    path.write_text("\n".join(["delta [nm]\tP [nN]", *rows]).replace(",", mark) + "\n")
    with pytest.raises(InputError, match=rf'line 12: "1\{mark}000" stands beside "900": say by --decimal whether'):
        measured.read(path)
    grouped, plain = (measured.read(path, measured.Reading(decimal=one))[0].delta for one in (other, mark))
    assert grouped[[0, -1]] == pytest.approx([900e-9, 1390e-9])
    assert plain[[0, -1]] == pytest.approx([900e-9, 1.39e-9])
