"""What is installed is pinned and checked; what is published holds all that is read; every system is tried."""

import itertools
import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

from jkrcli import __version__

ROOT = Path(__file__).parent.parent
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
CHECKED = ("--require-hashes", "--no-index", "--no-deps")  # by hashes, from what was, or this package alone
OTHERS = "-peers/", "-nanite/"  # other programs, in the versions that were compared


def test_what_make_installs_is_checked_by_hashes() -> None:
    lines = [
        line
        for line in MAKEFILE.splitlines()
        if re.search(r"pip (install|download)", line) and not any(other in line for other in OTHERS)
    ]
    assert len(lines) >= 5
    assert [line for line in lines if not any(option in line for option in CHECKED)] == []


@pytest.mark.parametrize("name", ["requirements.txt", ".ci/audit.txt"])
def test_every_pin_has_hashes_and_names_no_place(name: str) -> None:
    text = (ROOT / name).read_text(encoding="utf-8")
    pins = re.split(r"\n(?=\S)", text)
    assert len(pins) > 20
    assert [pin for pin in pins if not re.match(r"[\w.-]+==[^ ]+ (; .+)?\\\n    --hash=sha256:", pin)] == []
    assert "://" not in text


def test_what_the_package_reads_is_published() -> None:
    told = PROJECT["tool"]["setuptools"]["package-data"]
    held = {path for package, kinds in told.items() for kind in kinds
            for path in ROOT.joinpath(*package.split(".")).glob(kind)}  # fmt: skip
    here = {path for path in (ROOT / "jkrcli").rglob("*") if path.is_file() and "__pycache__" not in path.parts}
    assert {path for path in here if path.suffix != ".py"} == held


def test_what_make_and_examples_need_is_published() -> None:
    manifest = (ROOT / "MANIFEST.in").read_text(encoding="utf-8").split()
    named = set(re.findall(r"(?<=\s)(?:\.ci|cases|docs|tests|[A-Z]\w+\.md|\w+\.txt)\b", MAKEFILE))
    assert ".ci" in named
    assert named <= {*manifest, "README.md"}
    examples = [path for kinds in PROJECT["tool"]["setuptools"]["data-files"].values() for path in kinds]
    held = {path for kind in examples for path in ROOT.glob(kind)}
    assert held == {*ROOT.glob("cases/*.toml"), *ROOT.glob("cases/measured/*")}


def test_only_gmsh_depends_on_the_platform() -> None:
    """It has wheels for x86-64 and macOS alone, and its sources are no Python package."""
    limited = [line for line in PROJECT["project"]["dependencies"] if ";" in line]
    assert [line.partition(">")[0] for line in limited] == ["gmsh"]
    pinned = (ROOT / "requirements.txt").read_text(encoding="utf-8")
    assert re.search(r"^gmsh==[\d.]+ ; .*platform_machine == 'x86_64'", pinned, re.M)


def test_every_system_and_python_is_tried() -> None:
    yaml = pytest.importorskip("yaml")
    text = (ROOT / ".github/workflows/tests.yml").read_text(encoding="utf-8")
    job = yaml.safe_load(text)["jobs"]["tests"]
    assert {name.split("-")[0] for name in job["strategy"]["matrix"]["os"]} == {"ubuntu", "macos", "windows"}
    pythons = job["strategy"]["matrix"]["python"]
    assert PROJECT["project"]["requires-python"] == f">={pythons[0]}"
    told = [line.split()[-1] for line in PROJECT["project"]["classifiers"] if re.search(r":: 3\.", line)]
    assert told == pythons
    assert all((ROOT / name).exists() for name in re.findall(r"\.ci/[\w.-]+|requirements\.txt", text))


@pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")
@pytest.mark.parametrize(
    ("works", "words"),
    [
        ("50 40", ["50", "40"]),
        ("50 mJ/m^2", ["50mJ/m^2"]),
        ("40 mJ/m^2 50mJ/m^2 0.1", ["40mJ/m^2", "50mJ/m^2", "0.1"]),
        ("1; touch made", ["1;touchmade"]),
        ("1 $(shell touch made) `touch made` $$(touch made)", None),
        ("1 & touch made | 2 'x' > made", None),
    ],
)
def test_make_run_hands_works_on_as_they_stand(works: str, words: list[str] | None, tmp_path: Path) -> None:
    for name in ("Makefile", "requirements.txt", "pyproject.toml"):
        shutil.copy(ROOT / name, tmp_path)
    (tmp_path / ".venv" / "bin").mkdir(parents=True)
    script = tmp_path / ".venv" / "bin" / "jkr"
    script.write_text('#!/bin/sh\nfor word in "$@"; do echo "<$word>" >> words; done\n')
    script.chmod(0o755)
    made = ["make", "-s", "-o", ".venv/.ready", "run", "CASE=Bob's case.toml", "RESULTS=Anna's results", f"W={works}"]
    subprocess.run(made, cwd=tmp_path, check=True, capture_output=True)
    held = (tmp_path / "words").read_text().splitlines()
    assert held[:4] == ["<run>", "<Bob's case.toml>", "<-o>", "<Anna's results/Bob's case.h5>"]
    assert (tmp_path / "Anna's results").is_dir()
    given = [word[1:-1] for option, word in itertools.pairwise(held) if option == "<--w>"]
    assert words is None or given == words
    assert "".join(given) == works.replace(" ", "")
    assert not (tmp_path / "made").exists()


def test_the_container_copies_what_is_there_and_installs_by_hashes() -> None:
    lines = (ROOT / "docs/install/Containerfile").read_text(encoding="utf-8").splitlines()
    steps = [line.split(maxsplit=1) for line in lines if line and not line.startswith("#")]
    assert {name for name, _ in steps} == {"FROM", "WORKDIR", "COPY", "RUN", "ENTRYPOINT"}
    copied = [path for name, words in steps if name == "COPY" for path in words.split()[:-1]]
    assert copied
    assert all((ROOT / path).exists() for path in copied)
    installs = [words for name, words in steps if name == "RUN" and "pip install" in words]
    assert len(installs) == 2
    assert all(any(option in words for option in CHECKED) for words in installs)


def test_the_conda_environment_has_the_pinned_packages_and_every_python() -> None:
    yaml = pytest.importorskip("yaml")
    path = ROOT / "docs/install/environment.yml"
    told = yaml.safe_load(path.read_text(encoding="utf-8"))
    (python,) = (word for word in told["dependencies"] if str(word).startswith("python "))
    assert python.split()[1].split(",")[0] == PROJECT["project"]["requires-python"]
    (pip,) = (entry["pip"] for entry in told["dependencies"] if isinstance(entry, dict))
    assert [(path.parent / line.split()[1]).resolve() for line in pip] == [ROOT / "requirements.txt"]


PAPER = (ROOT / "paper.md").read_text(encoding="utf-8")
SECTIONS = ["Summary", "Statement of need", "State of the field", "Software design", "Research impact statement",
            "AI usage disclosure", "Acknowledgements", "References"]  # fmt: skip


def test_the_paper_has_the_journal_s_form_and_every_reference() -> None:
    text = PAPER.split("---\n", 2)[2]
    assert re.findall(r"^# (.+)$", text, re.M) == SECTIONS
    assert 750 <= len(text.split()) <= 1750
    cited = set(re.findall(r"@(\w+)", text))
    assert cited == set(re.findall(r"^@\w+\{(\w+),", (ROOT / "paper.bib").read_text(encoding="utf-8"), re.M))


def test_figures_of_the_paper_stand_on_pages_beside_their_commands() -> None:
    pages = "\n".join(page.read_text(encoding="utf-8") for page in [ROOT / "README.md", *ROOT.glob("docs/**/*.md")])
    figures = re.findall(r"\d[\d.]*e-\d+|\d+(?:\.\d+)? %|(?<=\| )[\d.]+(?= \|)", PAPER)
    assert len(figures) >= 10
    assert [figure for figure in figures if figure not in pages] == []
    targets = set(re.findall(r"^([a-z-]+):", MAKEFILE, re.M))
    assert set(re.findall(r"`make ([a-z-]+)", PAPER)) <= targets


def test_a_release_has_one_version_date_and_author() -> None:
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    version, date = (re.search(rf"^{key}: (.+)$", citation, re.M) for key in ("version", "date-released"))
    assert version is not None
    assert date is not None
    heading = re.search(r"^## (.+) \((.+)\)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.M)
    assert heading is not None
    assert heading.groups() == (version[1], date[1])
    assert (version[1], PROJECT["project"]["dynamic"]) == (__version__, ["version"])
    author = "The jkr contributors"
    assert f"- name: {author}\n" in PAPER
    assert f'- name: "{author}"\n' in citation
    assert PROJECT["project"]["authors"] == [{"name": author}]
