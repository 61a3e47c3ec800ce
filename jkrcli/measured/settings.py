"""Settings of a fit: parameters with units and bounds, rows, noise, loss and confidence; from what a user types."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Annotated, Any, TypeAlias

from ..base.arguments import PerName, read_fields
from ..base.errors import LEVEL, InputError
from ..base.units import Force, Length, Named, Ranged, Tension, texts_of
from ..bodies.problem import RADIUS, checked_names
from . import priors
from .choices import BaseLineName, BranchName, ConfidenceName, ContactName, Loss, ModelName, SegmentName
from .forward_model import FittedBody
from .parameters import ALIAS, DIMENSIONS, OF_A_CYCLE, OF_TRAVEL, POSITIONS, Level, Parameter, dimension_of, read_value

AUTO: ModelName = "auto"
TENSION = "surface_tension"  # a bound of what is left out
RANGES = ("range", "stress")  # one of them: adhesion of finite range; neither: JKR
CALIBRATED = ("stiffness", "sensitivity")  # of a device, relative: what its loads are made from
USUALLY_FREE = ("modulus", "w", "delta0")
LEFT_OUT = ("range", TENSION)  # of adhesion and of the solid, where JKR is fitted: known up to a largest value
BETWEEN = ".."  # the ends of bounds


Noise: TypeAlias = Annotated[Mapping[str, float], PerName({"a": Length, "delta": Length, "P": Force})]
AS_IN_THE_CASE = {"modulus": 1.0, "delta0": 0.0, "P0": 0.0, "compliance": 0.0}


@dataclass(frozen=True)
class Settings:
    """All that determines a fit of a curve.

    ``parameters``: in the order of the tables; w must be among them, of the other common ones those that are left out
    are fixed as in the case. ``segment``: None takes both directions where the curve names them, else all rows.
    ``noise``: standard deviation of the readings by column, SI; those left out are estimated from the record.
    ``level``: of the confidence intervals. ``uncertain``: standard deviations of inputs of the body ("nu:film",
    "h:film", "radius", SI) and, relative, of a device ("stiffness", "sensitivity"), carried through. ``samples,
    seed``: of the bootstrap.
    ``contact``: "fitted": base line and contact point are fitted with the rest (``record``), "auto": where the curve is
    a raw record, else readings as they are. ``base_line`` of a raw record: "sine": with a wave by interference.
    ``model`` of a raw record: "auto" fits the best alternatives in full where the data favour one.
    ``named``: the parameters that the user frees or fixes. ``range_at_most`` [m]: what is known of the range of
    adhesion where JKR is fitted, else its prior's width is likely; ``tension_at_most`` [N/m]: of a surface tension that
    is left out.
    """

    parameters: tuple[Parameter, ...]
    segment: SegmentName | None = None
    branch: BranchName = "all"
    noise: Noise = field(default_factory=dict)
    loss: Loss = "linear"
    confidence: ConfidenceName = "covariance"
    level: Level = LEVEL
    uncertain: Mapping[str, float] = field(default_factory=dict)
    samples: Annotated[int, Ranged("number", least=20, most=100_000)] = 200
    seed: Annotated[int, Ranged("number", least=0)] = 0
    contact: ContactName = "auto"
    base_line: BaseLineName = "straight"
    model: ModelName = "jkr"
    named: frozenset[str] = frozenset()
    range_at_most: Annotated[float, Ranged("length", above=0, words=(("inf", math.inf),))] = math.inf
    tension_at_most: Tension = 0.0

    def __post_init__(self) -> None:
        read_fields(self, "fit")
        object.__setattr__(self, "named", self.named or frozenset(parameter.name for parameter in self.parameters))
        if "w" not in self.named:
            raise InputError("fit: w must be free or fixed at a value")
        named = {parameter.name for parameter in self.parameters}
        left_out = (Parameter(name, False, value) for name, value in AS_IN_THE_CASE.items() if name not in named)
        object.__setattr__(self, "parameters", (*self.parameters, *left_out))
        for wrong in self._wrong():
            raise InputError(f"fit: {wrong}")

    def _wrong(self) -> Iterator[str]:
        """Messages on settings that contradict each other."""
        if not self.free:
            yield "no parameter is free"
        for item in self.parameters:
            if item.name in OF_TRAVEL and item.value is not None and not -1 < item.value < 1:
                yield f"{item.name} is a fraction of the travel, must be > -1 and < 1, got {item.value:g}"
        if self.range is not None:
            if set(RANGES) <= self.named:
                yield "range and stress are one quantity, stress = w/range: free or fix one of them"
            if own := [p.name for p in self.free if p.of_body]:
                yield f"{own[0]} cannot be free together with a range of adhesion: fix {own[0]}"
            if self.known("w").value == 0:
                yield "adhesion of finite range needs w > 0: leave w free, or range and stress out"

    @property
    def range(self) -> Parameter | None:
        """The parameter that says how far adhesion reaches; None: JKR."""
        return next((parameter for parameter in self.parameters if parameter.name in RANGES), None)

    @property
    def positions(self) -> tuple[str, ...]:
        """The errors of positions that there are, free or known."""
        return tuple(name for name in POSITIONS if self.parameter(name) is not None)

    @property
    def longest_range(self) -> float:
        """The longest range of adhesion [m] that is known to be possible, or likely."""
        return self.range_at_most if math.isfinite(self.range_at_most) else priors.PRIORS[priors.RANGE].width

    def of_a_cycle(self, both: bool) -> Settings:
        """The same of a way back, whose radius at the turn is free too, or of ``both`` directions with w of the
        approach; where w is fixed at 0, so is that."""
        w = self.known("w")
        approach = Parameter("w_approach", w.free or w.value != 0, 0.0 if w.value == 0 and not w.free else None)
        return replace(self, parameters=(*self.parameters, *[approach] * both, Parameter("a_turn", True)))

    @property
    def of_the_approach(self) -> Settings:
        """From those of both directions those of the approach alone, whose w is that of the approach."""
        return self.without(("w", *OF_A_CYCLE), replace(self.known("w_approach"), name="w"))

    def without(self, names: Container[str], *first: Parameter) -> Settings:
        """The same without some parameters, and with others ``first``."""
        return replace(self, parameters=(*first, *(p for p in self.parameters if p.name not in names)))

    @property
    def free(self) -> tuple[Parameter, ...]:
        return tuple(parameter for parameter in self.parameters if parameter.free)

    def known(self, name: str) -> Parameter:
        """The parameter called ``name``, which is there."""
        return next(parameter for parameter in self.parameters if parameter.name == name)

    def parameter(self, name: str) -> Parameter | None:
        """The parameter called ``name``, None where it plays no part."""
        return next((parameter for parameter in self.parameters if parameter.name == name), None)


# What a user may say beside parameters, and on which kind of fit it has an effect: one table for the command line and
# Python; whatever is given besides is refused.
EACH, LAW, RELAXATION, SHARED = "each", "--law", "--relaxation", "--shared"
EFFECT: Mapping[str, tuple[str, ...]] = {  # others have one on every kind
    "law": (LAW, RELAXATION), "relaxation": (RELAXATION,), "terms": (RELAXATION,), "shared": (SHARED, RELAXATION),
    "own": (SHARED, RELAXATION),
    "tip_radius": (EACH, SHARED, TENSION), "start": (EACH, SHARED, LAW), "bound": (EACH, SHARED),
    "segment": (EACH, SHARED, LAW, RELAXATION), "base_line": (EACH, SHARED), "branch": (EACH, SHARED),
    "noise": (EACH, SHARED), "loss": (EACH,), "confidence": (EACH, SHARED, LAW, RELAXATION), "samples": (EACH,),
    "seed": (EACH,), "rivals": (EACH,), "model": (EACH,), "plan": (EACH,), "surface": (EACH,), "uncertain": (EACH,),
    "contact": (EACH, SHARED, LAW, RELAXATION), "slopes": (EACH, SHARED, LAW),
    "sample": (EACH,), "report": (EACH,), "grid": (EACH,),
}  # fmt: skip
NOT = {("contact", "fitted"): (LAW, RELAXATION), ("confidence", "bootstrap"): (SHARED, LAW, RELAXATION)}
GOES_WITH = {
    "terms": ("relaxation", " prony"), "own": ("shared", ""),
    "samples": ("confidence", " bootstrap"), "seed": ("confidence", " bootstrap"),
}  # fmt: skip
NO_OPTIONS = ("parameters", "named", "range_at_most", "tension_at_most")  # of the settings, which follow from others
OPTIONS = ("start", "bound", *(item.name for item in fields(Settings) if item.name not in NO_OPTIONS))
OPTIONS_OF = {EACH: OPTIONS, SHARED: OPTIONS, LAW: ("start", "level", "confidence", "segment"),
              RELAXATION: ("terms", "level", "confidence", "segment"), TENSION: ("level",)}  # fmt: skip


def check_unused(kind: str, given: Mapping[str, Any], called: Callable[[str], str] = str, by: str = "") -> None:
    """InputError where one of the options that were ``given`` has no effect on this ``kind`` of fit, which a user calls
    so, the options as ``called``."""
    idle = [name for name in given if kind not in EFFECT.get(name, (kind,))]
    if given.get("confidence") != "bootstrap":
        idle += [name for name in ("samples", "seed") if name in given]
    if kind == RELAXATION and given.get("relaxation") != "prony":
        idle += [name for name in ("terms",) if name in given]
    if kind == RELAXATION and not (given.get("shared") or given.get("law")):
        idle += [name for name in ("own",) if name in given]
    idle += [name for (name, value), kinds in NOT.items() if kind in kinds and given.get(name) == value]
    if "slopes" in given and given.get("tip_radius") and kind == SHARED:
        raise InputError(f"fit: {called('slopes')} does not go with {called('tip_radius')}, whose bodies have exact "
                         "ones: leave it out")  # fmt: skip
    for name in idle:
        value = f" {given[name]}" if isinstance(given[name], str) else ""
        if name in GOES_WITH and (kind == EACH or kind in EFFECT[name]):
            other, more = GOES_WITH[name]
            raise InputError(f"fit: {called(name)}: applies only with {called(other)}{more}; leave it out")
        raise InputError(f"fit: {by or kind} does not take {called(name)}{value}: leave it out")


def settings_of(
    body: FittedBody, free: Iterable[str] = (), fix: Named = (), start: Named = (), bound: Named = (),
    uncertain: Named = (), **options: Any,
) -> Settings:  # fmt: skip
    """The settings for ``body``; values by name, such as {"w": "50 mJ/m^2"}, ("E:film", "1 MPa..1 GPa"); InputError
    names them.

    Free are the common modulus, w and delta0, but for those that ``fix`` names, and what ``free`` adds. Where that is
    a quantity of a layer, the common modulus stays as in the case unless it is named too.
    """
    inputs = texts_of(uncertain)
    bounded = [*texts_of(bound), *((name, BETWEEN + text) for name, text in inputs if name in LEFT_OUT)]
    inputs = [pair for pair in inputs if pair[0] not in LEFT_OUT]
    for text in (text for name, text in bounded if name == TENSION):
        options["tension_at_most"] = _largest_tension(body, text)
    bounded = [pair for pair in bounded if pair[0] != TENSION]
    fixed, starts, bounds = (_by_name(body, pairs) for pairs in (texts_of(fix), texts_of(start), bounded))
    wanted = list(dict.fromkeys(_own_name(body, name) for name in free))
    of_layers = any(":" in name for name in wanted)
    usual = [name for name in USUALLY_FREE if not (name == "modulus" and of_layers)]
    names = [name for name in DIMENSIONS if name in (*usual, *wanted)] + [name for name in wanted if ":" in name]
    if both := sorted(set(wanted) & set(fixed)):
        raise InputError(f"fit: {both[0]} is both free and fixed")
    names = [name for name in names if name not in fixed]
    of_case = {"stress": body.range_of_case.stress, "range": body.range_of_case.length}
    of_case = {name: value for name, value in of_case.items() if value is not None}
    ranged = set(RANGES) & {*names, *fixed} or of_case
    if "range" in bounds and not ranged:
        low, options["range_at_most"] = _ends(body, "range", bounds.pop("range")[1])
        if low != -math.inf:
            raise InputError('fit: range: a lower bound needs --free range; where JKR is fitted, give "..HIGH"')
        if not options["range_at_most"] > 0:
            raise InputError(f"fit: range: the bound must be > 0, got {options['range_at_most']:g}")
    if idle := sorted({*starts, *bounds} - set(names)):
        raise InputError(f"fit: {idle[0]} is not free: a start or a bound has no meaning (free: {', '.join(names)})")
    parameters = []
    for name in names:
        low, high = _ends(body, *bounds[name]) if name in bounds else (-math.inf, math.inf)
        value = _value(body, *starts[name]) if name in starts else None
        parameters.append(Parameter(name, True, value, low, high))
    parameters += [Parameter(name, False, _value(body, *text)) for name, text in fixed.items()]
    if not set(RANGES) & {parameter.name for parameter in parameters}:
        parameters += [Parameter(name, False, value) for name, value in of_case.items()]
    settings = Settings(tuple(parameters), **options)
    return replace(settings, uncertain=_uncertain(body, inputs, settings)) if inputs else settings


def _uncertain(body: FittedBody, pairs: Iterable[tuple[str, str]], settings: Settings) -> dict[str, float]:
    """Standard deviations of inputs by name: "radius" of the indenter, "nu" and "thickness" of the layer in contact, or
    "nu:film", "h:film", "E:base", absolute ("0.02", "50 nm") or relative ("5%"); "stiffness" and "sensitivity" of a
    device, relative."""
    errors = {}
    for name, text in pairs:
        whole = {"nu": f"nu:{body.layer_names[0]}", "thickness": f"h:{body.layer_names[0]}"}.get(name, name)
        radius = [RADIUS] if body.own_parameters and hasattr(body.problem.indenter, "R") else []
        own = (*body.own_parameters, *(f"nu:{layer}" for layer in body.layer_names if body.own_parameters))
        allowed = (*own, *radius, *CALIBRATED)
        checked_names([whole], allowed)
        fitted = settings.parameter(whole)
        if fitted is not None:
            raise InputError(f"fit: {whole} is {'free' if fitted.free else 'fixed'}, it cannot be uncertain as well")
        if whole in CALIBRATED and not text.endswith("%"):
            raise InputError(f"fit: the uncertainty of {name} is relative, such as 5%, got {text}")
        if text.endswith("%"):
            size = 1.0 if whole in CALIBRATED else abs(body.nominal(whole))
            value = read_value("uncertain", Ranged("number"), text[:-1]) / 100 * size
        else:
            value = read_value(name, Ranged("length" if whole == RADIUS else dimension_of(whole)), text)
        if not value > 0:
            raise InputError(f"fit: the uncertainty of {name} must be > 0, got {text}")
        errors[whole] = value
    return errors


def _by_name(body: FittedBody, pairs: Iterable[tuple[str, str]]) -> dict[str, tuple[str, str]]:
    """Names as the user wrote them and texts, by the parameters' own names."""
    by_name: dict[str, tuple[str, str]] = {}
    for name, text in pairs:
        own = _own_name(body, name)
        if own in by_name:
            raise InputError(f"fit: {name} is given twice")
        by_name[own] = (name, text)
    return by_name


def _own_name(body: FittedBody, name: str) -> str:
    if name == ALIAS:
        return "modulus"
    checked_names([name], (*DIMENSIONS, ALIAS, *body.own_parameters))
    return name


def _value(body: FittedBody, name: str, text: str) -> float:
    value = read_value(name, Ranged("modulus" if name == ALIAS else dimension_of(name)), text)
    return value / body.problem.E_star if name == ALIAS else value


def _ends(body: FittedBody, name: str, text: str) -> tuple[float, float]:
    low, mark, high = text.partition(BETWEEN)
    if not mark:
        raise InputError(f'fit: the bounds of {name} must be LOW{BETWEEN}HIGH, one may be left out, got "{text}"')
    least = _value(body, name, low.strip()) if low.strip() else -math.inf
    return least, _value(body, name, high.strip()) if high.strip() else math.inf


def _largest_tension(body: FittedBody, text: str) -> float:
    """The upper bound [N/m] of a surface tension that is left out."""
    specimen = body.problem.specimen
    if body.problem.layers or specimen.radius is not None or specimen.surface_tension:
        raise InputError("fit: surface_tension: a bound is for half-spaces without one: set specimen.surface_tension, "
                         "or give --free surface_tension and --tip-radius")  # fmt: skip
    low, mark, high = text.partition(BETWEEN)
    if low.strip() or not mark:
        raise InputError(f'fit: the bound of surface_tension must be {BETWEEN}HIGH, got "{text}"')
    largest = read_value(TENSION, Ranged("tension"), high.strip())
    if not largest > 0:
        raise InputError(f"fit: surface_tension: the bound must be > 0, got {largest:g}")
    return largest
