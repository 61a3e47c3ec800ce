"""Case files: TOML in, validated models out, and back again. Everything that is wrong is reported at once."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import tomli_w
from pydantic import ValidationError

from ..base.errors import InputError, counted, did_you_mean, nearest
from ..base.files import read_bytes
from ..base.units import doubtful_work, ranges_of
from ..bodies.indenters import SHAPES
from ..bodies.materials import LAWS, RELAXATIONS, Coated, Graded, GradedTransverselyIsotropic, Law, Layer, Material
from ..bodies.problem import HalfSpace, Problem, Specimen
from ..methods.protocol import METHODS
from .models import CaseModel, RootTable, UnquotedError, other_tables

Root = TypeVar("Root", bound=RootTable)
MOST_BYTES = 2 << 20  # choice: of a file, read at about 1 MiB/s; 10,000 points of a profile take a fifth of it
MOST_TOLD = 100  # choice: mistakes of one file that are told
MOST_PARTS = 50  # of a dotted key; reading takes the square of it
MANY_PARTS = re.compile(rb"""^[ \t\[]*(?:[\w"'-]+[ \t]*\.[ \t]*){%d}""" % MOST_PARTS, re.MULTILINE)
KINDS = {  # what the file must hold, by pydantic's types of findings
    ("model_type", "dict_type", "model_attributes_type"): "a table",
    ("list_type", "tuple_type"): "a list",
    ("int_type", "int_from_float"): "a whole number",
    ("bool_type",): "true or false",
    ("string_type",): "a text",
}
KeysAt = Callable[[tuple[str, ...]], list[str]]
# Of keys that other tables have, which one of them means
ELSEWHERE = {
    "counter_radius": ': the radius of a spherical specimen needs shape = "paraboloid"; omit it on a flat specimen'
}


@dataclass(frozen=True, eq=False, repr=False)
class Case:
    """A validated case: ``model`` holds the values in SI, ``source`` the file they came from, ``text`` what stands
    there where that is a series file, ``remarks`` what may not have been meant as it stands."""

    model: CaseModel
    source: str
    text: str = ""
    remarks: tuple[str, ...] = ()

    def with_tolerance(self, tolerance: float, method: str) -> Case:
        """The case in which ``method`` has this relative error as its tolerance; "auto": every one that can be, as near
        to it as it allows. InputError where no method has it."""
        tree = self.model.model_dump(exclude_none=True)
        ranges = {name: ranges_of(known.options).get("tolerance") for name, known in METHODS.items() if known.options}
        known = {name: ranged for name, ranged in ranges.items() if ranged and method in ("auto", name)}
        if not any(tolerance in ranged for ranged in known.values()):
            allowed = ", ".join(f"{name} takes {ranged.rule}" for name, ranged in known.items())
            allowed = allowed or f"method {method} has none, its formula errs as it does; leave the option out"
            raise InputError(f"--tolerance: {allowed}, got {tolerance:g}")
        for name, ranged in known.items():
            place = METHODS[name].places["tolerance"]
            table = {place.table: tree.get(place.table, {}) | {place.key: ranged.nearest(tolerance)}}
            try:
                tree |= model_of(tree | table, self.source).model_dump(exclude_none=True)
            except InputError:  # a mesh of given sizes, say, that has no tolerance
                if method == name:
                    raise
        return Case(model_of(tree, self.source), self.source, remarks=self.remarks)

    def to_toml(self, method: str | None = None) -> str:
        """The resolved case, every default written out, SI numbers: reads back to the same numbers. With the options
        of the ``method`` alone where one is named, so that what it made never needs another one."""
        if self.text:
            return self.text
        tree = self.model.model_dump(exclude_none=True, exclude=set() if method is None else other_tables(method))
        if method in METHODS and tree["method"] != "auto":
            tree["method"] = method
        return tomli_w.dumps(tree)


def load_case(path: str | Path) -> Case:
    """Load and check a case file.

    Parameters
    ----------
    path : path
        The TOML file.

    Returns
    -------
    Case
        To be solved by `solve`, or checked by `check`.

    Raises
    ------
    InputError
        With a line per mistake: file, line, value and what is allowed.
    """
    path = path if isinstance(path, Path) else Path(path)
    return parse_case(read_bytes(path, "case file"), str(path), path.parent)


def parse_case(content: bytes, source: str, folder: Path | None = None) -> Case:
    """Validate the bytes of a case file; ``folder`` is where relative names of profile tables are looked up."""
    try:
        tree = parse_toml(content, source)
    except UnquotedError as error:
        lines = list(error.lines)
        try:  # what else is wrong in the text
            parse_case(error.quoted.encode(), source, folder)
        except InputError as others:
            lines += others.lines
        raise InputError(lines) from None
    if "base" in tree and "indenter" not in tree:
        raise InputError(f"{source}: is a sweep file, not a case: jkr sweep runs it")
    model = model_of(tree, source, folder)
    # A bare number is read as SI: a remark where that makes a work of adhesion that surfaces hardly have
    works = tree.get("adhesion", {}).get("w", [])
    bare = (work for work in (works if isinstance(works, list) else [works]) if not isinstance(work, str))
    remarks = tuple(f"{source}: adhesion.w: {doubt}" for work in bare if (doubt := doubtful_work(work)))
    return Case(model, source, remarks=remarks)


def parse_toml(content: bytes, source: str) -> dict[str, Any]:
    """The tables in the bytes of a TOML file, not yet looked into."""
    if len(content) > MOST_BYTES:
        raise InputError(f"{source}: is larger than {MOST_BYTES >> 20} MiB; put a long profile into a table of its own")
    if many := MANY_PARTS.search(content):
        line = content.count(b"\n", 0, many.start()) + 1
        raise InputError(f"{source}: line {line}: a key must not have more than {MOST_PARTS} parts")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        series = "; for the case of a solution file use jkr show --case" if source.endswith(".h5") else ""
        raise InputError(f"{source}: is not a text file (byte {error.start} is not UTF-8){series}") from None
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise InputError(f"{source}: is not valid TOML: brackets are nested too deeply") from None
    except tomllib.TOMLDecodeError as error:
        if (unquoted := UnquotedError(source, text)).lines:
            raise unquoted from None
        raise InputError(f"{source}: is not valid TOML: {str(error)[0].lower()}{str(error)[1:]}") from None
    except ValueError:
        raise InputError(f"{source}: is not valid TOML: a number has thousands of digits") from None


def plain_toml(text: str) -> str:
    """The tables in the TOML ``text`` with characters that steer a terminal written as escapes: it reads back to the
    same values. What holds none of them is left as it is."""
    if all(map(str.isprintable, text.split("\n"))):
        return text
    dumped = tomli_w.dumps(parse_toml(text.encode(), "case"))  # in strings alone, and of those basic ones
    return "".join(c if c.isprintable() or c == "\n" else f"\\U{ord(c):08x}" for c in dumped)


def model_of(tree: dict[str, Any], source: str, folder: Path | None = None) -> CaseModel:
    """The case of the tables ``tree``; InputError with a line per mistake, each led by ``source``."""
    return validated(CaseModel, tree, source, folder)


def validated(kind: type[Root], tree: dict[str, Any], source: str, folder: Path | None = None) -> Root:
    """The tables of a whole file as a model of ``kind``; InputError with a line per mistake, each led by ``source``."""
    model = kind.for_tables(tree)
    try:
        return model.model_validate(tree, context={"folder": folder})
    except ValidationError as error:
        raise InputError([f"{source}: {line}" for line in _sentences(error, tree, model.keys_at)]) from None


def _sentences(error: ValidationError, tree: dict[str, Any], keys_at: KeysAt) -> list[str]:
    """One sentence per mistake, sorted; a missing key that an unknown one is a misspelling of is not reported twice."""
    items = error.errors(include_url=False)
    more = [f"has {counted(len(items) - MOST_TOLD, 'more mistake')}"] if len(items) > MOST_TOLD else []
    items = items[:MOST_TOLD]
    meant = {
        (*item["loc"][:-1], close)
        for item in items
        if item["type"] == "extra_forbidden"
        if (close := nearest(item["loc"][-1], _allowed(item["loc"], keys_at)))
    }
    mistakes = [item for item in items if not (item["type"] == "missing" and item["loc"] in meant)]
    return [*sorted({_sentence(item, tree, keys_at) for item in mistakes}), *more]


def _sentence(item: Any, tree: dict[str, Any], keys_at: KeysAt) -> str:
    """One of pydantic's findings in our words: ``specimen.layers[1].E: must be > 0, got -3 Pa``."""
    where, value, context = _path(item["loc"], tree), item["input"], item.get("ctx", {})
    match item["type"]:
        case "missing":
            return f"{where}: is required"
        case "extra_forbidden":
            keys = _allowed(item["loc"], keys_at)
            hint = ELSEWHERE.get(str(item["loc"][-1])) or did_you_mean(item["loc"][-1], keys)
            return f"{where}: unknown key{hint} (allowed: {', '.join(keys)})"
        case "literal_error":
            allowed = [str(word).strip("'") for word in context["expected"].replace(" or ", ", ").split(", ")]
            return f"{where}: must be one of {', '.join(allowed)}, got {shown(value)}{did_you_mean(value, allowed)}"
        case "union_tag_not_found":
            return f"{where}.{context['discriminator'].strip(chr(39))}: is required"
        case "union_tag_invalid":
            allowed = context["expected_tags"].replace("'", "").split(", ")
            tag = context["tag"]
            return f'{where}.shape: must be one of {", ".join(allowed)}, got "{tag}"{did_you_mean(tag, allowed)}'
        case "jkr":
            hint = ""
            if value == "rigid" and where == "indenter.E":
                hint = "; a rigid indenter is one without E and nu: leave both out"
            elif value == "rigid" and where.endswith(".E"):
                hint = (
                    "; an elastic lens on a rigid plate is the contact of a rigid lens on a half-space of the lens's "
                    'material: give that E and nu here and none in [indenter]; below layers base = "bonded" is rigid'
                )
            return f"{where}: {item['msg']}{hint}" if where else item["msg"]
        case "greater_than_equal" | "less_than_equal":
            bound = f">= {context['ge']}" if "ge" in context else f"<= {context['le']}"
            return f"{where}: must be {bound}, got {shown(value)}"
    wanted = next((f"must be {words}" for kinds, words in KINDS.items() if item["type"] in kinds), item["msg"])
    return f"{where}: {wanted}, got {shown(value)}"


def _path(loc: tuple[Any, ...], tree: dict[str, Any]) -> str:
    """``("specimen", "layers", 1, "E")`` -> ``specimen.layers[1].E``, as the keys stand in the file's ``tree``."""
    path, here = "", tree
    for part in loc:
        if isinstance(part, int):
            if not isinstance(here, list):
                continue  # a single value that stands for a list of one
            path += f"[{part}]"
            here = here[part] if part < len(here) else None
        elif part.startswith("<") or (part in SHAPES and isinstance(here, dict) and here.get("shape") == part):
            continue  # the tag of a material, a law or a shape, not a key
        else:
            path += f".{part}" if path else str(part)
            here = here.get(part) if isinstance(here, dict) else None  # type: ignore[assignment]
    return path


def _allowed(loc: tuple[Any, ...], keys_at: KeysAt) -> list[str]:
    """The keys that the table around an unknown key at ``loc`` may have."""
    return keys_at(tuple(part for part in loc[:-1] if not isinstance(part, int)))


def shown(value: Any) -> str:
    """A value as the user would recognise it, on one line and not too long."""
    if isinstance(value, str):
        text = '"' + value.replace("\n", "\\n") + '"'
    elif isinstance(value, bool):
        text = str(value).lower()
    else:
        text = "a table" if isinstance(value, dict) else str(value)
    return text if len(text) <= 60 else text[:57] + "..."


# --------------------------------------------------------------------------------------------------
# Cases from problems made in Python: the inverse of the tables' ``build``.


def case_of(problem: Problem) -> Case:
    """A case of ``problem``, with defaults for all else; InputError where no case can say it."""
    if isinstance(problem.indenter.material, Coated):
        layers = [_layer(layer) for layer in problem.indenter.material.layers]
        indenter = _material(problem.indenter.material.core) | {"layers": layers}
    else:
        indenter = _material(problem.indenter.material)
    loading = problem.loading
    if loading.spacing != "given":
        to: dict[str, Any] = {loading.to: loading.maximum, "points": loading.points, "spacing": loading.spacing}
    else:
        to = {loading.to: loading.values} if len(loading.values) > 1 else {loading.to: loading.maximum, "points": 1}
    tree = {
        "indenter": problem.indenter.keys | indenter,
        "specimen": _specimen(problem.specimen) | ({"surface": "sticking"} if problem.sticks else {}),
        "loading": to,
    }
    return Case(model_of(tree, "problem"), "problem")


def _material(material: Material | None) -> dict[str, Any]:
    if isinstance(material, Graded):
        return {"E": LAWS.keys_in_file(material.law), "nu": material.nu}
    if isinstance(material, GradedTransverselyIsotropic):
        return {key: LAWS.keys_in_file(one) if isinstance(one, Law) else one for key, one in vars(material).items()}
    return {} if material is None else dict(vars(material))


def _specimen(specimen: Specimen) -> dict[str, Any]:
    tree: dict[str, Any] = {"layers": [_layer(layer) for layer in specimen.layers]}
    if isinstance(specimen.base, HalfSpace):
        tree["half_space"] = _material(specimen.base.material)
    else:
        tree["base"] = "bonded" if specimen.base.bonded else "frictionless"
    if specimen.radius is not None:
        tree |= {"radius": specimen.radius, "side": specimen.side}
    if specimen.surface_tension:
        tree["surface_tension"] = specimen.surface_tension
    if specimen.relaxation is not None:
        tree["relaxation"] = RELAXATIONS.keys_in_file(specimen.relaxation)
    return tree


def _layer(layer: Layer) -> dict[str, Any]:
    return _material(layer.material) | {"thickness": layer.thickness, "name": layer.name}
