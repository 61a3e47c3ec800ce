"""The sweep file as models: a base case, axes over its keys, samples of uncertain keys, the quantities wanted."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from ..base.errors import InputError
from ..base.files import read_bytes
from ..base.numerics import Array
from ..case.models import Length, RootTable, Table, as_tuple, one_or_more, parse_toml, quantity, validated, wrong

# --------------------------------------------------------------------------------------------------
# Distributions of uncertain numbers, and draws: inverse distribution functions of points in the unit cube.

LIMITS = {"least": -math.inf, "most": math.inf}  # of what is cut off


class Kind(NamedTuple):
    """A kind of distribution: the parameters that it needs, the values ``at`` fractions of all draws (n,) by these and
    its ``limits``, and the parameter that must be ``positive``."""

    needed: tuple[str, ...]
    at: Callable[..., Array]
    positive: str = ""
    limits: Mapping[str, float] = {}


def _normal(u: Array, mean: float, sd: float, least: float, most: float) -> Array:
    from scipy.special import ndtr, ndtri

    low, high = ndtr((least - mean) / sd), ndtr((most - mean) / sd)
    return np.clip(mean + sd * ndtri(low + (high - low) * u), least, most)


DISTRIBUTIONS = {
    "uniform": Kind(("from", "to"), lambda u, start, end: start + (end - start) * u),
    "loguniform": Kind(("from", "to"), lambda u, start, end: start * (end / start) ** u, "from"),
    "normal": Kind(("mean", "sd"), _normal, "sd", LIMITS),
    "lognormal": Kind(
        ("median", "factor"),
        lambda u, median, factor, *limits: np.exp(
            _normal(u, math.log(median), math.log(factor), *(math.log(x) if x > 0 else -math.inf for x in limits))
        ),
        "median",
        LIMITS,
    ),
    "integer": Kind(("from", "to"), lambda u, start, end: (start + np.floor((end - start + 1) * u)).astype(int)),
    "choice": Kind(("values",), lambda u, values: np.fromiter(values, object)[(len(values) * u).astype(int)]),
}


@dataclass(frozen=True)
class Distribution:
    """A ``kind`` with the parameters in SI; InputError where they describe none."""

    kind: str
    parameters: Mapping[str, Any]

    def __post_init__(self) -> None:
        name = DISTRIBUTIONS[self.kind].positive
        self._check_rise("from", "to")
        if name and self.parameters[name] <= 0:
            raise InputError(f"{self.kind}: {name} must be > 0, got {self.parameters[name]:g}")
        self._check_rise("least", "most")

    def _check_rise(self, low: str, high: str) -> None:
        start, end = self.parameters.get(low, -math.inf), self.parameters.get(high, math.inf)
        if not start < end:
            raise InputError(f"{self.kind}: {low} must be below {high}, got {start:g} and {end:g}")

    def at(self, u: Array) -> tuple[Any, ...]:
        """The values below which the fractions ``u`` of all draws lie."""
        needed, at, _, limits = DISTRIBUTIONS[self.kind]
        values = {**limits, **self.parameters}
        return tuple(at(u, *(values[name] for name in (*needed, *limits))).tolist())


METHODS = ("random", "sobol", "latin-hypercube")


def draw(distributions: list[Distribution], count: int, method: str, seed: int) -> list[tuple[Any, ...]]:
    """``count`` draws of all distributions together, a tuple per draw."""
    rng, size = np.random.default_rng(seed), len(distributions)
    if method == "random":
        points = rng.random((count, size))
    else:
        from scipy.stats import qmc

        if method == "sobol":
            points = qmc.Sobol(size, scramble=True, rng=rng).random_base2(max(count - 1, 0).bit_length())[:count]
        else:
            points = qmc.LatinHypercube(size, rng=rng).random(count)
    points = np.clip(points, 1e-12, 1 - 1e-12)  # the normal distribution has no ends
    return list(zip(*(item.at(u) for item, u in zip(distributions, points.T, strict=True)), strict=True))


# --------------------------------------------------------------------------------------------------
# The file's tables.

MOST_CASES = 2_000_000  # of one sweep, about 2 kB of memory each in the process that collects their rows
LIST, RANGE = {"key", "values"}, {"key", "from", "to", "count", "spacing"}
Values = Annotated[tuple[Any, ...], BeforeValidator(as_tuple)]
Count = Annotated[int, Field(ge=1)]


class AxisTable(Table):
    """One of: ``key`` with ``values``; ``key`` with ``from``, ``to``, ``count``; ``zip``: lists that go together."""

    key: str | None = None
    values: Values | None = None
    start: Any = Field(None, alias="from")
    end: Any = Field(None, alias="to")
    count: Annotated[int, Field(ge=2)] | None = None
    spacing: Literal["linear", "log"] = "linear"
    zip: dict[str, Values] | None = None

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        keys = set(self.model_dump(by_alias=True, exclude_unset=True))
        if not (keys in (LIST, {"zip"}) or keys in (RANGE, RANGE - {"spacing"})):
            raise wrong(
                "must hold key and values, or key, from, to, count (and spacing), or zip alone, got "
                f"{', '.join(sorted(keys)) or 'nothing'}"
            )
        if self.values == () or self.zip == {}:
            raise wrong("is empty")
        if self.zip is not None:
            lengths = {key: len(values) for key, values in self.zip.items()}
            if len(set(lengths.values())) > 1 or 0 in lengths.values():
                raise wrong(f"the lists of zip must have one length, got {lengths}")
        return self

    @property
    def size(self) -> int:
        """How many values there are."""
        if self.zip is not None:
            return len(next(iter(self.zip.values())))
        return len(self.values) if self.values is not None else self.count or 0


class DistributionTable(Table):
    """How an uncertain key is distributed; parameters in the key's own unit, ``factor`` = exp of the log's sd."""

    distribution: Literal.__getitem__(tuple(DISTRIBUTIONS))
    start: Any = Field(None, alias="from")
    end: Any = Field(None, alias="to")
    mean: Any = None
    sd: Any = None
    median: Any = None
    factor: quantity("number", above=1) | None = None
    least: Any = None
    most: Any = None
    values: Values | None = None

    @model_validator(mode="after")
    def _its_own_keys(self) -> Self:
        kind, parameters = DISTRIBUTIONS[self.distribution], set(self.parameters)
        needed, allowed = set(kind.needed), set(kind.limits)
        if not needed <= parameters <= needed | allowed:
            optional = f" (and {', '.join(sorted(allowed))})" if allowed else ""
            raise wrong(
                f"{self.distribution} takes {', '.join(sorted(needed))}{optional}, got "
                f"{', '.join(sorted(parameters)) or 'nothing'}"
            )
        if self.values == ():
            raise wrong("values is empty")
        return self

    @property
    def parameters(self) -> dict[str, Any]:
        """Its parameters as they stand in the file."""
        return self.model_dump(by_alias=True, exclude_unset=True, exclude={"distribution"})


class SamplesTable(Table):
    """``count`` draws of all keys in ``of``; those of a smaller count are the first (but for latin-hypercube)."""

    count: Count
    method: Literal["sobol", "random", "latin-hypercube"] = "sobol"
    seed: Annotated[int, Field(ge=0)] = 0
    of: Annotated[dict[str, DistributionTable], Field(min_length=1)]


class OutputsTable(Table):
    """``quantities``: names or groups; ``over``: the one over which the picture is drawn, else the longest axis;
    ``radii``: the curve there too; ``stiffness``: pull-off by such devices too; ``slopes``: "auto" or a rule's name,
    checked where the rules are known."""

    quantities: one_or_more(str) = ("pull_off", "pull_off_errors", "validity", "errors")
    over: str = ""
    radii: one_or_more(Length) = ()
    stiffness: one_or_more(quantity("stiffness", above=0)) = ()
    slopes: str = "auto"


class SweepModel(RootTable):
    """A whole sweep file; ``base``: name of a case file, or a case in place."""

    title: str = ""
    base: str | dict[str, Any]
    axes: Annotated[tuple[AxisTable, ...], BeforeValidator(as_tuple)] = ()
    samples: SamplesTable | None = None
    outputs: OutputsTable = OutputsTable()

    @model_validator(mode="after")
    def _not_too_many(self) -> Self:
        """Counted before any value is looked at."""
        count = math.prod(axis.size for axis in self.axes) * (1 if self.samples is None else self.samples.count)
        if count > MOST_CASES:
            raise wrong(f"makes {count:,} cases, at most {MOST_CASES:,} are allowed in one sweep")
        return self


def load_sweep(path: Path) -> tuple[SweepModel, dict[str, Any], Path]:
    """The sweep file at ``path``, the tables of its base case as they stand, and the folder for names in them."""
    source = str(path)
    model = validated(SweepModel, parse_toml(read_bytes(path, "sweep file"), source), source)
    if isinstance(model.base, dict):
        return model, model.base, path.parent
    base = path.parent / model.base
    return model, parse_toml(read_bytes(base, "base case"), str(base)), base.parent
