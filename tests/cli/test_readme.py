"""The README is run: every ``sh`` and ``python`` block, in order, in one empty folder with the shipped cases.

A block that takes long or needs what is not here is marked by the line before it: ``<!-- not run: why -->``.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from jkrcli.cli import VERBS
from jkrcli.cli.study import STUDIES

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text()
BLOCK = re.compile(r"(?:^<!-- (?P<mark>not run: [^\n]+) -->\n)?^```(?P<kind>\w+)\n(?P<text>.*?)^```$", re.M | re.S)


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, its text, and why it is not run."""

    kind: str
    text: str
    mark: str | None


BLOCKS = [Block(found["kind"], found["text"], found["mark"]) for found in BLOCK.finditer(README)]


@pytest.mark.slow
def test_every_unmarked_block_runs(tmp_path: Path) -> None:
    (tmp_path / "cases").symlink_to(ROOT / "cases")
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    done = 0
    for block in BLOCKS:
        if block.mark or block.kind not in ("sh", "python"):
            continue
        command = ["bash", "-euo", "pipefail", "-c"] if block.kind == "sh" else [sys.executable, "-c"]
        run = subprocess.run([*command, block.text], capture_output=True, text=True, cwd=tmp_path, timeout=300,
                             env={**os.environ, "PATH": path})  # fmt: skip
        assert run.returncode == 0, f"{block.text}\n{run.stderr}"
        done += 1
    assert done >= 3


def test_toml_blocks_are_whole_and_valid_cases() -> None:
    from jkrcli.case import parse_case

    cases = [block.text for block in BLOCKS if block.kind == "toml" and not block.mark]
    assert cases
    for text in cases:
        parse_case(text.encode(), "README.md").model.problem()


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_stands_in_the_readme(verb: str) -> None:
    assert f"jkr {verb}" in README


@pytest.mark.parametrize("study", STUDIES)
def test_every_study_stands_in_the_readme(study: str) -> None:
    assert f"`{study}`" in README


def test_every_picture_exists() -> None:
    pictures = re.findall(r"!\[[^\]]*\]\(([^)]+)\)", README)
    assert pictures
    for picture in pictures:
        assert (ROOT / picture).is_file(), picture


def test_every_make_target_named_exists() -> None:
    targets = set(re.findall(r"^([a-z-]+):.*## ", (ROOT / "Makefile").read_text(), re.M))
    named = set(re.findall(r"(?:`|^ *)make ([a-z][a-z-]+)", README, re.M))
    assert {"run", "test"} <= named
    assert named <= targets, named - targets
