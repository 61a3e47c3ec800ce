"""Shared by all tests: the command line in process, and other constants for the length of one test."""

import importlib
import json
import os
import shutil
import signal
import sys
import tomllib
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import numpy as np
import pytest

from jkrcli.base.errors import InputError
from jkrcli.base.wings import PACKAGE, wings
from jkrcli.cli import call

ABSENT = {*tomllib.loads((PACKAGE / "wings.toml").read_text(encoding="utf-8"))} - {wing.name for wing in wings()}
NO_PACKAGES = not all(find_spec(module) for module in ("gmsh", "skfem", "meshio"))
NO_FEM = NO_PACKAGES or "fem" in ABSENT
# What an error says of packages, or in ``make core`` of wings, that are missing here:
MISSING = [
    *["finite elements need packages"] * NO_PACKAGES,
    *["the optional package plotly"] * (find_spec("plotly") is None),
    *[f'needs the wing "{name}"' for name in ABSENT],
]
CASES = Path(__file__).parent.parent / "cases"


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--fuzz-seed", type=int, default=20_000, help="Of the inputs that tests draw (make fuzz SEED=...)."
    )


def pytest_configure() -> None:
    """Ctrl-C is minded even in the background of a shell, where what is started would ignore it and tests of it pass
    whatever happens. What is compiled is kept, whatever the environment says: hundreds of processes start the package,
    and each worker reads all tests."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    sys.dont_write_bytecode = False
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    if MISSING:
        _skip_what_is_missing()


def _skip_what_is_missing() -> None:
    """A test, or a module of tests that is read, ends as skipped where it is told that plotly, the packages of finite
    elements, or a wing are missing. Tests that ask for fem in other processes, or only find it in a list of methods,
    are marked ``fem``."""
    plain = InputError.__init__

    def told(error: InputError, lines: str | Sequence[str]) -> None:
        plain(error, lines)
        if (missing := next((words for words in MISSING if words in str(error)), None)) is not None:
            pytest.skip(f"needs {missing}", allow_module_level=True)

    InputError.__init__ = told


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Of a test marked ``first(n)`` the fast tests take the first n sets of parameters; those marked ``fem`` are
    skipped where its packages or its wing are missing."""
    taken: Counter[str] = Counter()
    for item in items:
        if NO_FEM and item.get_closest_marker("fem"):
            item.add_marker(pytest.mark.skip(reason="needs finite elements"))
        if (mark := item.get_closest_marker("first")) is not None:
            taken[(test := item.nodeid.partition("[")[0])] += 1
            if taken[test] > mark.args[0]:
                item.add_marker("slow")


@pytest.fixture(autouse=True)
def _coarse_pictures(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures of few pixels, but where pictures are what is tested: to encode those of print is a tenth of all."""
    plots = sys.modules.get("jkrcli.report.plots")
    if plots is not None and "report" not in request.path.parts:
        monkeypatch.setattr(plots, "DPI", 40)


@pytest.fixture(autouse=True)
def _whole_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    """No line that is printed is folded, so that tests find their sentences."""
    monkeypatch.setenv("COLUMNS", "10000")


@pytest.fixture(name="seed")
def _seed(request: pytest.FixtureRequest) -> int:
    """What random inputs are drawn from: the same in every run that does not ask for others."""
    return int(request.config.getoption("--fuzz-seed"))


@dataclass(frozen=True)
class Outcome:
    """What a command left behind."""

    code: int
    out: str
    err: str

    @property
    def told(self) -> Any:
        """What a command that ended well printed as JSON."""
        assert self.code == 0, self.err
        return json.loads(self.out)

    @property
    def ok(self) -> "Outcome":
        """The outcome of a command that ended well."""
        assert self.code == 0, self.err
        return self

    def refused(self, *said: str) -> None:
        """Is a command that was refused in one line, which holds what is ``said``."""
        assert (self.code, self.out, self.err.count("\n")) == (2, "", 1), self
        assert self.err.startswith("jkr: error: "), self
        for words in said:
            assert words in self.err


def refused_by(call: Callable, *given: Any, **named: Any) -> tuple[str, ...]:
    """The lines in which a call refuses what is given."""
    with pytest.raises(InputError) as caught:
        call(*given, **named)
    return caught.value.lines


@pytest.fixture(name="jkr")
def _jkr(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Outcome]:
    """Run ``jkr`` in an empty folder and return exit code, stdout and stderr; of the core alone (``make core``) what
    needs a wing is skipped."""
    monkeypatch.chdir(tmp_path)

    def run(*words: object) -> Outcome:
        code = call([str(word) for word in words])
        captured = capsys.readouterr()
        if code == InputError.exit_code and 'needs the wing "' in captured.err:
            pytest.skip(captured.err)
        return Outcome(code, captured.out, captured.err)

    return run


@pytest.fixture(name="series")
def _series(jkr: Callable[..., Outcome], tmp_path: Path) -> Path:
    """A solved case, s.toml, beside its file."""
    from series_files import CASE

    (tmp_path / "s.toml").write_text(CASE)
    assert jkr("run", "s.toml").code == 0
    return tmp_path / "s.h5"


@pytest.fixture(name="browser", scope="module")
def _browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """A headless Chromium with its log, that saves into the folder ``downloads``; skipped where there is none."""
    webdriver = pytest.importorskip("selenium.webdriver")
    binary, server = shutil.which("chromium"), shutil.which("chromedriver")
    if not (binary and server):
        pytest.skip("chromium and chromium-driver are not installed")
    options = webdriver.ChromeOptions()
    options.binary_location = binary
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    downloads = tmp_path_factory.mktemp("downloads")
    options.add_experimental_option("prefs", {"download.default_directory": str(downloads)})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(server))
    driver.downloads = downloads
    yield driver
    driver.quit()


def write_table(path: Path | str, header: str, *columns: Sequence[float], form: str = "%.17g", mark: str = ",") -> Path:
    """Write columns of numbers below a ``header`` line."""
    np.savetxt(path, np.column_stack(columns), form, mark, header=header, comments="")
    return Path(path)


MEDIA = [("screen", 400), ("screen", 1280), ("print", 720)]  # pixels; A4 within its margins


def shown_at(browser: Any, width: int, media: str = "screen") -> None:
    """Show pages of a ``browser`` on a ``media`` of a ``width`` [pixels]."""
    metrics = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": media})


@pytest.fixture(name="tuned")
def _tuned(monkeypatch: pytest.MonkeyPatch) -> Callable[[str, object], None]:
    """Set a module's constant for the length of a test, there and where it is imported, by its dotted name, as in
    ``tuned("jkrcli.fem.mesh.LAYOUT_MOST_CELLS", 4000)``."""

    def change(name: str, value: object) -> None:
        usual, last = resolve_name(name), name.rpartition(".")[2]
        for module in [item for loaded, item in sys.modules.items() if loaded.startswith(("jkrcli", "studies"))]:
            if vars(module).get(last) is usual:
                monkeypatch.setattr(module, last, value)

    return change


@pytest.fixture(name="study")
def _study(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Outcome]:
    """Run one of the studies that make starts, by its name, in an empty folder; exit code, stdout and stderr."""
    from studies import command

    monkeypatch.chdir(tmp_path)

    def run(name: str, *words: object) -> Outcome:
        module = importlib.import_module(f"studies.{name}")
        code = command.call(module.main, [str(word) for word in words])
        captured = capsys.readouterr()
        return Outcome(code, captured.out, captured.err)

    return run


@pytest.fixture(name="no_pictures")
def _no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of sweeps are drawn in test_sweep_figure.py: each takes longer than the sweeps."""
    monkeypatch.setattr("jkrcli.many.sweep.sweep_figure", lambda *_: None)


@pytest.fixture(name="solves")
def _solves(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """The problems that are really solved, in order."""
    seen: list[object] = []

    from jkrcli.methods.closed_form import ClosedForm
    from jkrcli.methods.layered.solver import Layered

    def counted(plain: Callable) -> Callable:
        return lambda method, body: seen.append(body.key) or plain(method, body)

    for kind in (ClosedForm, Layered):
        monkeypatch.setattr(kind, "__call__", counted(kind.__call__))
    return seen
