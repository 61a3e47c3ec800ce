"""The material keys of a layer or half-space: homogeneous, graded over depth, or transversely isotropic."""

from __future__ import annotations

import functools
import operator
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, Discriminator, Tag, model_validator

from ..base import did_you_mean
from ..bodies import LAWS, Elastic, Graded, Layer, TransverselyIsotropic
from .fields import BuiltTable, Length, Modulus, Poisson, Table, findings, quantity, table_of, wrong

CONSTANTS = ("E_p", "E_z", "nu_p", "nu_zp", "G_z")


class LawTable(BuiltTable):
    """E of a graded layer, one model per registered law."""

    law: str

    @model_validator(mode="after")
    def _usable(self) -> Self:
        with findings():
            self.built(1.0)
        return self


def _known_law(value: Any) -> Any:
    """A table that names no known law is told so before its other keys are looked at."""
    if isinstance(value, dict) and not {"law", "depth"} & set(value):
        raise wrong(f"needs a law, one of {', '.join(LAWS)}, got keys {', '.join(value) or 'none'}")
    if isinstance(value, dict) and str(value.get("law", "table")) not in LAWS:
        hint = did_you_mean(value["law"], LAWS)
        raise wrong(f'law must be one of {", ".join(LAWS)}, got "{value["law"]}"{hint}')
    return value


def _tag_of_modulus(value: Any) -> str:
    if isinstance(value, LawTable):
        return f"<{value.law}>"
    return f"<{value.get('law', 'table')}>" if isinstance(value, dict) else "<number>"


def _law_table(name: str) -> Any:
    table = table_of(LAWS, name, LawTable, law=(Literal.__getitem__(name), name))
    table.tag = f"<{name}>"
    return Annotated[table, Tag(table.tag)]


ModulusOrLaw = Annotated[
    functools.reduce(operator.or_, map(_law_table, LAWS), Annotated[Modulus, Tag("<number>")]),
    Discriminator(_tag_of_modulus),
    BeforeValidator(_known_law),
]


def _one_modulus(value: Any) -> Any:
    if isinstance(value, dict):
        raise wrong("a half-space is homogeneous: put a graded layer on it, so thick that the rest does not matter")
    return value


class TransverseTable(Table):
    """The five constants of a transversely isotropic material: p in the plane, z along the depth."""

    E_p: Modulus
    E_z: Modulus
    nu_p: quantity("number", above=-1, below=1)
    nu_zp: quantity("number")
    G_z: Modulus

    @model_validator(mode="after")
    def _positive_energy(self) -> Self:
        with findings():
            _ = self.material
        return self

    @property
    def material(self) -> TransverselyIsotropic:
        return TransverselyIsotropic(self.E_p, self.E_z, self.nu_p, self.nu_zp, self.G_z)


class HalfSpaceTable(Table):
    tag: ClassVar[str] = "<isotropic>"
    E: Annotated[Modulus, BeforeValidator(_one_modulus)]
    nu: Poisson

    @property
    def material(self) -> Elastic:
        return Elastic(self.E, self.nu)


class TransverseHalfSpaceTable(TransverseTable):
    tag: ClassVar[str] = "<transverse>"


class LayerTable(Table):
    tag: ClassVar[str] = "<isotropic>"
    E: ModulusOrLaw
    nu: Poisson
    thickness: Length
    name: str = ""

    @model_validator(mode="after")
    def _law_reaches(self) -> Self:
        with findings():
            self.build()
        return self

    def build(self) -> Layer:
        E: Any = self.E
        if isinstance(E, LawTable):
            return Layer(Graded(E.built(self.thickness), self.nu), self.thickness, self.name)
        return Layer(Elastic(E, self.nu), self.thickness, self.name)


class TransverseLayerTable(TransverseTable):
    tag: ClassVar[str] = "<transverse>"
    thickness: Length
    name: str = ""

    def build(self) -> Layer:
        return Layer(self.material, self.thickness, self.name)


def _tag_of_material(value: Any) -> str:
    if isinstance(value, Table):
        return value.tag
    return "<transverse>" if isinstance(value, dict) and any(key in value for key in CONSTANTS) else "<isotropic>"


AnyLayer = Annotated[
    Annotated[LayerTable, Tag(LayerTable.tag)] | Annotated[TransverseLayerTable, Tag(TransverseLayerTable.tag)],
    Discriminator(_tag_of_material),
]
AnyHalfSpace = Annotated[
    Annotated[HalfSpaceTable, Tag(HalfSpaceTable.tag)]
    | Annotated[TransverseHalfSpaceTable, Tag(TransverseHalfSpaceTable.tag)],
    Discriminator(_tag_of_material),
]
