"""Case files: TOML in, validated models out, and back again. Everything that is wrong is reported at once."""

from __future__ import annotations

import difflib
import math
import tomllib
from pathlib import Path
from typing import Any

import tomli_w
from pydantic import ValidationError

from ..errors import InputError
from ..files import read_bytes
from .indenter import SHAPES
from .models import CaseModel


class Case:
    """A validated case: ``model`` holds the values in SI, ``source`` the file they came from."""

    def __init__(self, model: CaseModel, source: str):
        self.model = model
        self.source = source

    def to_toml(self) -> str:
        """The resolved case, every default written out, SI numbers: reads back to the same numbers."""
        return tomli_w.dumps(self.model.model_dump(exclude_none=True))


def load_case(path: str | Path) -> Case:
    """Read and validate a case file; InputError names file, key, value and what is allowed, a line per mistake."""
    path = Path(path)
    return parse_case(read_bytes(path, "case file"), str(path), path.parent)


def parse_case(content: bytes, source: str, folder: Path | None = None) -> Case:
    """Validate the bytes of a case file; ``folder`` is where relative names of profile tables are looked up."""
    try:
        tree = tomllib.loads(content.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise InputError(f"{source}: is not a text file (byte {error.start} is not UTF-8)") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{source}: is not valid TOML: {str(error)[0].lower()}{str(error)[1:]}") from None
    try:
        return Case(CaseModel.model_validate(tree, context={"folder": folder}), source)
    except ValidationError as error:
        raise InputError([f"{source}: {line}" for line in _sentences(error, tree)]) from None


def _sentences(error: ValidationError, tree: dict[str, Any]) -> list[str]:
    """One sentence per mistake, sorted; a missing key that an unknown one is a misspelling of is not said twice."""
    items = error.errors()
    meant = {
        (*item["loc"][:-1], close) for item in items if item["type"] == "extra_forbidden" for close in _close(item)
    }
    kept = [item for item in items if not (item["type"] == "missing" and item["loc"] in meant)]
    return sorted({_sentence(item, tree) for item in kept})


def _sentence(item: Any, tree: dict[str, Any]) -> str:
    """One of pydantic's findings in our words: ``specimen.layers[1].E: must be > 0, got -3 Pa``."""
    where, value, context = _path(item["loc"], tree), item["input"], item.get("ctx", {})
    match item["type"]:
        case "missing":
            return f"{where}: is required"
        case "extra_forbidden":
            return f"{where}: unknown key{_suggest(item)}"
        case "literal_error":
            allowed = [str(word).strip("'") for word in context["expected"].replace(" or ", ", ").split(", ")]
            close = difflib.get_close_matches(str(value), allowed, 1, 0.5)
            hint = f', did you mean "{close[0]}"?' if close else ""
            return f"{where}: must be one of {', '.join(allowed)}, got {shown(value)}{hint}"
        case "union_tag_not_found":
            return f"{where}.{context['discriminator'].strip(chr(39))}: is required"
        case "union_tag_invalid":
            allowed = context["expected_tags"].replace("'", "").split(", ")
            close = difflib.get_close_matches(str(context["tag"]), allowed, 1, 0.5)
            hint = f', did you mean "{close[0]}"?' if close else ""
            return f'{where}.shape: must be one of {", ".join(allowed)}, got "{context["tag"]}"{hint}'
        case "jkr":
            return f"{where}: {item['msg']}" if where else item["msg"]
        case "model_type" | "dict_type" | "model_attributes_type":
            return f"{where}: must be a table, got {shown(value)}"
        case "list_type" | "tuple_type":
            return f"{where}: must be a list, got {shown(value)}"
        case "int_type" | "int_from_float":
            return f"{where}: must be a whole number, got {shown(value)}"
        case "bool_type":
            return f"{where}: must be true or false, got {shown(value)}"
        case "string_type":
            return f"{where}: must be a text, got {shown(value)}"
        case "greater_than_equal":
            return f"{where}: must be >= {context['ge']}, got {shown(value)}"
        case "less_than_equal":
            return f"{where}: must be <= {context['le']}, got {shown(value)}"
    return f"{where}: {item['msg']}, got {shown(value)}"


def _path(loc: tuple[Any, ...], tree: dict[str, Any]) -> str:
    """``("specimen", "layers", 1, "E")`` -> ``specimen.layers[1].E``, as the keys stand in the file's ``tree``."""
    path, here = "", tree
    for part in loc:
        if isinstance(part, int):
            if not isinstance(here, list):
                continue  # a single value that stands for a list of one
            path += f"[{part}]"
            here = here[part]
        elif part in SHAPES and isinstance(here, dict) and here.get("shape") == part:
            continue  # the tag of the shape, not a key
        else:
            path += f".{part}" if path else str(part)
            here = here.get(part) if isinstance(here, dict) else None  # type: ignore[assignment]
    return path


def _allowed(loc: tuple[Any, ...]) -> list[str]:
    """The keys that the table around an unknown key at ``loc`` may have."""
    return CaseModel.keys_at(tuple(part for part in loc[:-1] if not isinstance(part, int)))


def _close(item: Any) -> list[str]:
    """What the user may have meant by an unknown key: one key or none."""
    return difflib.get_close_matches(str(item["loc"][-1]), _allowed(item["loc"]), 1, 0.5)


def _suggest(item: Any) -> str:
    hint = "".join(f', did you mean "{close}"?' for close in _close(item))
    return f"{hint} (allowed: {', '.join(_allowed(item['loc']))})"


def shown(value: Any) -> str:
    """A value as the user would recognise it, on one line and not too long."""
    if isinstance(value, str):
        text = '"' + value.replace("\n", "\\n") + '"'
    elif isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, float) and not math.isfinite(value):
        text = str(value)
    elif isinstance(value, dict):
        text = "a table"
    else:
        text = str(value)
    return text if len(text) <= 60 else text[:57] + "..."
