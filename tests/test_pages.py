"""README and the pages of the documentation: what they show is run, what they name exists.

Every ``sh`` and ``python`` block of a page is run, in order, in one empty folder with the shipped cases. A ``text``
block after an ``sh`` block is what that prints: each of its lines must be there. A block that takes long or needs what
is not here is marked by the line before it: ``<!-- not run: why -->``.
"""

import itertools
import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import click
import pytest

from jkrcli.cli import VERBS, jkr
from jkrcli.many.verbs import STUDIES

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
GENERATED = ROOT / "docs" / "reference" / "verbs"  # by ``make docs``
PAGES = [README, *sorted(page for page in (ROOT / "docs").rglob("*.md") if page.parent != GENERATED)]
GIVEN = ("cases", "docs", "tests", "Makefile")  # what a page may name
BLOCK = re.compile(r"(?:^<!-- (?P<mark>not run: [^\n]+) -->\n)?^```(?P<kind>\w+)\n(?P<text>.*?)^```$", re.M | re.S)
PICTURE = re.compile(r"!\[[^\]]*\]\(([^)]+)\)")
LINK = re.compile(r"(?<!!)\[[^\]]*\]\(([^)#]+)(?:#[^)]*)?\)")


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, its text, and why it is not run."""

    kind: str
    text: str
    mark: str | None


def blocks(page: Path) -> list[Block]:
    found = BLOCK.finditer(page.read_text(encoding="utf-8"))
    return [Block(one["kind"], one["text"], one["mark"]) for one in found]


def name_of(page: Path) -> str:
    return str(page.relative_to(ROOT))


RUN = [page for page in PAGES if any(b.kind in ("sh", "python") and not b.mark for b in blocks(page))]


@pytest.mark.slow
@pytest.mark.parametrize("page", RUN, ids=name_of)
def test_every_unmarked_block_runs_and_prints_what_the_page_shows(page: Path, tmp_path: Path) -> None:
    for given in GIVEN:
        (tmp_path / given).symlink_to(ROOT / given)
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}", "COLUMNS": "120"}
    printed = ""
    for block in blocks(page):
        if block.kind == "text" and not block.mark:
            missing = [line for line in shown(block) if line not in printed]
            assert missing == [], printed
        if block.mark or block.kind not in ("sh", "python"):
            continue
        command = ["bash", "-euo", "pipefail", "-c"] if block.kind == "sh" else [sys.executable, "-c"]
        run = subprocess.run([*command, block.text], capture_output=True, text=True, cwd=tmp_path, timeout=300,
                             env=environment)  # fmt: skip
        assert run.returncode == 0, f"{block.text}\n{run.stderr}"
        printed = run.stdout + run.stderr


def shown(block: Block) -> list[str]:
    """The lines of a block; "..." stands for lines left out."""
    return [line.rstrip() for line in block.text.splitlines() if line.strip() not in ("", "...")]


def test_toml_blocks_are_whole_and_valid_cases() -> None:
    from jkrcli.case.models import parse_case, parse_toml, validated
    from jkrcli.many.sweep_file import SweepModel

    found = [(page, block) for page in PAGES for block in blocks(page) if block.kind == "toml" and not block.mark]
    assert any(page == README for page, _ in found)
    for page, block in found:
        if re.search(r"^base =", block.text, re.M):
            validated(SweepModel, parse_toml(block.text.encode(), name_of(page)), name_of(page))
        else:
            parse_case(block.text.encode(), name_of(page)).model.problem()


def test_readme_and_changes_are_short() -> None:
    readme, changes = (page.read_text(encoding="utf-8").splitlines() for page in (README, ROOT / "CHANGELOG.md"))
    assert len(readme) <= 120
    assert [line for line in readme + changes if len(line) > 120] == []


WAYS = ("jkr transform", "jkr import", "jkr fit")  # a case, a finite-element solution, a force curve


@pytest.mark.parametrize("command", WAYS)
def test_readme_shows_each_way_to_w_with_what_it_prints(command: str) -> None:
    found = blocks(README)
    shown_by = [after for block, after in itertools.pairwise(found) if block.kind == "sh" and command in block.text]
    assert any(after.kind == "text" and not after.mark for after in shown_by)


def test_readme_begins_with_two_commands_and_names_the_paper_s() -> None:
    text = README.read_text(encoding="utf-8")
    assert text.index("make run") < text.index("make test") < min(text.index(way) for way in ("jkr import", "jkr fit"))
    assert "make paper" in text


def prose(page: Path) -> str:
    text = page.read_text(encoding="utf-8")
    return re.sub(r"(?ms)^```.*?^```$|^\$\$$.*?^\$\$$|<!--.*?-->", "", text)


def test_pages_for_users_stay_short() -> None:
    pages = [page for page in PAGES if page.parent.name != "project"]
    assert sum(len(prose(page).split()) for page in pages) <= 14_500


def test_every_verb_is_used_on_a_page() -> None:
    text = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
    assert [verb for verb in (*VERBS, *(f"study {name}" for name in STUDIES)) if f"jkr {verb}" not in text] == []


def test_every_option_in_a_line_of_text_is_one_of_its_verb() -> None:
    """Commands in tables are not run; a misspelt option of theirs is found here."""
    lines = [line for page in PAGES for line in re.findall(r"`jkr ([a-z-]+ [^`]*)`", prose(page))]
    assert len(lines) >= 30
    wrong = []
    for line in lines:
        verb, *words = line.split()
        command = jkr.get_command(click.Context(jkr), verb)
        if isinstance(command, click.Group):
            command = command.get_command(click.Context(command), words[0])
        known = {option for parameter in getattr(command, "params", ()) for option in parameter.opts}
        wrong += [line for word in words if word.startswith("--") and word not in known]
    assert wrong == []


def test_every_picture_and_every_link_to_a_file_leads_somewhere() -> None:
    texts = {page: page.read_text(encoding="utf-8") for page in PAGES}
    assert PICTURE.search(texts[README])
    links = [(page, link) for page, text in texts.items() for link in PICTURE.findall(text) + LINK.findall(text)]
    lost = [(name_of(page), link) for page, link in links if "://" not in link and not (page.parent / link).exists()]
    assert lost == []


def test_every_make_target_named_exists() -> None:
    targets = set(re.findall(r"^([a-z-]+):.*#[#:] ", (ROOT / "Makefile").read_text(), re.M))
    text = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
    named = set(re.findall(r"(?:`|^ *)make ([a-z][a-z-]+)", text, re.M))
    assert {"run", "test", "docs", "validation"} <= named
    assert named <= targets, named - targets


def test_every_function_named_in_the_theory_exists() -> None:
    named = [
        (name_of(page), place, name)
        for page in (*(ROOT / "docs" / "theory").glob("*.md"), ROOT / "docs" / "project" / "computation.md")
        for place, name in re.findall(r"`([\w/]+\.py): (\w+)`", page.read_text(encoding="utf-8"))
    ]
    assert len(named) >= 30
    for page, place, name in named:
        text = (ROOT / "jkrcli" / place).read_text(encoding="utf-8")
        assert re.search(rf"^\s*(?:def|class) {name}\b|^{name}\b", text, re.M), (page, place, name)


def test_every_fraction_has_braces() -> None:
    """The converter to MathML takes digits together: it would read 32 over pi in a three halves pi without them."""
    bare = [name_of(page) for page in PAGES if re.search(r"\\[dt]?frac(?!\{)", page.read_text(encoding="utf-8"))]
    assert bare == []


def test_keys_of_a_case_are_told_with_unit_and_range() -> None:
    """The page of the keys is made from the models: a change of their types once left "a number" of all of them."""
    from site_parts.keys import page

    rows = page().splitlines()
    for row in (
        "| `E` | a modulus (Pa) > 0 or a law over the depth | required |",
        "| `nu` | a number > -1 and <= 0.5 | required |",
        "| `thickness` | a length (m) > 0 | required |",
        "| `w` | a work of adhesion (J/m^2) >= 0, or a list of several | left out |",
        "| `radius` | a length (m) > 0, or a list of several | left out |",
        "| `humidity` | a number > 0 and < 1 | left out |",
    ):
        assert row in rows
    bare = {row.split("`")[1] for row in rows if "| a number |" in row}
    assert bare == {"exponent", "nu_zp"}  # of any size: a law's exponent, a ratio that energy bounds
