"""Verbs of computed curves: ``transform``, ``pull-off``, ``profile``, ``export``."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import click

from ..base.errors import InputError
from ..base.files import together, write_text
from ..base.wings import offered
from ..methods.protocol import Limits
from ..report.result import PICTURES, Files, Output, Results
from . import inputs, options
from .printing import answer, give, present, warn

TYPE_CHECKING = False
if TYPE_CHECKING:
    from ..adhesion.roughness import Roughness
    from ..series import Solution

# --------------------------------------------------------------------------------------------------
# Verbs of series: ``transform``, ``pull-off``, ``profile``, ``export``.


@options.verb("files...")
@click.option("--w", "works", multiple=True, type=options.WORK, help='J/m^2 or "35 mJ/m^2" [default: the case\'s].')
@click.option("--points", type=click.IntRange(2, 100_000), help="Rows of the table [default: those of the solution].")
@options.curve_options
@options.roughness_options
@options.into_folder()
@click.option("--dimensionless", type=click.Choice(["half-space", "thin-layer"]),
              help="Also without dimensions, by Eq. 15 or 19.")  # fmt: skip
@click.option("--scale", "own", multiple=True, type=options.SCALE,
              help='Own units, one a --scale: a="1 um", delta=..., P=..., all three.')  # fmt: skip
@click.option("--together", "in_one", is_flag=True,
              help="One picture of all w, <stem>-all-w.png and .svg, instead of one each.")  # fmt: skip
@options.limits_options
@options.output_options(plots="Write CSV and JSON only.", json="Print the summaries as JSON.")
def transform(
    files: tuple[Path, ...], works: tuple[float, ...], points: int | None, how: options.CurveOptions,
    roughness: Roughness | None, dimensionless: str | None, own: tuple[tuple[str, float], ...], in_one: bool,
    limits: Limits, output: Output,
) -> None:  # fmt: skip
    """Apply the explicit JKR transformation (Eq. 13) to each FILE, a case or a solution, for each work of adhesion.

    With --stress or --range, jkr solves the cohesive zone (Maugis-Dugdale) instead. The results are
    <stem>-w<J/m^2>.csv, .json, .png and .svg; the options --stress, --range and --modulus-factor add their values to
    these names.

    \b
    jkr transform data.h5 --w "50 mJ/m^2"
    jkr transform gel.h5 --w "35 mJ/m^2" --w "40 mJ/m^2" --together -o results
    """
    from ..adhesion.roughness import works_on
    from ..report import forward, tables
    from ..resolve.analysis import analyse
    from ..resolve.sticking import effect_on, sticking_warnings

    if own and dimensionless:
        raise InputError("transform: give either --dimensionless or --scale, got both")
    if in_one and dimensionless:
        raise InputError("transform: --together needs one unit for all w: give --scale instead of --dimensionless")
    if in_one and not output.plots:
        raise InputError("transform: --together has no effect with --no-plots: leave one out")
    users = tables.own_scales(dict(own)) if own else None
    files, solutions = inputs.read_files("transform", files)
    wanted = [works or inputs.works_of(solution) for solution in solutions]
    ranges = list(map(how.of, solutions))
    factor = "" if how.modulus_factor == 1 else f"-modulus{how.modulus_factor:g}"
    end = f"{factor}-rough" if roughness is not None else factor
    ends = [f"{ranged.suffix}{end}" for ranged in ranges]  # of the names of files
    figures = output.plots and not in_one
    inputs.begin_curves("transform", solutions, wanted, limits, ranges, tables=True, figures=figures)
    targets, pictures = _files(files, wanted, ends, in_one, output)
    summaries, lines, warnings = [], list[list[str]](), list[str]()
    with together():
        for solution, works, ranged, places, picture in zip(solutions, wanted, ranges, targets, pictures, strict=True):
            body = solution.scaled(how.modulus_factor)
            acting, rough = works_on(roughness, body.problem, works, bool(ranged))
            effect = effect_on(body, acting)
            warnings += [f"{solution.record.path}: {text}" for text in sticking_warnings(solution.problem, effect)]
            analysed = analyse(solution, acting, how.slopes, how.modulus_factor, ranged)
            curves = [replace(one, effect=effect, rough=by) for one, by in zip(analysed, rough, strict=True)]
            for curve, target in zip(curves, places, strict=True):
                scales = tables.scales_of(curve.problem, curve.w, dimensionless) if dimensionless else users
                summaries.append(tables.curve_summary(curve, scales))
                lines.append(tables.curve_words(curve))
                figure = forward.draw_curve(curve, scales) if figures else None
                target.write(tables.curve_table(curve, scales, points), summaries[-1], figure)
            if picture is not None:
                from ..report.plots.forward import curves_figure

                picture.write(figure=curves_figure(curves, users))
            warnings += [f"{curve.path}: {text}" for curve in curves for text in curve.warnings if not output.json]
    if output.json:
        answer({"results": summaries})
    else:
        written = [str(target) for places in targets for target in places]
        more = f" and {len(written) - 1:,} more like it" if len(written) > 1 else ""
        all_w = ", ".join(str(picture) for picture in pictures if picture is not None)
        present(*lines, last=f"  written {written[0]}{more}{all_w and f', all in one picture: {all_w}'}")
    for text in warnings:
        warn(text)


def _files(
    files: tuple[Path, ...], wanted: list[tuple[float, ...]], ends: list[str], in_one: bool, output: Output
) -> tuple[list[list[Files]], list[Files | None]]:
    """For each file what is written of each work of adhesion, with the ``ends`` of names, and the picture of all of
    them, if there is to be one; InputError before anything is solved, where it cannot be."""
    places = [(output.beside(path), works, end) for path, works, end in zip(files, wanted, ends, strict=True)]
    stems = [begin.with_name(f"{begin.name}-w{w:g}{end}") for begin, works, end in places for w in works]
    endings = (".csv", ".json") if in_one else (".csv", ".json", *PICTURES)
    each = iter(output.each(stems, endings, files, " and w once"))
    pictures: list[Files | None] = [
        output.files(begin.with_name(f"{begin.name}-all-w{end}"), PICTURES, files)
        if in_one and output.plots else None for begin, _, end in places
    ]  # fmt: skip
    return [[next(each) for _ in works] for works in wanted], pictures


# --------------------------------------------------------------------------------------------------
# ``jkr pull-off``: where contact is lost, under every control; and the work of adhesion behind a measured pull-off.

# Of a wing that knows what a measured force means, where it is there
force_options: options.Options = offered("options of a measured pull-off") or options.several()
sizes_option: options.Options = offered("option of particles of all sizes") or options.several()
find_option: options.Options = offered("option of the inverse question") or options.several()
rest_options: options.Options = offered("options of a rest") or options.several()


@options.verb("[files...]", "pull-off")
@inputs.body_options
@click.option("--w", "works", multiple=True, type=options.WORK, help='J/m^2 or "35 mJ/m^2" [default: the case\'s].')
@click.option("--stiffness", "stiffnesses", multiple=True, type=options.CONTROL,
              help='Of the machine or cantilever, "0.2 N/m"; also "load" and "rigid" [default: these two].'
)  # fmt: skip
@force_options
@find_option
@options.roughness_options
@rest_options
@options.curve_options
@options.limits_options
@options.json_option
def pull_off(
    files: tuple[Path, ...], works: tuple[float, ...], stiffnesses: tuple[float, ...], roughness: Roughness | None,
    how: options.CurveOptions, limits: Limits, flags: inputs.Flags, as_json: bool,
    force: float | None = None, uncertain: tuple[tuple[str, str], ...] = (), sought: str | None = None,
    rest_load: float | None = None, rest_depth: float | None = None,
) -> None:  # fmt: skip
    """Print pull-off and jump-in of each FILE (a case or a solution), or of a specimen described by options.

    They are printed for load control, displacement control and each --stiffness, with the energy lost in a cycle. From
    a measured pull-off force (--load) the verb computes the work of adhesion; with --load and --find KEY it computes
    the value of KEY, such as indenter.radius, that gives this force. The option --roughness describes rough surfaces. A
    viscoelastic specimen has several pull-off forces: very slow, very fast, and pulled at once after slow loading.

    \b
    jkr pull-off my.toml --w "50 mJ/m^2" --stiffness "10 N/m"
    jkr pull-off gel.h5 --load "1.2 mN" --uncertain load=3% --uncertain R=1%
    """
    from ..adhesion.curve import DISPLACEMENT_CONTROL, LOAD_CONTROL
    from ..adhesion.roughness import works_on
    from ..report.forward import PullOff, by_history
    from ..resolve.analysis import where_lost

    if sought is not None:
        if roughness is not None:
            raise InputError("pull-off: --find takes smooth surfaces: leave --roughness out")
        give(offered("the inverse question")(files, sought, force, works, stiffnesses, how.slopes, limits), as_json)
        return
    if force is not None and works:
        raise InputError("pull-off: give either --w or --load, not both")
    if force is not None or uncertain:
        offered("idle options of a measured pull-off")(force, uncertain, how.stress, how.length, options.flag)
    if inputs.by_flags("pull-off", flags, files):
        solutions = [_by_flags(flags, works, force, stiffnesses, how, roughness)]
    elif files:
        _, solutions = inputs.read_files("pull-off", files)
    else:
        raise InputError(
            "pull-off: give FILES, a case or a solution, or the specimen from options: --radius, --E, --nu"
        )
    relaxing = [by_history(solution, rest_load, rest_depth, options.flag) for solution in solutions]
    if force is not None:
        measured = offered("work of a measured pull-off")
        give(measured(solutions, relaxing, abs(force), stiffnesses, uncertain, how, limits, roughness), as_json)
        return
    ranges = list(map(how.of, solutions))
    wanted = [works or inputs.works_of(solution) for solution in solutions]
    devices = len(stiffnesses)
    beside = sum(after.seconds(some, devices) for after, some in zip(relaxing, wanted, strict=True) if after)
    inputs.begin_curves("pull-off", solutions, wanted, limits, ranges, devices=devices, beside=beside)
    controls, results = stiffnesses or (LOAD_CONTROL, DISPLACEMENT_CONTROL), list[PullOff]()
    for solution, after, some, ranged in zip(solutions, relaxing, wanted, ranges, strict=True):
        acting, rough = works_on(roughness, solution.problem.scaled(how.modulus_factor), some, bool(ranged))
        lost = where_lost(solution, acting, stiffnesses, how.slopes, how.modulus_factor, ranged)
        for (one, each), by in zip(lost, rough, strict=True):
            curve = replace(one, rough=by)
            results.append(after.pull_off(curve, each, controls, how.slopes) if after else PullOff(curve, each))
    give(Results(results, list(dict.fromkeys(text for one in results for text in one.warnings))), as_json)


def _by_flags(
    flags: inputs.Flags, works: Sequence[float], force: float | None, stiffnesses: Sequence[float],
    how: options.CurveOptions, roughness: Roughness | None,
) -> Solution:  # fmt: skip
    """The specimen from options, solved as far as the question needs; no file is written."""
    from ..adhesion.roughness import works_on
    from ..resolve.reach import solved_for, solved_for_force

    problem = inputs.case_of("pull-off", flags, "a case or solution file", loading={"radius": 1.0}).model.problem()
    if force is not None:
        solution = solved_for_force(problem, abs(force), stiffnesses, how.slopes, how.modulus_factor)
    elif works and not (w := max(works)) > 0:
        raise InputError(f"pull-off: --w must be > 0 to ask where contact is lost, got {w:g} J/m^2")
    elif works:
        acting, _ = works_on(roughness, problem.scaled(how.modulus_factor), works, bool(how.stress or how.length))
        solution = solved_for(problem, acting, how.slopes, how.modulus_factor)
    else:
        raise InputError("pull-off: give --w, or --load with a measured pull-off force")
    called = f"{problem.indenter.words} on {problem.specimen.words}"
    return replace(solution, record=replace(solution.record, path=Path(called)))


# --------------------------------------------------------------------------------------------------
# ``jkr profile``: contact pressure and surface shape at one state.


@options.verb("file")
@options.state_options
@options.range_options
@options.limits_options
@options.into_folder()
@options.output_options(json="Print the summary as JSON.")
def profile(file: Path, state: options.State, attraction: options.RangeOptions, limits: Limits, output: Output) -> None:
    """Compute the contact pressure, the surface displacement and the gap over the radius at one state of FILE, a case
    or a solution.

    The state is always solved on the exact body of the case. On a cylinder the output ends half-way between the contact
    edge and the side, or at r = 3 a if that is nearer. A specimen without slip is solved by finite elements, and a
    column holds the shear stress. With --stress or --range, adhesive tension acts outside the contact, too. The results
    are <stem>-profile.csv, .png and .svg.

    \b
    jkr profile data.h5 --a "5 um"
    jkr profile data.h5 --load "-10 uN" --w "50 mJ/m^2"
    """
    from ..report.forward import Profile
    from ..resolve.analysis import profile_columns, radius_under

    state.refuse_wrong("profile")
    output.folder(Path())
    file, solution, w = inputs.body_and_work("profile", file, state.work, ranged=True)
    ranged, radius = attraction.of(solution), state.radius
    stem = output.folder(file.parent) / f"{file.stem}-profile{ranged.suffix}"
    targets = output.files(stem, (".csv", *PICTURES), [file])
    seconds = 0.0
    if solution.problem.sticks and not ranged and (of_state := offered("seconds of a state by finite elements")):
        seconds = of_state(solution.problem)
    inputs.begin_curves("profile", [solution], [(w,)], limits, [ranged] * (radius is None), beside=seconds)
    if radius is None:
        assert state.load is not None
        radius = radius_under(solution, state.load, w, ranged)
    result = Profile(file, radius, w, profile_columns(solution, radius, w, ranged))
    targets.write(result.columns, figure=result.figure())
    give(result, output.json, f"  written {targets}")


# --------------------------------------------------------------------------------------------------
# ``jkr export``: an adhesive contact as the law of another program.


@options.verb("file")
@click.option("--dem", is_flag=True, help="For particle codes: a C header and a table of load and radius over overlap.")
@sizes_option
@click.option("--nanite", is_flag=True, help="For nanite and PyJibe: a fit model of E, w and the contact point.")
@click.option("--w", "work", type=options.WORK, help='J/m^2 or "35 mJ/m^2" [default: the case\'s first].')
@click.option("--name", help="Of the law or model, in what is written and of its file [default: FILE's].")
@options.slopes_option
@options.limits_options
@options.into_folder()
@options.output_options(json="Print the summary as JSON.")
def export(
    file: Path, dem: bool, nanite: bool, work: float | None, name: str | None, slopes: str, limits: Limits,
    output: Output, sizes: tuple[float, float] | None = None,
) -> None:  # fmt: skip
    """Write the adhesive contact of FILE, a case or a solution, as a law that another program can use.

    With --dem, jkr writes force and contact radius over the overlap of two particles, the state after first touch, and
    the overlap at which contact is lost. The files are <name>-dem.h, a C99 and C++ header with a function and a test of
    it, and <name>-dem.csv. One program can include several laws. With --sizes, one law serves particles of all sizes
    and gives the energy lost in a collision. With --nanite, jkr writes model_jkr_<name>.py, in which nanite or PyJibe
    fits E, w (starting from --w) and the contact point. You may use and distribute the written files under any terms.

    \b
    jkr export coating.h5 --dem --sizes "1 um..100 um"
    jkr export layer.h5 --nanite
    """
    if dem == nanite or (nanite and sizes):
        raise InputError("export: say for what: --dem, for particle codes, --sizes too, or --nanite, for PyJibe")
    if name is not None and not re.fullmatch(r"[A-Za-z0-9][\w-]*", name, re.ASCII):
        raise InputError(f"export: --name takes letters, digits, - and _, got {name!r}")
    output.folder(Path())
    file, solution, w = inputs.body_and_work("export", file, work)
    if w == 0:
        raise InputError(f"{file}: a contact without adhesion needs no table of what holds it: give --w")
    from ..report.export import Exported, NaniteModel, model_name
    from ..resolve.analysis import analyse

    folder, name = output.folder(file.parent), name or file.stem
    stem, endings = (f"{name}-dem", (".h", ".csv")) if dem else (f"model_{model_name(name)}", (".py",))
    targets = output.files(folder / stem, endings, [file])
    inputs.begin_curves("export", [solution], [(w,)], limits)
    curve = analyse(solution, [w], slopes)[0]
    law = offered("law of particles of all sizes")(sizes, limits) if sizes else Exported if dem else NaniteModel
    result = law.of(curve, name)
    with together():
        write_text(targets[endings[0]], result.code)
        targets.write(result.columns if dem else None)
    give(result, output.json, f"  written    {targets}")
