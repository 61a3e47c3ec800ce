"""Measured curves: the same curve in many guises, conventions, zero points, and whole lines for what is wrong."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jkrcli.base.errors import InputError
from jkrcli.measured import files as measured
from jkrcli.measured.curve import Curve, Reading
from jkrcli.measured.segmentation import saturation, saturation_words, with_zero_points

MEND = ": correct it, or put # before it"
A = np.array([1.0, 2.0, 3.0, 2.5]) * 1e-5
DELTA = np.array([-5e-7, 1e-6, 3e-6, 2e-6])
P = np.array([-1e-6, 2e-6, 8e-6, 3e-6])
T = np.array([0.0, 0.5, 1.0, 2.0])
WORDS = ("approach", "approach", "retract", "retract")


def rows(*columns: np.ndarray | tuple[str, ...], mark: str = ",", decimal: str = ".") -> str:
    def cell(value: object) -> str:
        return value if isinstance(value, str) else format(value, ".17e").replace(".", decimal)

    return "".join(mark.join(map(cell, row)) + "\n" for row in zip(*columns, strict=True))


GUISES = {
    "names and units of our own": ("t_s,a_m,delta_m,P_N,segment\n" + rows(T, A, DELTA, P, WORDS), Reading()),
    "semicolons, decimal comma, comments, a line of units, byte order mark": (
        "\ufeff# made by a machine\nTime;Radius;Indentation;Force;Phase\nms;µm;nm;uN;-\n"
        + rows(T * 1e3, A * 1e6, DELTA * 1e9, P * 1e6, ("Loading", "extend", "unloading", "Retrace"), mark=";",
               decimal=","),
        Reading(),
    ),
    "tabs, no header: columns and units by flags": (
        rows(P * 1e9, WORDS, DELTA * 1e6, A, T, mark="\t"),
        Reading(columns={"P": "1", "segment": "2", "delta": "3", "a": "4", "t": "5"},
                units={"P": "nN", "delta": "um", "a": "m", "t": "s"}),
    ),
    "blanks, names of another tongue, codes for segments, projected area": (
        "# Zeit (s)  Kraft (mN)  Weg (mm)  Fl (um^2)  Ast\n"
        + rows(T, P * 1e3, DELTA * 1e3, np.pi * A**2 * 1e12, ("0", "0", "1", "1"), mark="  "),
        Reading(columns={"t": "Zeit", "P": "Kraft", "delta": "Weg", "area": "Fl", "segment": "Ast"}),
    ),
    "contact diameter, minus signs of a typesetter": (
        ("time_s,diameter (um),delta_um,P_mN,phase\n" + rows(T, 2 * A * 1e6, DELTA * 1e6, P * 1e3, WORDS))
        .replace(",-", ",\u2212").replace("e-", "e\u2212"),
        Reading(),
    ),
    "signs turned, zero points elsewhere, an instrument that gives way": (
        "t (s),height (um),P (N),a (m),segment\n" + rows(T, -(DELTA + P / 5.0 + 7e-6) * 1e6, -P + 1e-3, A, WORDS),
        Reading(columns={"delta": "height"}, flip=frozenset({"P", "delta"}), zero={"delta": 7e-6, "P": -1e-3},
                stiffness=5.0),
    ),
}  # fmt: skip


@pytest.mark.parametrize("guise", GUISES)
def test_one_curve_in_many_guises(tmp_path: Path, guise: str) -> None:
    text, reading = GUISES[guise]
    path = tmp_path / "m.csv"
    path.write_text(text, encoding="utf-8")
    (curve,) = measured.read(path, reading)
    assert (curve.name, curve.where, curve.measured) == ("m", str(path), ("a", "delta", "P", "t"))
    assert curve.segment is not None
    assert tuple(curve.segment) == WORDS
    for name, expected in (("a", A), ("delta", DELTA), ("P", P), ("t", T)):
        # Zero points of 1 mN under loads of 1 uN cost three digits.
        np.testing.assert_allclose(getattr(curve, name), expected, rtol=5e-13, atol=0)  # 8e-14 measured


def test_a_diameter_that_is_the_same_in_all_rows_is_that_of_the_indenter(tmp_path: Path) -> None:
    path = tmp_path / "m.csv"
    path.write_text("delta_um,P_nN,diameter_mm\n1,1,5\n2,3,5\n3,5,5\n")
    assert measured.read(path)[0].measured == ("delta", "P")


def test_several_curves_in_one_file_keep_their_order(tmp_path: Path) -> None:
    path = tmp_path / "map.tsv"
    path.write_text("curve\tdelta_nm\tP_nN\n" + "".join(f"{'cab'[i % 3]}\t{i}\t{10 * i}\n" for i in range(12)))
    curves = measured.read(path)
    assert [curve.name for curve in curves] == ["c", "a", "b"]
    np.testing.assert_allclose(curves[1].P, np.array([10, 40, 70, 100]) * 1e-9, rtol=1e-14)
    assert curves[1].where == f'{path}: curve "a"'
    assert curves[1].segment is None


def test_a_bad_curve_does_not_cost_the_others(tmp_path: Path) -> None:
    path = tmp_path / "m.csv"
    table = [f"{name},{i},{i}" for name in ("one", "two", "three") for i in range(4)]
    table[5] = "two,nan,1"
    path.write_text("curve,delta_nm,P_nN\n" + "\n".join([*table, "four,1,1"]) + "\n")
    found = list(measured.each(path))
    assert [item.name for item in found if isinstance(item, Curve)] == ["one", "three"]
    assert [str(item) for item in found if isinstance(item, InputError)] == [
        f'{path}: curve "two": line 7: displacement must be finite, got nan (SI)',
        f'{path}: curve "four": holds 1 row (line 14), at least 3 are needed',
    ]
    with pytest.raises(InputError) as caught:
        measured.read(path)
    assert len(caught.value.lines) == 2


@settings(deadline=None, max_examples=40)
@given(
    table=st.lists(st.tuples(*[st.floats(-1e3, 1e3, allow_subnormal=False)] * 3), min_size=3, max_size=8),
    decimal=st.sampled_from([".", ","]),
)
def test_numbers_come_back_to_the_last_bit(
    tmp_path_factory: pytest.TempPathFactory, table: list[tuple[float, ...]], decimal: str
) -> None:
    """With a decimal point by numpy's reader, with a comma by our own: the same numbers."""
    path = tmp_path_factory.mktemp("t") / "m.csv"
    text = "".join(";".join(map(repr, row)) + "\n" for row in table).replace(".", decimal)
    path.write_text("delta_m;P_N;other\n" + text)
    (curve,) = measured.read(path, Reading(separator="semicolon", decimal=decimal))
    assert curve.delta.tolist() == [row[0] for row in table]
    assert curve.P.tolist() == [row[1] for row in table]


# ---------------------------------------------------------------------- what is wrong
GOOD = "delta_nm,P_nN\n1,1\n2,2\n3,3\n"
WRONG = {
    "wrong column": (
        GOOD, Reading(columns={"P": "P_n"}),
        '{path}: no single column "P_n" for P, did you mean "P"? (columns: 1 "delta_nm", 2 "P_nN")',
    ),
    "nothing recognised": (
        "x,y\n1,1\n2,2\n3,3\n", Reading(),
        "{path}: at least two of contact radius (or area), displacement and load are needed, recognised: none; say "
        'which columns they are, --column P=NAME (columns: 1 "x", 2 "y")',
    ),
    "the same name twice": (
        "delta_nm,P_nN,P_nN\n1,1,1\n2,2,3\n3,3,3\n", Reading(),
        '{path}: 2 columns are recognised as the load: say which, --column P=NAME (columns: 1 "delta_nm", 2 "P_nN", '
        '3 "P_nN")',
    ),
    "no unit": (
        "delta,P_nN\n1,1\n2,2\n3,3\n", Reading(),
        '{path}: column 1 "delta" (displacement) names no unit: give --unit delta=um, or write it into the header',
    ),
    "unit of another quantity": (
        "delta_nm,P (Pa)\n1,1\n2,2\n3,3\n", Reading(),
        '{path}: column 2 "P (Pa)" (load): the unit must be one of load, such as mN, got "Pa"',
    ),
    "unit of a column that is not there": (
        GOOD, Reading(units={"Load": "nN"}),
        '{path}: no single column "Load" for --unit Load=nN (columns: 1 "delta_nm", 2 "P_nN")',
    ),
    "a deflection without a unit": (
        "piezo (nm),deflection\n1,1\n2,2\n3,3\n", Reading(stiffness=0.1),
        '{path}: column 2 "deflection" is a deflection and names no unit: give --unit "deflection=nm", or V, or nN, or '
        "write it into the header",
    ),
    "three columns without names": (
        "1 1 1\n2 2 2\n3 3 3\n", Reading(),
        "{path}: at least two of contact radius (or area), displacement and load are needed, recognised: none; say "
        "which columns they are, --column P=NAME (columns: 1, 2, 3); or --format afm, if a microscope's program wrote "
        "three columns without names",
    ),
    "a sensor that gives up in the middle": (
        "delta_nm;P_nN;x\n" + "1;1;1\n" * 2 + "2;N/A;1\n" * 2 + "3;1;1\n", Reading(),
        '{path}: line 4 must hold 3 numbers, got "2;N/A;1"' + MEND + "\n"
        '{path}: line 5 must hold 3 numbers, got "2;N/A;1"' + MEND,
    ),
    "a load of words": (
        "delta_nm;P_nN;x\n" + "1;none;1\n" * 3, Reading(),
        '{path}: column 2 "P_nN" holds text, not numbers: line 2 has "none"',
    ),
    "a line between rows that names no segment": (
        GOOD + "Block 2\n4,4\n", Reading(),
        '{path}: line 5 must hold 2 numbers, got "Block 2": remove it, or put # before it',
    ),
    "a header that comes again, for another curve": (
        GOOD + "delta_nm,P_nN\n4,4\n", Reading(), '{path}: line 5 must hold 2 numbers, got "delta_nm,P_nN"' + MEND,
    ),
    "unit of no column": (
        GOOD, Reading(units={"t": "s"}),
        '{path}: --unit t=s has no column to belong to: give --column t=NAME (columns: 1 "delta_nm", 2 "P_nN")',
    ),
    "one column twice": (
        GOOD, Reading(columns={"P": "1"}, units={}),
        '{path}: one column cannot be two quantities, got P = column 1 "delta_nm", delta = column 1 "delta_nm"',
    ),
    "too few rows": (
        "delta_nm,P_nN\n1,1\n2,2\n", Reading(), "{path}: holds 2 rows (lines 2, 3), at least 3 are needed",
    ),
    "no rows": (
        "delta_nm,P_nN\n", Reading(),
        "{path}: holds no row of at least 2 numbers; give --separator and --decimal if they are unusual",
    ),
    "not a number": (GOOD + "4,nan\n", Reading(), "{path}: line 5: load must be finite, got nan (SI)"),
    "truncated": (GOOD + "4\n", Reading(), '{path}: line 5 must hold 2 numbers, got "4"' + MEND),
    "a second header": (
        GOOD + "delta_nm,P_nN\n", Reading(), '{path}: line 5 must hold 2 numbers, got "delta_nm,P_nN"' + MEND,
    ),
    "a unit in a cell": (GOOD + "4 nm,4\n", Reading(), '{path}: line 5 must hold 2 numbers, got "4 nm,4"' + MEND),
    "words where numbers stand": (
        "delta_nm,P_nN,segment\n1,1,up\n2,2,up\n3,?,up\n", Reading(),
        '{path}: line 4 must hold 2 numbers and 1 words, got "3,?,up"' + MEND,
    ),
    "negative radius": (
        "a_um,P_nN\n1,1\n-2,2\n3,3\n", Reading(),
        "{path}: line 3: contact radius must be finite and >= 0, got -2e-06 (SI)",
    ),
    "time that runs back": (
        "t_s,delta_nm,P_nN\n0,1,1\n2,2,2\n1,3,3\n", Reading(),
        "{path}: line 4: time must not run back, it falls from 2 to 1 s; several curves in one file need their column: "
        "--column curve=NAME",
    ),
    "nothing to flip": (
        "a_um,P_nN\n1,1\n2,2\n3,3\n", Reading(flip=frozenset({"delta"})),
        "{path}: holds no delta to flip or to set to zero (it holds a, P)",
    ),
    "a deflection without a load": (
        "a_um,delta_nm\n1,1\n2,2\n3,3\n", Reading(stiffness=1.0),
        "{path}: holds no load: the instrument's deflection P/stiffness cannot be subtracted",
    ),
}  # fmt: skip


@pytest.mark.parametrize("mistake", WRONG)
def test_mistakes_are_told_in_one_line(tmp_path: Path, mistake: str) -> None:
    text, reading, expected = WRONG[mistake]
    path = tmp_path / "m.csv"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        measured.read(path, reading)
    assert str(caught.value) == expected.format(path=path)


def test_segments_are_taken_by_their_words() -> None:
    curve = Curve("c", delta=DELTA, P=P, segment=np.array(WORDS), origin=Path("m.csv"))
    assert curve.only("retract").P.tolist() == P[2:].tolist()
    assert list(curve.segments()) == ["approach", "retract"]
    with pytest.raises(InputError, match=r'^m.csv: curve "c": has no rows of segment "hold" \(segments: appr'):
        curve.only("hold")
    with pytest.raises(InputError, match=r'^c: names no segments, cannot take "hold" alone$'):
        Curve("c", delta=DELTA, P=P).only("hold")


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"t": T}, "c: holds none of a, delta, P"),
        ({"a": A, "P": P[1:]}, "c: all columns must have the same length, got {'a': 4, 'P': 3}"),
        ({"a": A[None]}, "c: a: must be one-dimensional, got shape (1, 4)"),
        ({"P": np.array([1.0, np.inf])}, "c: P[1] is not finite"),
    ],
)
def test_a_curve_is_checked_when_it_is_made(columns: dict[str, np.ndarray], message: str) -> None:
    with pytest.raises(InputError) as caught:
        Curve("c", **columns)
    assert str(caught.value) == message


# ---------------------------------------------------------------------- zero points
def recorded(noise: float = 0.0, seed: int = 0) -> Curve:
    """An approach with a jump into contact of -3 nN at 5.0 um, stiffening to 40 nN at 6 um, and back."""
    z = np.linspace(0, 6e-6, 1201)
    depth = np.maximum(z - 5e-6, 0)
    load = np.where(depth > 0, -3e-9 + 4.3e-8 * (depth / 1e-6) ** 1.5, 0.0)
    drift = 2e-9 + 1e-3 * z
    P = load + drift + np.random.default_rng(seed).normal(0, noise, z.size) if noise else load + drift
    return Curve("c", delta=np.append(z, z[::-1]), P=np.append(P, P[::-1]))


@pytest.mark.parametrize("noise", [0.0, 2e-10])
def test_baseline_tilt_and_first_touch_are_found(noise: float) -> None:
    raw = recorded(noise)
    found = with_zero_points(raw)
    # Steps are 5 nm wide: half of one where noise is below the jump.
    np.testing.assert_allclose(raw.delta - found.delta, 5e-6, atol=2.6e-9)  # m
    # The line's error at its far end, of 1000 rows of noise: 2 sigma/sqrt(1000)
    np.testing.assert_allclose(found.P.max(), 4e-8, atol=4 * noise + 1e-15)  # N
    assert found.flags[0].startswith("contact point and force offset estimated from 99")
    tilt = float(found.flags[0].removesuffix(" N/m").rsplit(" ", 1)[1])
    np.testing.assert_allclose(tilt, 1e-3, atol=3 * noise / 1.4e-6 / 1000**0.5)  # N/m: 3 sigma, z spreads by 1.4 um


def test_zero_points_need_a_free_approach() -> None:
    raw = recorded()
    with pytest.raises(InputError, match=r"^c: a force curve needs displacement and load, the file has P$"):
        with_zero_points(Curve("c", P=raw.P))
    with pytest.raises(
        InputError, match=r"^c: the load of the approach never leaves its baseline: no contact was made$"
    ):
        with_zero_points(raw.rows(slice(0, 900)))
    with pytest.raises(InputError, match=r"^c: the approach has no free part to estimate contact point"):
        with_zero_points(raw.rows(slice(990, 1400)))
    with pytest.raises(InputError, match=r"^c: has no approach: contact point and force offset cannot be estimated$"):
        with_zero_points(raw.rows(slice(1201, None)))
    with pytest.raises(InputError, match=r"^c: has no approach \(segments: up\): contact point and force offset"):
        with_zero_points(replace(raw.rows(slice(0, 1201)), segment=np.full(1201, "up")))
    both = with_zero_points(replace(raw, segment=np.full(len(raw), "up")))  # what turns back holds both directions
    assert both.flags == with_zero_points(raw).flags


def test_a_detector_at_its_limit_is_seen() -> None:
    raw = recorded()
    assert raw.P is not None
    assert saturation_words(raw, saturation(raw)) == ()
    held = Curve("c", delta=raw.delta, P=np.minimum(raw.P, 3e-8))
    (said,) = saturation_words(held, saturation(held))
    assert "rows hold the same largest load, 30 nN" in said
