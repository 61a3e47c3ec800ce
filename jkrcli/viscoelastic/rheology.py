"""A fitted law of relaxation by the names of spring and dashpot models: the standard solid in its Maxwell (Zener) and
its Kelvin-Voigt form, Prony's series as generalised Maxwell model, the power law by its modulus at 1 s.

With E_0 at once, E_inf at rest and the relaxation time tau, the same solid is

    Maxwell:        E_inf beside (E_2 = E_0 - E_inf, eta = E_2 tau)
    Kelvin-Voigt:   E_0 behind (E_2 = E_0 E_inf/(E_0 - E_inf), eta = E_2 tau_ret),   tau_ret = tau E_0/E_inf

Moduli are reduced, E/(1 - nu^2) of a half-space, as E* is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ..base.numerics import TINY, Array
from ..base.units import show
from .timed_record import RelaxationFit, relaxation_at

SECOND = np.ones(1)  # time of the modulus by which a power law is called [s]
UNITS = {"modulus": "Pa", "time": "s", "viscosity": "Pa_s", "number": ""}


def quantities(fit: RelaxationFit) -> dict[str, str]:
    """The names of what a law is called by, with their dimensions."""
    if fit.settings.law == "power":
        return {"E_1s": "modulus", "beta": "number"}
    if fit.settings.law == "sls":
        return {"E_inf": "modulus", "Maxwell_E2": "modulus", "Maxwell_eta": "viscosity", "KelvinVoigt_E2": "modulus",
                "KelvinVoigt_eta": "viscosity", "retardation_time": "time"}  # fmt: skip
    terms = range(1, fit.settings.terms + 1)
    each = {f"Maxwell_{name}{i}": of for i in terms for name, of in (("E", "modulus"), ("eta", "viscosity"))}
    return {"E_inf": "modulus"} | each


def values_of(law: str, p: Mapping[str, float], E_star: float) -> list[float]:
    """The values in their order, of parameters ``p`` and the modulus ``E_star`` [Pa], at once or of a power law at its
    time; nan of the Kelvin-Voigt element of a body that relaxes altogether, or not at all."""
    if law == "power":
        r = relaxation_at(SECOND, "power", {"onset": 0.0} | dict(p))
        return [E_star * float(r[0]), p["exponent"]]
    if law == "sls":
        left = E_star * p["ratio"]
        lost = E_star - left
        alone = lost <= 0 or left <= 0
        series, retardation = (math.nan, math.nan) if alone else (E_star * left / lost, p["time"] / p["ratio"])
        return [left, lost, lost * p["time"], series, series * retardation, retardation]
    terms = [name.removeprefix("weight") for name in p if name.startswith("weight")]
    moduli = [E_star * p[f"weight{i}"] for i in terms]
    pairs = [one for i, E in zip(terms, moduli, strict=True) for one in (E, E * p[f"time{i}"])]
    return [E_star - sum(moduli), *pairs]


def rheology(fit: RelaxationFit) -> dict[str, tuple[float, float, float]]:
    """Each quantity with the ends of its interval, by samples or the whole covariance of the parameters."""
    nominal, names = fit.value("E_star") / fit.value("modulus"), quantities(fit)

    def logs(p: Mapping[str, float]) -> Array:
        return np.log(np.maximum(values_of(fit.settings.law, p, nominal * p["modulus"]), TINY))

    here = values_of(fit.settings.law, {item.name: item.value for item in fit.estimates}, fit.value("E_star"))
    ends = fit.intervals(logs)[:, 1:]
    return {name: (value, float(low), float(high)) for name, value, (low, high) in zip(names, here, ends, strict=True)}


def columns(fit: RelaxationFit) -> dict[str, float]:
    """The same as columns of a table, with half-widths."""
    found, row = quantities(fit), dict[str, float]()
    for name, (value, low, high) in rheology(fit).items():
        unit = UNITS[found[name]]
        column = f"{name}_{unit}" if unit else name
        row |= {column: value, f"{column}_error": (high - low) / 2}
    return row


def summary(fit: RelaxationFit) -> dict[str, dict[str, float | str | None]]:
    """The same for JSON."""
    found = quantities(fit)
    return {
        name: {"unit": UNITS[found[name]].replace("_", " "), **{
            end: None if math.isnan(one) else one for end, one in zip(("value", "low", "high"), values, strict=True)
        }}
        for name, values in rheology(fit).items()
    }  # fmt: skip


def words(fit: RelaxationFit) -> str:
    """The same in a line."""
    found = quantities(fit)

    def told(name: str, value: float) -> str:
        dimension, plain = found[name], name.rpartition("_")[2] if "_E" in name or "_eta" in name else name
        text = f"{value:.4g} Pa s" if dimension == "viscosity" else show(value, dimension)
        return f"{plain.replace('_', ' ')} {text}"

    groups = dict[str, list[str]]()
    for name, value in ((name, value) for name, (value, *_) in rheology(fit).items() if not math.isnan(value)):
        kind = name.partition("_")[0] if name.startswith(("Maxwell", "Kelvin")) else ""
        kind = "KelvinVoigt" if name == "retardation_time" else kind
        groups.setdefault(kind, []).append(told(name, value))
    titles = {"": "", "Maxwell": "Maxwell form ", "KelvinVoigt": "Kelvin-Voigt form "}
    return "  " + "; ".join(titles[kind] + ", ".join(parts) for kind, parts in groups.items())
