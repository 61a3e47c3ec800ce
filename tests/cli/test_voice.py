"""What a verb says while it works: what it will take where that is long, a bar on terminals."""

import io
import math

import click
import pytest

from jkrcli.base.process import SILENCE
from jkrcli.cli.printing import announce, progress


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("stream", [Terminal(), io.StringIO()], ids=["terminal", "file"])
def test_progress_is_shown_on_terminals_alone(monkeypatch: pytest.MonkeyPatch, stream: io.StringIO) -> None:
    monkeypatch.setattr("sys.stderr", stream)
    with progress("cases", 2, 1.0) as step:
        step(False)
        step(True)
    if stream.isatty():
        assert stream.getvalue().splitlines()[-1].rstrip("\x1b[?25h ").endswith("2/2  1 failed")
        assert "1/2" in stream.getvalue()
    else:
        assert stream.getvalue() == ""


@pytest.mark.parametrize("seconds", [SILENCE, math.inf, math.nan])
def test_what_is_short_or_unknown_is_not_announced(seconds: float, capsys: pytest.CaptureFixture[str]) -> None:
    with progress("cases", 1, seconds):
        pass
    assert capsys.readouterr().err == ""


def test_a_command_announces_its_time_once(capsys: pytest.CaptureFixture[str]) -> None:
    for _ in range(2):
        with click.Context(click.Command("x")):
            announce("all", 60.0)
            with progress("a part", 2, 40.0):
                pass
    assert capsys.readouterr().err == "jkr: all: about 60 s of CPU time\n" * 2
