"""Ten cylinders, free, roller and clamped, on which methods for finite bodies are compared; contact radii up to 1."""

from dataclasses import replace

from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Rigid, Side, Specimen


def stack(*layers: tuple[float, float, float], base: Rigid | HalfSpace | None = None) -> Specimen:
    """Layers (E, nu, h) on a rigid base, bonded if nothing else is said."""
    return Specimen(tuple(Layer(Elastic(E, nu), h) for E, nu, h in layers), base or Rigid())


def cylinder(
    L: float, H: float, side: Side, nu: float = 0.3, bonded: bool = True, below: float | None = None
) -> Specimen:
    """A homogeneous cylinder, or one whose lower half has the modulus ``below``."""
    layers = [(1.0, nu, H)] if below is None else [(1.0, nu, H / 2), (below, 0.3, H / 2)]
    return replace(stack(*layers, base=Rigid(bonded)), radius=L, side=side)


FINITE = {
    "free": cylinder(1.3, 1.0, "free"),
    "free, tall": cylinder(1.5, 3.0, "free", 0.45),
    "roller": cylinder(2.0, 2.0, "roller"),
    "clamped": cylinder(1.5, 1.0, "clamped"),
    "free, sliding": cylinder(1.5, 1.0, "free", bonded=False),
    "free, nu = 1/2": cylinder(2.0, 1.0, "free", 0.5),
    "clamped, nu = 0.499": cylinder(1.5, 1.0, "clamped", 0.499),
    "free, 1:10": cylinder(1.5, 1.0, "free", below=10.0),
    "free, 10:1": cylinder(1.5, 1.0, "free", below=0.1),
    "disc": cylinder(5.0, 0.5, "free"),
}
