"""What a verb says while it works: a bar on terminals, nothing elsewhere."""

from __future__ import annotations

import io

import pytest

from jkrcli.cli.voice import progress


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("stream", [Terminal(), io.StringIO()], ids=["terminal", "file"])
def test_progress_is_shown_on_terminals_alone(monkeypatch: pytest.MonkeyPatch, stream: io.StringIO) -> None:
    monkeypatch.setattr("sys.stderr", stream)
    with progress("cases", 2) as step:
        step(False)
        step(True)
    if stream.isatty():
        assert stream.getvalue().splitlines()[-1].rstrip("\x1b[?25h ").endswith("2/2  1 failed")
        assert "1/2" in stream.getvalue()
    else:
        assert stream.getvalue() == ""
