"""Raw force curves of force_curves.py as they are read, and the half-spaces that they are fitted as."""

from pathlib import Path

import numpy as np

from jkrcli.adhesion.slopes import slopes
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Loading, Problem, Specimen
from jkrcli.measured.curve import Curve
from jkrcli.measured.forward_model import FittedBody
from jkrcli.measured.result import Fit
from jkrcli.measured.settings import Settings, settings_of
from jkrcli.methods.closed_form import ClosedForm

R = 5e-6


def body(E_star: float = 1e3, a: float = 1e-6, R: float = R) -> FittedBody:
    """A paraboloid ``R`` [m] on an incompressible half-space, solved to the contact radius ``a`` [m]."""
    problem = Problem(Paraboloid(R), Specimen((), HalfSpace(Elastic(0.75 * E_star, 0.5))), Loading("radius", a, 60))
    series = ClosedForm()(problem).series
    return FittedBody.of(problem, series, slopes(series), extensible=True)


BODY = body()


def usual(body: FittedBody = BODY, **options: object) -> Settings:
    return settings_of(body, **options)


def read(columns: dict[str, np.ndarray], k: float, *told: str, P: np.ndarray | None = None) -> Curve:
    """The readings of a device of stiffness ``k`` [N/m]; ``told``: columns beside delta and P; other loads ``P``."""
    P = columns["P"] if P is None else P
    return Curve("made", delta=columns["z"] - P / k, P=P, stiffness=k, **{name: columns[name] for name in told})


def export(
    path: Path, made: dict[str, np.ndarray], head: str = "# springConstant: 0.3", signal: str = "force (nN)"
) -> Path:
    """Write a record below the lines of its ``head``; a ``signal`` of loads [nN], or of what stands for them."""
    rows = zip(made["z"] * 1e6, made["P"] * 1e9, made["segment"], strict=True)
    text = "".join(f"{z:.7g},{P:.7g},{word}\n" for z, P, word in rows)
    path.write_text(f"{head}\npiezo (um),{signal},segment\n{text}")
    return path


def inside(found: Fit, name: str, true: float) -> bool:
    """Whether an interval, which may have one end or none, holds the truth."""
    item = found.estimate(name)
    return (-np.inf if item.low is None else item.low) <= true <= (np.inf if item.high is None else item.high)
