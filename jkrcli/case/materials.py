"""The material keys of a layer or half-space: homogeneous, graded over depth, or transversely isotropic."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, Discriminator, Tag, model_validator

from ..base.errors import InputError, did_you_mean
from ..bodies import grading
from ..bodies.materials import Elastic, Graded, TransverselyIsotropic
from ..bodies.problem import Layer
from .fields import AnyLength, Length, Modulus, Poisson, Table, as_tuple, quantity, wrong

CONSTANTS = ("E_p", "E_z", "nu_p", "nu_zp", "G_z")


class LawTable(Table):
    """E of a graded layer."""

    def build(self, thickness: float) -> grading.Law:
        raise AssertionError("each law builds its own")


class LinearTable(LawTable):
    """From ``top`` to ``bottom`` of the layer on a straight line."""

    tag: ClassVar[str] = "<linear>"
    law: Literal["linear"]
    top: Modulus
    bottom: Modulus

    def build(self, thickness: float) -> grading.Law:
        return grading.Linear(self.top, self.bottom, thickness)


class ExponentialTable(LawTable):
    """From ``top`` to ``bottom`` of the layer by equal factors over equal depths."""

    tag: ClassVar[str] = "<exponential>"
    law: Literal["exponential"]
    top: Modulus
    bottom: Modulus

    def build(self, thickness: float) -> grading.Law:
        return grading.Exponential(self.top, self.bottom, thickness)


class PowerTable(LawTable):
    """top (1 + z/length)^exponent."""

    tag: ClassVar[str] = "<power>"
    law: Literal["power"]
    top: Modulus
    length: Length
    exponent: quantity("number")

    def build(self, thickness: float) -> grading.Law:
        return grading.Power(self.top, self.length, self.exponent)


class TabulatedTable(LawTable):
    """Moduli ``E`` at ``depth`` below the layer's top, straight lines between them."""

    tag: ClassVar[str] = "<table>"
    law: Literal["table"] = "table"
    depth: Annotated[tuple[AnyLength, ...], BeforeValidator(as_tuple)]
    E: Annotated[tuple[Modulus, ...], BeforeValidator(as_tuple)]

    @model_validator(mode="after")
    def _usable(self) -> Self:
        try:
            self.build(0.0)
        except InputError as error:
            raise wrong(str(error)) from None
        return self

    def build(self, thickness: float) -> grading.Law:
        return grading.Tabulated(self.depth, self.E)


LAWS = ("linear", "exponential", "power", "table")


def _known_law(value: Any) -> Any:
    """A table that names no known law is told so before its other keys are looked at."""
    if isinstance(value, dict) and not {"law", "depth"} & set(value):
        raise wrong(f"needs a law, one of {', '.join(LAWS)}, got keys {', '.join(value) or 'none'}")
    if isinstance(value, dict) and value.get("law", "table") not in LAWS:
        hint = did_you_mean(value["law"], LAWS)
        raise wrong(f'law must be one of {", ".join(LAWS)}, got "{value["law"]}"{hint}')
    return value


def _tag_of_modulus(value: Any) -> str:
    if isinstance(value, LawTable):
        return value.tag
    return f"<{value.get('law', 'table')}>" if isinstance(value, dict) else "<number>"


ModulusOrLaw = Annotated[
    Annotated[
        Annotated[Modulus, Tag("<number>")]
        | Annotated[LinearTable, Tag(LinearTable.tag)]
        | Annotated[ExponentialTable, Tag(ExponentialTable.tag)]
        | Annotated[PowerTable, Tag(PowerTable.tag)]
        | Annotated[TabulatedTable, Tag(TabulatedTable.tag)],
        Discriminator(_tag_of_modulus),
    ],
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
        try:
            _ = self.material
        except InputError as error:
            raise wrong(str(error)) from None
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
        try:
            self.build()
        except InputError as error:
            raise wrong(str(error)) from None
        return self

    def build(self) -> Layer:
        if isinstance(self.E, LawTable):
            return Layer(Graded(self.E.build(self.thickness), self.nu), self.thickness, self.name)
        return Layer(Elastic(self.E, self.nu), self.thickness, self.name)


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
