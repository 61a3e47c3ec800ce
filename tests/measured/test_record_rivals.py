"""Alternatives of raw records: columns against loads made by formulae of their own, and what is made of their
scores."""

import json
import math
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
import wrong_records
from conftest import Outcome, write_table
from force_curves import record
from raw_records import BODY, R, read, usual
from scipy.special import fdtrc
from wrong_records import SPEED, WRONG, Drawn, Wrong, right

from jkrcli.measured import force_curve
from jkrcli.measured.alternative_fits import _Amounts, _of_amounts, record_alternatives
from jkrcli.measured.curve import Curve
from jkrcli.measured.fitted_record import CHANGE_SMALL, FittedRecord, Known
from jkrcli.measured.forward_model import grid, on_grid
from jkrcli.measured.hypotheses import ALTERNATIVES
from jkrcli.measured.least_squares import Spectrum
from jkrcli.measured.lockstep import alone
from jkrcli.measured.model_changes import (
    AMOUNT,
    DEVICE,
    LITTLE,
    AlternativeModel,
    Change,
    ChangedModel,
)
from jkrcli.measured.procedure import fit
from jkrcli.measured.record import _fitted, _model, directions_of, half_space_modulus, raw_force_curve
from jkrcli.measured.report import alternatives_table, fit_words, summary
from jkrcli.measured.result import Fit
from jkrcli.measured.score_tests import (
    DETECTED,
    EXCLUDED,
    UNDECIDED,
    Linearised,
    RecordAlternatives,
    _evidence,
    _tails,
    linearised,
    score_tests,
    tables,
)
from jkrcli.measured.settings import Settings
from jkrcli.viscoelastic.hypotheses import work_over_speed

AT = Drawn(E=1e5, w=2e-4, radius=1.5e-6, k=1.0, largest=4e5 * 1.5e-6**3 / (3 * R), noise=3e-11, seed=5)
ALL = WRONG | SPEED
STILL = Drawn(AT.E, AT.w, AT.radius, AT.k, AT.largest, 1e-16, AT.seed)


def curve(made: Wrong) -> Curve:
    return read(made.columns, made.k, "t")


@lru_cache
def alternatives_of_record(record: FittedRecord) -> RecordAlternatives:
    return alone(score_tests(record))[0]


def still_record() -> FittedRecord:
    """A fit of a right record without noise and without rest."""
    made = Wrong(record(STILL.E, R, STILL.w, STILL.w, STILL.device, 1), STILL.k, STILL.truth)
    return of_record(made, usual())


def of_record(made: Wrong, settings: Settings) -> FittedRecord:
    held = alone(raw_force_curve(curve(made), settings))
    model = _model(BODY, held, settings, directions_of(held, settings))
    return FittedRecord(*alone(_fitted(BODY, model, settings)))


@lru_cache
def answer(kind: str) -> Fit:
    return fit(BODY, curve(ALL.get(kind, right)(AT)), usual())


def named(name: str) -> AlternativeModel:
    return next(alternative for alternative in ALTERNATIVES if alternative.name == name)


def change(name: str, at: FittedRecord | None = None) -> Change:
    return named(name).change(at or still_record())


def column(at: FittedRecord, name: str) -> np.ndarray:
    (table,) = tables([at], [named(name)])
    return table.columns[-1]


def linear(at: FittedRecord, rows: np.ndarray | None = None) -> Linearised:
    """With all alternatives, on some rows or all."""
    (found,) = linearised([(tables([at])[0], np.ones(at.a.size, dtype=bool) if rows is None else rows)])
    return found


def test_changes_by_an_alternative() -> None:
    # E* by three factors e down, or up: 95 % less, or by three of it to first order.
    score = alternatives_of_record(still_record()).scores[0]
    found = replace(score, word=DETECTED, amount=3.0, error=0.0, E_star=-1.0, w=1.0)
    assert found.moved("E_star") == pytest.approx(math.exp(-3) - 1)
    assert found.moved("w") == pytest.approx(3.0)
    # E* of one direction, 0.8 of that of the fit of both, which an alternative that is detected raises by a tenth.
    found = alternatives_of_record(still_record())
    score = replace(found.scores[0], word=DETECTED, amount=1.0, error=0.0, E_star=math.log(1.1), w=0.0)
    (one,) = replace(found, scores=(score,), named=(score,)).told_of({"E_star": 1 / 0.8}).named
    assert one.change("E_star") == pytest.approx(1.1 / 0.8 - 1)
    assert one.moved("E_star") == pytest.approx(math.log(1.1 / 0.8))
    assert one.change("w") == 0
    undecided = replace(one, word=UNDECIDED, least=-0.2, known=0.2, error=math.inf)
    assert undecided.moved("E_star") == pytest.approx(0.2 * math.log(1.1))
    # ln S rises by the amount times a/a_max - 1: it is as it was at a_max, where the rows tell it.
    at = still_record()
    graded = change("moduli that change with the contact radius", at)
    family = at.model.family
    _, rise = graded.of(family, {AMOUNT: 0.3})
    places = np.log(at.a_max) + np.log([1.0, 0.5])
    assert np.interp(places, grid(family), rise) == pytest.approx([0.0, -0.15], abs=1e-3)


def test_the_load_of_a_sphere() -> None:
    """By Sneddon's series: P over that of the paraboloid at equal depth is 1 - delta/(5 R) to first order."""
    at = still_record()
    a = np.array([1e-2, 1e-1]) * R
    body = ChangedModel.of(at.model, change("sphere or paraboloid"))
    values = at.model.values(at.fit.x) | {"amount": LITTLE}
    family = body.followed(at.model.stretches[0], values).family
    D, _, H, _ = family.spline(np.log(a)).T / LITTLE
    x = a / R
    exact_D, exact_H = np.arctanh(x) / x, 3 / (4 * x**3) * ((1 + x**2) * np.arctanh(x) - x)
    assert pytest.approx(exact_D - 1, rel=0.02) == D  # the next term of the series is 3/5 x^2 of it
    assert pytest.approx(exact_H - 1, rel=0.02) == H


def test_surface_tension_of_a_half_space() -> None:
    """Against the integral equation at kappa = a/10 (E* = R = a = 1): the load at equal depth, 1.85841 at 1.18164, in
    first order, whose next term is (kappa l/a)^2 = 13 %."""
    kappa, log = 0.1, math.log(20) + 0.5772157
    by_formula = 4 * kappa * log / math.pi - 2 * 2 * kappa / math.pi * (log - 1)
    assert 1.85841016 - 4 / 3 * 1.18163976**1.5 == pytest.approx(by_formula, rel=0.15)
    at = elastic()
    ours = column(at, "surface tension")
    i = int(np.argmax(at.a))
    log = math.log(2 / CHANGE_SMALL) + 0.5772157
    of_theory = at.body.problem.E_star * at.modulus * at.a_max**3 / R * (4 * log - 4 * (log - 1)) / math.pi
    assert ours[i] / at.at_fixed_position[i] == pytest.approx(of_theory, rel=0.02)  # at constant displacement


@lru_cache
def elastic() -> FittedRecord:
    """The same without adhesion, by a stiff device."""
    return of_record(wrong_records.relaxing(STILL, 0.0), usual(fix=[("w", "0")]))


def test_relaxation_of_a_tenth_of_a_per_cent() -> None:
    """Against Ting's sums of the generator."""
    at = elastic()
    ours = column(at, "relaxation of one time")
    loads = [wrong_records.relaxing(STILL, lost, 0.5).columns["P"] for lost in (0.0, 1e-3)]
    theirs = (loads[1] - loads[0]) / 1e-3
    part_in, part_out = at.model.stretches
    rows = np.concatenate([part_in.rows, part_out.rows])
    touching = at.a > 0.2 * at.a_max
    scale = float(np.abs(theirs).max())
    assert np.abs(ours / at.at_fixed_position - theirs[rows])[touching].max() < 0.03 * scale  # 150 instants


def test_a_short_range_is_that_of_maugis() -> None:
    """The loads of Maugis's curve of Tabor's number 8 less those of JKR, by the square of the range; the next order is
    that of the ring's width over the radius, a tenth and more."""
    at = still_record()
    u = grid(at.model.family)
    D, T, H, V = on_grid(at.model.family)[0]
    ours = column(at, "adhesion of finite range")
    both = [wrong_records.maugis(STILL, mu).columns for mu in (8.0, 80.0)]
    z0 = [(STILL.w**2 * R / STILL.E**2) ** (1 / 3) / mu for mu in (8.0, 80.0)]
    part = at.model.stretches[1]
    there = [np.interp(part.z, one["z"][-1:999:-1], one["P"][-1:999:-1]) for one in both]
    theirs = (there[0] - there[1]) / (z0[0] ** 2 - z0[1] ** 2) * at.narrow_range**2
    rows = slice(-part.z.size, None)
    far = (at.a[rows] > 0.6 * at.a_max) & (part.z < min(one["z"].max() for one in both))
    assert np.abs(ours[rows] - theirs)[far].max() < 0.25 * np.abs(theirs[far]).max()  # 0.21
    assert len(u) == D.size == T.size == H.size == V.size


def test_the_formula_of_the_half_space() -> None:
    E, w, a = 2e5, 1e-3, 1e-6
    delta = a**2 / R - math.sqrt(2 * math.pi * a * w / E)
    P = 4 * E * a**3 / (3 * R) - math.sqrt(8 * math.pi * w * E * a**3)
    assert half_space_modulus(P, delta, R, w) == pytest.approx(E, rel=1e-9)
    assert half_space_modulus(4 * E * a**3 / (3 * R), a**2 / R, R, 0.0) == pytest.approx(E, rel=1e-12)


def test_a_right_record_asks_for_nothing() -> None:
    found = answer("right")
    assert not found.verdict.alternatives.named
    assert found.flags == ()
    assert found.verdict.alternatives.misfit / found.verdict.alternatives.dof == pytest.approx(1, abs=0.1)
    assert {one.word for one in found.verdict.alternatives.scores} <= {EXCLUDED, UNDECIDED}
    assert "no alternative model is favoured" in fit_words(found)[2]


@pytest.mark.parametrize(
    ("kind", "family"),
    [pytest.param("cone", "shape of the tip", marks=pytest.mark.slow), ("plastic", "relaxation or flow")],
)
def test_a_wrong_model_is_rejected(kind: str, family: str) -> None:
    found = answer(kind)
    assert family in found.verdict.alternatives.families
    assert "model rejected" in found.flags
    assert ("directions differ" in found.flags) == (kind == "plastic")
    assert summary([found], "body")["curves"][0]["status"] == "doubtful"
    (cause,) = (line for line in fit_words(found) if "cause" in line)
    assert f"{family} would change E* by " in cause
    assert ("not identifiable" in cause) == (len(found.verdict.alternatives.families) > 1)


def test_scores_are_chi_squares() -> None:
    """Of right records with other noise the amounts scatter by their errors: mean of z^2 near 1 (22 alternatives of
    12)."""
    at = still_record()
    held = [alternatives_of_record(FittedRecord(at.body, _noisy(at, seed))).scores for seed in range(12)]
    z2 = np.array([[one.taken for one in scores] for scores in held])
    assert np.mean(z2) == pytest.approx(1, abs=0.4)


def test_what_the_model_itself_takes_is_no_alternatives() -> None:
    """Five standard errors beside the best offset: the residuals are others, the scores are not."""
    at = still_record()
    i = next(i for i, name in enumerate(at.fit.names) if name.startswith("offset"))
    beside = at.fit.x.copy()
    beside[i] += 5 * math.sqrt(at.fit.covariance[i, i])
    best, other = (np.array([one.taken for one in alternatives_of_record(FittedRecord(at.body, found)).scores])
                   for found in (at.fit, replace(at.fit, x=beside)))  # fmt: skip
    assert other == pytest.approx(best, abs=0.01 * best.max() + 1e-3)


def _noisy(at: FittedRecord, seed: int) -> object:
    rng, parts = np.random.default_rng(seed), at.model.stretches
    noisy = tuple(replace(part, P=part.P + 1e-11 * rng.normal(size=part.P.size)) for part in parts)
    told = replace(at.fit.spread, noise=Spectrum(1e-22))
    return replace(at.fit, model=replace(at.model, stretches=noisy), spread=told)


def test_what_is_left_of_a_known_amount() -> None:
    """The data exclude part of it: amounts from 0.1 to 0.3 of an alternative known within 0.2 leave 0.2."""
    score = next(one for one in answer("right").verdict.alternatives.scores)  # type: ignore[union-attr]
    one = replace(score, amount=0.2, error=0.1 / 1.96, quantile=1.96, least=-0.2, known=0.2, word=UNDECIDED)
    assert one.most == pytest.approx(0.2)
    assert replace(one, known=1.0).most == pytest.approx(0.3)
    assert replace(one, amount=-0.2, known=1.0).most == pytest.approx(0.2)
    assert replace(one, amount=-0.2, least=0.0).most == 0
    assert replace(one, known=1.0, word=DETECTED, E_star=2.0).moved("E_star") == pytest.approx(0.6)


def test_which_alternatives_mean_something() -> None:
    (table,) = tables([still_record()])
    left_out = {alternative.name for alternative in ALTERNATIVES} - {one.name for one in table.alternatives}
    assert np.isfinite(table.columns).all()
    assert {"thickness of the layer", "nu of the layer", "no slip"} <= left_out
    # Of 30 mN/m at most: E* of a half-space moves by 3 kappa log/(pi a) at equal depth; none is known by default.
    at = still_record()
    alternative = named("surface tension")
    assert alternative.likely_in(at) == 0
    kappa = 2 * 0.03 / (at.modulus * at.body.problem.E_star)
    assert alternative.likely_in(replace(at, known=Known(tension=0.03))) == pytest.approx(kappa / at.a_max, rel=1e-12)


def test_the_command_prints_the_table(jkr: Callable[..., Outcome], tmp_path: Path) -> None:
    made = WRONG["plastic"](AT).columns
    head = "# piezo [um]\tForce [nN]"
    file = write_table(tmp_path / "curve.txt", head, 1e6 * made["z"], 1e9 * made["P"], mark="\t")
    said = jkr("fit", "--radius", "5 um", "--nu", "0.5", "--shape", "paraboloid", file, "--rivals",
               "--stiffness", "1 N/m", "--no-plots", "-o", tmp_path).ok  # fmt: skip
    assert "would change E* by " in said.out
    assert "a rigid substrate below" in said.out
    told = json.loads((tmp_path / "curve-fit.json").read_text())["curves"][0]
    assert "relaxation or flow" in told["verdict"]["families"]
    assert len(told["verdict"]["rivals"]) == len(alternatives_table(answer("right"))) - 1


def test_a_hypothesis_of_one_line_is_found_by_its_score() -> None:
    at = still_record()
    back = AlternativeModel("gain on retraction", DEVICE, "relative change", lambda record: Change(
        column=np.where(record.rows(record.model.stretches[-1]), record.loads, 0.0)))  # fmt: skip
    (table,) = tables([at], [back])
    first = (np.arange(len(table.columns)) == 0)[:, None]
    here = replace(table, columns=table.columns + 1e-3 * first * table.columns[-1])
    (found,) = linearised([(here, np.ones(at.a.size, dtype=bool))])
    assert -found.shared[0] / found.sizes[0] == pytest.approx(-1e-3, rel=0.1)


def test_positions_that_repeat_take_no_fit_with_them() -> None:
    """A piezo's readings are steps of a converter: on a microscope's own file the speed of the edge was 0/0."""
    at = still_record()
    part = at.retraction
    stepped = replace(part, z=np.round(part.z / (4 * part.spacing)) * 4 * part.spacing)
    stretches = tuple(stepped if one is part else one for one in at.model.stretches)
    coarse = FittedRecord(at.body, replace(at.fit, model=replace(at.model, stretches=stretches)))
    with np.errstate(all="raise"):
        effect = work_over_speed(coarse)
    assert np.isfinite(effect.column).all()


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "told"), [
    ("creep", {}), ("layer as half-space", {}), ("cone", {"exponent": 1.0}), ("w rising to four times", {}),
    ("relaxation", {"fall": 0.5}), ("w over the speed", {"n": 0.4}),
])  # fmt: skip
def test_the_right_alternative_in_full_gives_the_truth(kind: str, told: dict[str, float]) -> None:
    made = ALL[kind](AT)
    plain, found = answer(kind), fit(BODY, curve(made), usual(model="auto"))
    assert found.verdict.tied[0].family in made.families
    assert "model rejected" not in found.flags
    assert "model rejected" in plain.flags
    item = found.estimate("E_star")
    assert abs(item.value - AT.E) < 4 * item.error
    assert abs(plain.value("E_star") - AT.E) > 10 * item.error
    for name, value in told.items():
        own = found.estimate(name)
        assert own.value == pytest.approx(value, abs=max(0.02 * value, 4 * (own.error or 0.0)))
    assert found.verdict.tied[0].name in fit_words(found)[0]
    assert summary([found], "body")["curves"][0]["verdict"]["model"] == found.verdict.tied[0].name


@pytest.mark.parametrize(("i", "noise"), [pytest.param(5, 1.0, marks=pytest.mark.slow), (63, 0.85)])
def test_a_range_with_two_valleys_is_found_in_full(i: int, noise: float) -> None:
    """Tabor's number 0.3: chi^2 has another valley at ranges five times shorter, where w is a sixth too high (5). One
    step takes less than nine of chi^2, and a surface tension 14, whose chance is less than half of what asks for it on
    every processor (63)."""
    drawn = Drawn.of(np.random.default_rng((97, i, 1)), noise)
    found = fit(BODY, curve(wrong_records.maugis(drawn)), usual(model="auto"))
    assert "adhesion" in found.verdict.families
    for name, true in (("E_star", drawn.E), ("w", drawn.w)):
        item = found.estimate(name)
        assert item.value == pytest.approx(true, abs=3 * math.hypot(item.error, *(item.model or {}).values()))


def test_a_long_range_that_is_possible_widens_w() -> None:
    """Tabor's number 0.3, a range of 0.1 um: no data of this noise tell it, w is a fifth too high. It counts where
    data that lean to it outweigh its odds, unless the user rules it out."""
    made = wrong_records.maugis(replace(AT, noise=10 * AT.noise))
    known = fit(BODY, curve(made), usual(bound=[("range", "..1 um")])).estimate("w")
    assert known.low > 1.1 * AT.w
    assert known.low - known.model["adhesion of finite range"] < AT.w
    by_default = fit(BODY, curve(made), usual()).estimate("w")
    assert by_default.low - sum((by_default.model or {}).values()) < AT.w
    ruled_out = fit(BODY, curve(made), usual(uncertain=[("range", "3 nm")])).estimate("w")
    part = (ruled_out.model or {}).get("adhesion of finite range", 0.0)
    assert part < 0.2 * known.model["adhesion of finite range"]


@pytest.mark.first(2)
@pytest.mark.parametrize(
    ("kind", "louder", "asked"), [("DMT", 10, False), ("Maugis mu 0.3", 5, False), ("DMT", 5, True)]
)
def test_a_range_below_the_noise_is_named_or_in_the_part_of_the_model(kind: str, louder: float, asked: bool) -> None:
    """No column of one step tells it, which trusts no row next to a fold; fits at one range after the other do."""
    made = curve(WRONG[kind](replace(AT, noise=louder * AT.noise)))
    found = fit(BODY, made, usual(uncertain=[("range", "10 um")]))
    assert ("adhesion of finite range" in [one.name for one in found.verdict.alternatives.named]) == asked
    for name, true in (("E_star", AT.E), ("w", AT.w)):
        item = found.estimate(name)
        off, part = abs(item.value - true), sum((item.model or {}).values())
        assert off > 3 * item.error
        assert off < 1.96 * item.error + part


@pytest.mark.parametrize(
    ("name", "drawn"),
    [("exponent of the tip", AT), ("adhesion of finite range", Drawn.of(np.random.default_rng((97, 15, 1)), 1.0))],
)
def test_moves_at_a_bound_are_those_of_a_fit_in_full(name: str, drawn: Drawn) -> None:
    at = of_record(right(drawn), usual())
    alternatives = alone(record_alternatives(at))
    score = next(one for one in alternatives.scores if one.name == name)
    model = ChangedModel.of(at.model, change(score.name, at))
    held = replace(model, known={**model.known, AMOUNT: score.most})
    here = FittedRecord(at.body, force_curve.fit(held, at.fit.x, near=True))
    for rate, ratio in ((score.E_star, here.modulus / at.modulus), (score.w, here.work / at.work)):
        assert 0.5 < abs(rate * score.most / math.log(ratio)) < 2


def test_ranges_beyond_the_interval_count_by_the_chord() -> None:
    """Of rises of chi^2 by 0, 6 and 7: the larger moves of the last two at 1.96 over the root of theirs."""
    at, alternative = still_record(), named("adhesion of finite range")
    score = next(one for one in alternatives_of_record(at).scores if one.name == alternative.name)
    score = replace(score, known=4.0)
    effect = change(alternative.name, at)
    tried = _Amounts(linear(at), effect, np.zeros_like(at.fit.x))
    tried.moves.update({4.0: (0.0, 0.01, -0.02), 2.0: (6.0, 0.3, 0.1), 1.0: (7.0, 0.2, -0.4)})
    found = alone(_of_amounts(tried, score))
    assert found.known == 4
    assert abs(found.moved("E_star")) == pytest.approx(0.3 * 1.96 / math.sqrt(6), rel=1e-4)
    assert abs(found.moved("w")) == pytest.approx(0.4 * 1.96 / math.sqrt(7), rel=1e-4)


def test_a_look_ahead_tells_where_steps_lead() -> None:
    """To first order in the loads chi^2 rises with a surface tension as steps find it, within a twentieth, and unknowns
    move as far within half a standard error: of 10 to 68 that they move, 0.009 to 0.32."""
    at, alternative = of_record(right(AT), usual()), named("surface tension")
    effect = change(alternative.name, at)
    near = linear(at, at.off_folds)
    tried = _Amounts(near, effect, near.moves[near.table.alternatives.index(alternative)])
    amounts = [2e-4, 8e-4, 1.5e-3]
    rises, moves = tried.look_ahead(amounts)
    assert rises[0] < 0 < rises[1]
    for amount, rise, move in zip(amounts, rises, moves, strict=True):
        found = alone(tried.at(amount))
        assert rise == pytest.approx(found[0], rel=0.05)
        assert near.size(tried.ends[amount] - near.x - move) < 0.5


@pytest.mark.parametrize(("words", "line"), [
    (("--bound", "surface_tension=30 mN/m"), 'the bound of surface_tension must be ..HIGH, got "30 mN/m"'),
    (("--bound", "surface_tension=..0 N/m"), "surface_tension: the bound must be > 0, got 0"),
    (("--bound", "surface_tension=..5 nm"), 'surface_tension: must be a surface tension, got "5 nm"'),
    (("--thickness", "1 um", "--bound", "surface_tension=..30 mN/m"), "a bound is for half-spaces without one"),
    (("--contact", "as-is", "--bound", "surface_tension=..30 mN/m"), "surface_tension is for raw force curves, it"),
])  # fmt: skip
def test_bounds_of_surface_tension_that_are_none(jkr: Callable, words: tuple[str, ...], line: str) -> None:
    write_table("table.csv", "delta_m,P_N", 1e-8 * np.arange(1, 40), 1e-9 * np.arange(1, 40) ** 1.5)
    jkr("fit", "--radius", "5 um", "--nu", "0.5", "table.csv", "-o", ".", *words).refused(line)


def test_a_column_that_the_model_itself_makes_has_no_chance_and_warns_of_nothing() -> None:
    """The Jacobian's own first column among those of alternatives: nothing of it is left, and no arithmetic
    overflows."""
    near = linear(still_record())
    first = 1 + len(near.scale)
    gram = near.gram.copy()
    gram[first], gram[:, first] = gram[1], gram[:, 1]
    gram[first, first] = gram[1, 1]
    along = near.along.copy()
    along[:, first] = along[:, 1]
    with np.errstate(all="raise"):
        sizes, taken, moves = _evidence(gram, near.scale, along, near.inverse)
        held = replace(near, gram=gram, along=along, sizes=sizes, shared=taken, moves=moves)
        assert (sizes[0], taken[0], held.alike(0)[0]) == (0.0, 0.0, 0.0)
        assert np.isnan(_tails(np.array([[np.nan, 1.0, 0.0]]), 50.0)).tolist() == [[True, False, False]]
    assert _tails(np.empty((2, 0)), 50.0).shape == (2, 0)  # of a record that no alternative means anything for
    assert _tails(np.array([[4.0, 0.0]]), 50.0)[0] == pytest.approx([fdtrc(1, 50.0, 4.0), 1.0], rel=1e-6)
