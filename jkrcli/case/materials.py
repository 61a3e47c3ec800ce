"""Layers and half-spaces: homogeneous, graded over depth, or transversely isotropic."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Self

from pydantic import BeforeValidator, model_validator

from ..bodies import Elastic, Graded, HalfSpace, Layer, TransverselyIsotropic
from .fields import Length, Modulus, Poisson, Table, either, findings, quantity, wrong
from .laws import LawTable, ModulusOrLaw


class _Part(Table):
    @model_validator(mode="after")
    def _usable(self) -> Self:
        with findings():
            self.build()
        return self

    def build(self) -> Layer | HalfSpace:
        return HalfSpace(self.material(math.inf))

    def material(self, thickness: float) -> Any:
        """The material of a part of this ``thickness`` [m]."""
        raise NotImplementedError


class _Layer(_Part):
    thickness: Length
    name: str = ""

    def build(self) -> Layer:
        return Layer(self.material(self.thickness), self.thickness, self.name)


class IsotropicTable(_Part):
    """E, or its law over the depth, and nu."""

    tag: ClassVar[str] = "isotropic"
    E: ModulusOrLaw
    nu: Poisson

    def material(self, thickness: float) -> Elastic | Graded:
        E: Any = self.E
        return Graded(E.built(thickness), self.nu) if isinstance(E, LawTable) else Elastic(E, self.nu)


class TransverseTable(_Part):
    """The five constants of a transversely isotropic material: p in the plane, z along the depth."""

    tag: ClassVar[str] = "transverse"
    E_p: Modulus
    E_z: Modulus
    nu_p: quantity("number", above=-1, below=1)
    nu_zp: quantity("number")
    G_z: Modulus

    def material(self, thickness: float) -> TransverselyIsotropic:
        return TransverselyIsotropic(self.E_p, self.E_z, self.nu_p, self.nu_zp, self.G_z)


class LayerTable(_Layer, IsotropicTable): ...


class TransverseLayerTable(_Layer, TransverseTable): ...


def _one_modulus(value: Any) -> Any:
    if isinstance(value, dict):
        raise wrong("a half-space is homogeneous: put a graded layer on it, so thick that the rest does not matter")
    return value


def _one_modulus_of_coating(value: Any) -> Any:
    if isinstance(value, dict):
        raise wrong("a layer of the indenter is homogeneous: cut a graded one into several")
    return value


class CoatingTable(LayerTable):
    E: Annotated[Modulus, BeforeValidator(_one_modulus_of_coating)]


class HalfSpaceTable(IsotropicTable):
    E: Annotated[Modulus, BeforeValidator(_one_modulus)]


def _tag(value: Any) -> str:
    constants = isinstance(value, dict) and not TransverseTable.model_fields.keys().isdisjoint(value)
    return (TransverseTable if constants else IsotropicTable).tag


AnyLayer = either(_tag, LayerTable, TransverseLayerTable)
AnyCoating = either(_tag, CoatingTable, TransverseLayerTable)
AnyHalfSpace = either(_tag, HalfSpaceTable, TransverseTable)
