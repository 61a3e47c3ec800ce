"""jkr in a browser: verbs without what Pyodide lacks, and the page that ``make docs`` builds, in Chromium."""

import contextlib
import http.server
import json
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from conftest import MEDIA, shown_at

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "site_parts" / "browser_page"
BODY = "--radius 5um --E 1MPa --nu 0.5 --w 50mJ/m^2"
COMMANDS = {  # each with what it prints
    "jkr new case.toml": "case.toml",
    "jkr check case.toml": "layered",
    "jkr run case.toml -o data.h5": "data.h5",
    "jkr show data.h5": "method",
    "jkr transform data.h5 --w 50mJ/m^2": ".svg",
    f"jkr pull-off {BODY}": "1.14 uN",
    "jkr cycle data.h5": "data-cycle",
    "jkr profile data.h5 --a 5um": "data-profile",
    "jkr export data.h5 --dem": "data-dem",
    "jkr new --example raw-force-curve": "raw-force-curve.txt",
    "jkr look raw-force-curve.txt": "adhesion force",
    "jkr fit raw-force-curve.txt --radius 5um --nu 0.5": "E* = ",
}
LACKING = {
    "fcntl", "resource", "termios", "grp", "pwd", "_multiprocessing", "_posixshmem", "psutil", "gmsh", "skfem",
    "meshio",
}  # fmt: skip
WITHOUT = f"""
import json, os, subprocess, sys, threading

class Others:
    def __init__(self, finders):
        self.finders = finders

    def find_spec(self, name, *more):
        if name.split(".")[0] not in {LACKING}:
            return next(filter(None, (finder.find_spec(name, *more) for finder in self.finders)), None)

def no_thread(*_, **__):
    raise RuntimeError("can't start new thread")

def no_process(*_, **__):
    raise OSError(138, "emscripten does not support processes.")

sys.meta_path = [Others(sys.meta_path)]
for name in {LACKING}:
    sys.modules.pop(name, None)
threading.Thread.start, subprocess.Popen.__init__ = no_thread, no_process
for name in ("fork", "forkpty", "posix_spawn", "posix_spawnp"):
    delattr(os, name)
sys.path.append({str(PAGE)!r})
import session
print(json.dumps([session.run(words) for words in sys.argv[1:]]))
"""


def in_a_browser(*commands: str) -> list[dict[str, Any]]:
    """What the ``commands`` answer where nothing is there that the browser's Python lacks."""
    done = subprocess.run([sys.executable, "-c", WITHOUT, *commands], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def test_verbs_work_without_threads_processes_locks_and_mesher(tmp_path: Path, monkeypatch) -> None:
    """Mistakes are lines, files those that are new."""
    monkeypatch.chdir(tmp_path)
    wrong = ('pull-off "5', "run case.toml --method fem -o fem.h5")
    *found, open_, elements = in_a_browser(*COMMANDS, *wrong)
    for (command, words), answer in zip(COMMANDS.items(), found, strict=True):
        assert (answer["code"], words in answer["text"]) == (0, True), f"{command}: {answer['text']}"
    assert Path("data-w0.05.svg").is_file()
    assert [answer["files"] for answer in found[:2]] == [["case.toml"], []]
    assert (open_["code"], elements["code"], elements["files"]) == (2, 2, [])
    assert "No closing quotation" in open_["text"]
    assert "gmsh" in elements["text"]


@contextlib.contextmanager
def served(folder: Path) -> Iterator[str]:
    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_: object) -> None:
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=folder))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/index.html"
    finally:
        server.shutdown()


@pytest.mark.slow
def test_the_page_runs_commands_or_says_which_part_of_the_runtime_is_missing(tmp_path, monkeypatch, browser) -> None:
    """With the folder PYODIDE of a whole release the page answers; with a part of it it names what is missing."""
    pytest.importorskip("sphinx")
    monkeypatch.syspath_prepend(ROOT / "docs")
    from site_parts import browser as built

    given = os.environ.get("PYODIDE")
    built.write(tmp_path / "page", Path(given) if given else None)
    wait = pytest.importorskip("selenium.webdriver.support.wait").WebDriverWait(browser, 180)

    def state() -> str:
        return browser.find_element("id", "state").text

    with served(tmp_path / "page") as address:
        for media, width in MEDIA:
            shown_at(browser, width, media)
            browser.get(address)
            wait.until(lambda _: not state().startswith("Loading"))
            assert browser.execute_script("return document.documentElement.scrollWidth") <= width
        if not given:
            assert "make docs PYODIDE=folder" in state()
            assert browser.get_log("browser") == []
        elif "lacks" in state():
            assert "numpy" in state()
        else:
            browser.find_element("id", "go").click()
            wait.until(lambda _: state().startswith(("Ready", "Exit")))
            assert "pull-off force 1.14 uN" in browser.find_element("id", "text").text
            assert browser.get_log("browser") == []
        browser.get((tmp_path / "page" / "index.html").as_uri())
        assert "http.server" in state()
