"""Cases that are refused, what is said, and what to do about it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

Tree = dict[str, Any]


def layer(h: str = "10 um", E: str = "1 MPa", nu: float = 0.4) -> Tree:
    return {"thickness": h, "E": E, "nu": nu}


def cylinder(radius: str, *layers: Tree, side: str = "free", **others: str) -> Tree:
    return {"layers": list(layers or (layer(),)), "radius": radius, "side": side, **others}


# fmt: off
BASE: Tree = {
    "indenter": {"shape": "paraboloid", "radius": "1 mm"},
    "specimen": {"layers": [layer()]},
    "loading": {"radius": "10 um", "points": 10},
}
LAYERED, HYBRID, CLOSED = ({"method": name} for name in ("layered", "hybrid", "closed-form"))
ELASTIC, RIGID = {"E": "1 MPa", "nu": 0.3}, {"indenter": {"E": None, "nu": None}}
HALF_SPACE = {"half_space": ELASTIC, "layers": None}
RUBBER, THIN = {"layers": [layer(nu=0.5)]}, {"layers": [layer("1 um", nu=0.5)]}
ACROSS = {"E_p": "2 MPa", "E_z": "1 MPa", "nu_p": 0.3, "nu_zp": 0.2, "G_z": "0.5 MPa"}
GRADED = {"thickness": "10 um", "E": {"law": "linear", "top": "1 MPa", "bottom": "2 MPa"}, "nu": 0.4}
SPHERE = {"shape": "sphere", "radius": "9 um"}
FLAT = {"shape": "flat", "radius": None, "flat_radius": "5 um", "edge_radius": "1 mm"}
PUNCH = {"shape": "flat", "radius": "10 um"}
TABLE = {"shape": "table", "radius": None, "r": ["0 um", "1 um", "5 um"], "f": ["0 um", "0.1 um", "1 um"]}
LARGER = {"r": ["0 um", "1 um", "50 um"], "f": ["0 um", "0.1 um", "10.9 um"]}
ROD = cylinder("1.06 um", layer("80 um", nu=0.1), layer("160 um", "2.5 kPa", 0.3), side="roller", base="frictionless")
STIFF = {  # a cone on a coating 700 times as stiff as its substrate
    "indenter": {"shape": "power", "radius": None, "coefficient": 0.1, "exponent": 1},
    "specimen": {"layers": [{"thickness": 1.0, "E": 1.0, "nu": 0.141}], "half_space": {"E": 0.0013937, "nu": 0.3}},
    "loading": {"radius": 2.0},
}
COARSE: Tree = {"spacing": 0.15, "estimate_error": False}
CLOSE = [f"{r} um" for r in (7, 7.1, 7.2, 7.3, 9, 9.2, 9.4)]
ZONES = {"layout": "zones", "estimate_error": False}
# fmt: on


def merged(tree: Mapping[str, Any], changes: Mapping[str, Any]) -> Tree:
    """``tree`` with ``changes`` in its tables; None leaves a key out."""
    found = dict(tree)
    for key, value in changes.items():
        old = found.pop(key, None)
        if isinstance(value, dict):
            found[key] = merged(old if isinstance(old, dict) else {}, value)
        elif value is not None:
            found[key] = value
    return found


def fem(mesh: Tree | None = None, **tables: Any) -> Tree:
    return {"method": "fem", "mesh": {**COARSE, **(mesh or {})}, **tables}


Change = Tree | Callable[[tuple[str, ...]], Tree]


@dataclass(frozen=True)
class Kind:
    """``says``: the message, {} for values; each of ``remedies``: a change of the ``case`` that does as it says, maybe
    by those values; ``near``: how far P(delta) may then lie from that of a wide body, None: not compared; ``limits``:
    constants, or fields of tunings, that are lowered so that a small body meets them."""

    says: str
    case: Tree
    remedies: tuple[Change, ...]
    near: float | None
    limits: Mapping[str, float]


def kind(says: str, case: Tree, *remedies: Change, near: float | None = 0.01, **limits: float) -> Kind:
    return Kind(says, case, remedies, near, {name.replace("__", "."): value for name, value in limits.items()})


RIGID_ONLY = "method fem: an elastic indenter on a layered or finite body is not represented by a rigid profile: "
TOO_MANY = "mesh: about {} elements expected, too many {}s (at most {}): "
ZONE = (
    "contact leaves the refined zone: mesh.contact_radius is {} m, this loading needs about {} m: give that or leave "
    "it out"
)
EDGE = "contact reaches the edge of the body or of the indenter's profile, {} m, before the {} reaches {}: load less"
BELOW = (
    "loading: {} {} {} lies below the first that the mesh resolves, {} {}: take a smaller mesh.smallest (layout zones:"
    " mesh.element_size), or larger values"
)
UNREACHED = (
    "mesh.tolerance: {} is not reached: with {} unknowns the estimated error is {}; use a larger one, leave out "
    "mesh.depth and mesh.width, or use the method layered where it represents the body"
)
COST = (
    "{}hybrid: contact radii up to {} need elements of degree {} with about {} unknowns for {} right-hand sides, {} "
    "and {} MiB (limits {} s, {} MiB): the contact is large against the nearest interface or side ({} away); use a"
    " smaller contact or a larger hybrid.tolerance, or use method "
)
AXIS = "method hybrid: the exact part needs an isotropic material at the contact: use method "
ROWS = (
    "{}hybrid: the contact or body is so large against the nearest interface that elements would lie in {} rows (limit"
    " {}); use a smaller contact, or use the method "
)
UNSURE = "hybrid: the estimated relative error is {} with elements of degree {}, above the tolerance {}; "
SIDE = (
    "loading: before a {} of {} the contact comes too near to the side (a at most 0.98 of the body's radius, {}): load"
    " less, or use method fem"
)
BEYOND = (
    "loading: a contact radius of {} lies beyond the profile, which ends at r = {}; use less, or give a larger profile"
)
REACH = (
    "loading: a {} of {} cannot be reached: it needs a contact radius beyond the profile, which ends at r = {}; use "
    "less, or give a larger profile"
)
FEM_RIGID = "fem (with a rigid indenter)"
FALLS = (
    "the displacement falls beyond the contact radius {}: under a coating so much stiffer than its substrate the "
    "contact is no longer a growing disc; use a smaller radius"
)
MUCH = (
    "layered: a = {} m is {} times the length over which the layers act ({} m) and needs {} nodes for {} (limit "
    "{}); use a smaller contact"
)
FORMULAE = (
    "method closed-form: solves homogeneous half-spaces and thin single isotropic layers only: use method {} or fem"
)
# fmt: off
KINDS = {
    # ------------------------------------------------------------ fem
    "fem: elastic indenter": kind(RIGID_ONLY + "use method layered, or a rigid indenter", fem(indenter=ELASTIC),
        LAYERED, RIGID),
    "fem: flat punch": kind("method fem: contact radii of nodes do not meet the sharp edge of a flat punch: use method "
        "layered, or give indenter.flat_radius and edge_radius", fem(indenter=PUNCH), LAYERED, {"indenter": FLAT},
        near=None),
    "fem: first order": kind("method fem: nu = 0.5 needs second-order elements: set mesh.order = 2",
        fem({"order": 1}, specimen=RUBBER), {"mesh": {"order": 2}}),
    "fem: displacements": kind(
        'method fem: nu = 0.5 needs a pressure unknown: set mesh.formulation = "mixed", or leave it out',
        fem({"formulation": "displacement"}, specimen=RUBBER),
        {"mesh": {"formulation": "mixed"}}, {"mesh": {"formulation": None}}),
    "fem: spacing": kind(
        "method fem: " + TOO_MANY + "take a larger mesh.spacing or mesh.smallest, or a larger mesh.growth",
        fem({"spacing": 1e-6}), {"mesh": {"spacing": 0.15}}),
    "fem: points": kind(
        "mesh: {} points between {} and {} of the contact's size, at most {}: take a larger mesh.spacing or "
        "mesh.smallest, or a smaller mesh.width or specimen",
        fem({"width": "1 km"}, specimen=THIN), {"mesh": {"width": "50 um"}}),
    "fem: quadrilaterals": kind(
        "method fem: " + TOO_MANY + "take a larger mesh.spacing or mesh.smallest, or triangles",
        fem({"element": "quadrilateral"}), {"mesh": {"element": "triangle"}},
        jkrcli__fem__mesh__LAYOUT_MOST_CELLS=1000),
    "fem: zones": kind("method fem: " + TOO_MANY + "take a larger mesh.element_size, or a larger mesh.growth",
        {"method": "fem", "mesh": {**ZONES, "element_size": 1e-12}}, {"mesh": {"element_size": "1 um"}}),
    "fem: a tolerance of too many": kind("method fem: " + TOO_MANY + "use a larger mesh.tolerance, or use the "
        "method layered where it represents the body",
        {"method": "fem", "specimen": HALF_SPACE, "mesh": {"tolerance": 1e-6}}, {"mesh": {"tolerance": 1e-3}}),
    "fem: refined zone": kind(ZONE, fem({"contact_radius": "3 um"}),
        lambda said: {"mesh": {"contact_radius": float(said[1])}}, {"mesh": {"contact_radius": None}}),
    "fem: refined zone within the flat": kind("method fem: mesh.contact_radius: {} m must be "
        "larger than the flat end of the indenter ({} m): give more or leave it out",
        fem({"contact_radius": "1 um"}, specimen=HALF_SPACE, indenter=FLAT), {"mesh": {"contact_radius": None}}),
    "fem: edge, by radius": kind(EDGE, fem(specimen=cylinder("8 um")), {"loading": {"radius": "7.5 um"}}, near=None),
    "fem: depth within the contact": kind(
        "method fem: mesh.depth: {} m leaves too little of the half-space below contact and layers; give more than {} "
        "m or leave it out", fem({"depth": "15 um"}, specimen=HALF_SPACE),
        lambda said: {"mesh": {"depth": 1.001 * float(said[1])}}, {"mesh": {"depth": None}}, near=None),
    "fem: depth on a base": kind("method fem: mesh.depth: the specimen ends at its rigid substrate, {} m deep: leave "
    "it out",
        fem({"depth": "20 um"}), {"mesh": {"depth": None}}),
    "fem: width of a cylinder": kind("method fem: mesh.width: the specimen ends at its radius, {} m: leave it out",
        fem({"width": "60 um"}, specimen=cylinder("60 um")), {"mesh": {"width": None}}),
    "fem: width within the contact": kind(
        "method fem: mesh.width: must be more than 1.5 times the refined zone, {} m, or left out, got {} m",
        fem({"width": "15 um"}), lambda said: {"mesh": {"width": 1.001 * float(said[0])}}, {"mesh": {"width": None}},
        near=None),
    "fem: below the first vertex": kind(BELOW, fem(loading={"radius": ["1 nm", "10 um"], "points": None}),
        {"mesh": {"smallest": 1e-4}}, lambda said: {"loading": {"radius": [1.01 * float(said[3]), 1e-5]}}),
    "fem: tolerance under a cut": kind(UNREACHED, {"method": "fem", "specimen": HALF_SPACE,
        "mesh": {"tolerance": 1e-3, "depth": "200 um", "width": "120 um"}},
        lambda said: {"mesh": {"tolerance": 1.5 * float(said[2])}}, {"mesh": {"depth": None, "width": None}},
        LAYERED, near=0.03),
    "fem: spacing beside a tolerance": kind("method fem: mesh.spacing and mesh.growth follow from mesh.tolerance: "
        "leave them out, or leave out the tolerance (--tolerance)", {"method": "fem", "specimen": HALF_SPACE,
        "mesh": {"tolerance": 1e-2, "spacing": 0.02}}, {"mesh": {"spacing": None}}, {"mesh": {"tolerance": None}}),
    "fem: tolerance with radii of vertices": kind(UNREACHED, {"method": "fem", "specimen": HALF_SPACE,
        "mesh": {"tolerance": 1e-3}, "contact": {"algorithm": "incremental"}},
        lambda said: {"mesh": {"tolerance": 1.5 * float(said[2])}}, LAYERED,
        jkrcli__fem__REFINEMENT_FINEST=0.02),
    # ------------------------------------------------------------ hybrid
    "hybrid: half-space": kind(
        "method hybrid: a homogeneous half-space needs no correction: use method closed-form or layered",
        {**HYBRID, "specimen": HALF_SPACE}, CLOSED, LAYERED),
    "hybrid: half-space with an axis": kind("method hybrid: the far field of a transversely isotropic half-space is "
        "not known here: use method layered or fem", {**HYBRID, "specimen": {"half_space": ACROSS}}, LAYERED, fem()),
    "hybrid: graded at the contact": kind("method hybrid: the correction is not smooth where the modulus changes from "
        "the contact on: use method layered", {**HYBRID, "specimen": {"layers": [GRADED]}}, LAYERED),
    "hybrid: axis at the contact": kind(
        AXIS + FEM_RIGID,
        {**HYBRID, "specimen": cylinder("60 um", {"thickness": "10 um", **ACROSS}), "indenter": ELASTIC},
        fem(**RIGID)),
    "hybrid: side, by radius": kind("method hybrid: " + SIDE,
        {**HYBRID, "specimen": cylinder("10 um"), "loading": {"radius": "9.9 um"}},
        {"loading": {"radius": "9 um"}}, fem(), near=None),
    "hybrid: cost": kind(COST + "layered", {**HYBRID, "specimen": THIN, "loading": {"radius": "20 um"}},
        {"loading": {"radius": "5 um"}}, {"hybrid": {"tolerance": 1e-2}}, LAYERED,
        jkrcli__hybrid__kernel__HYBRID_MOST_SECONDS=0.5),
    "hybrid: rows": kind(ROWS + "fem (with a rigid indenter)",
        {**HYBRID, "specimen": cylinder("200 um", layer("1 um")), "loading": {"radius": "20 um"}},
        fem(), {"loading": {"radius": "2 um"}}, jkrcli__hybrid__correction__LINE_MOST=15),
    "hybrid: accuracy": kind(
        UNSURE + "set hybrid.tolerance to {}, or use a smaller contact radius or use method fem",
        {**HYBRID, "specimen": ROD, "loading": {"radius": "1 um"}},
        lambda said: {"hybrid": {"tolerance": float(said[3])}}, {"loading": {"radius": "20 nm"}}, fem(), near=None),
    "hybrid: no such tolerance": kind(UNSURE + "use a smaller contact radius or use method fem",
        {**HYBRID, "specimen": ROD, "loading": {"radius": "1 um"}},
        {"loading": {"radius": "20 nm"}}, fem(), near=None, jkrcli__methods__integral__fredholm__LOOSEST=2e-5),
    "hybrid: no radius found": kind("hybrid: the largest contact radius was not found within {} solves, "
        "the last up to {}: prescribe loading.radius, or use method fem",
        {**HYBRID, "specimen": cylinder("11 um"), "loading": {"radius": None, "load": "2 uN"}},
        {"loading": {"load": None, "radius": "5 um"}}, fem(), near=None,
        jkrcli__hybrid__solver__MOST_SOLVES=1, jkrcli__hybrid__solver__REACH_ROOM=0.8),
    "hybrid: beyond a sphere": kind("{}" + BEYOND, {**HYBRID, "indenter": SPHERE},
        {"loading": {"radius": "5 um"}}, {"indenter": {"radius": "1 mm"}}),
    # ------------------------------------------------------------ layered
    "layered: cylinder": kind("method layered: the specimen has a finite radius of {} m, this method knows only "
        "laterally unbounded ones; use the method hybrid, or leave the radius out",
        {**LAYERED, "specimen": cylinder("60 um")}, HYBRID, {"specimen": {"radius": None, "side": None}}),
    "layered: many points": kind(MUCH + ", or fewer points",
        {**LAYERED, "loading": {"radius": "100 um", "points": 2000}}, {"loading": {"points": 30}},
        jkrcli__methods__layered__contact__LAYERED_MOST_FLOPS=2e8),
    "layered: a contact too large for any": kind(MUCH,
        {**LAYERED, "loading": {"radius": "100 um", "points": 1}}, {"loading": {"radius": "10 um"}},
        jkrcli__methods__layered__contact__LAYERED_MOST_NODES=35),
    "layered: accuracy": kind("layered: the estimated relative error is {} with {} nodes, above the tolerance {}; set "
        "layered.tolerance to {}, or use a smaller contact radius",
        {**LAYERED, "specimen": THIN, "loading": {"radius": "100 um"}},
        lambda said: {"layered": {"tolerance": float(said[3])}}, {"loading": {"radius": "10 um"}}),
    "layered: no such tolerance": kind("layered: the estimated relative error is {} with {} nodes, above the tolerance "
        "{}; use a smaller contact radius",
        {**LAYERED, "specimen": RUBBER, "loading": {"radius": "50 um", "points": 1}},
        {"loading": {"radius": "2 um"}}, jkrcli__methods__integral__fredholm__QUADRATURE_FREQUENCY=0.1),
    "layered: kernel not resolved": kind("layered: {} nodes do not resolve the kernel, the error is not known; use "
        "more points or a smaller contact radius",
        {**LAYERED, "specimen": RUBBER, "loading": {"radius": "200 um", "points": 1}},
        {"loading": {"points": 100}}, {"loading": {"radius": "2 um"}}, near=None,
        jkrcli__methods__integral__fredholm__QUADRATURE_FREQUENCY=0.1),
    "layered: a plate on its rim": kind(FALLS, {**LAYERED, **STIFF}, {"loading": {"radius": 0.99}}),
    "layered: beyond the profile": kind(BEYOND, {**LAYERED, "indenter": TABLE},
        {"loading": {"radius": "5 um"}}, {"indenter": LARGER}),
    "layered: depth beyond the profile": kind(REACH,
        {**LAYERED, "indenter": TABLE, "loading": {"radius": None, "depth": "3 um"}},
        {"loading": {"depth": "0.1 um"}}, {"indenter": LARGER}),
    # ------------------------------------------------------------ closed-form
    "closed-form: coating": kind(FORMULAE.replace("{}", "layered"),
        {**CLOSED, "specimen": {"half_space": ELASTIC}}, LAYERED, fem()),
    "closed-form: cylinder": kind(FORMULAE.replace("{}", "hybrid"),
        {**CLOSED, "specimen": cylinder("60 um")}, HYBRID, fem()),
    "closed-form: table": kind(
        "method closed-form: there is no closed form for a tabulated profile: use method layered",
        {**CLOSED, "specimen": HALF_SPACE, "indenter": {**TABLE, **LARGER}}, LAYERED),
    "closed-form: elastic sphere": kind(
        "method closed-form: the thin-layer formulae are for a rigid sphere or paraboloid: use method layered",
        {**CLOSED, "indenter": ELASTIC}, LAYERED),
    "closed-form: thick layer": kind("method closed-form: the thin-layer formula errs by {} between a/h = {} and {}, "
        "more than 5%: use method layered", CLOSED, LAYERED),
    "closed-form: not checked": kind("method closed-form: the thin-layer formula could not be checked: the exact layer "
        "at a = {} is refused (" + MUCH + "{})",
        {**CLOSED, "specimen": {"layers": [layer("1 um", nu=0.2)]},
         "loading": {"radius": ["80 um", "100 um"], "points": None}},
        {"loading": {"radius": ["50 um", "60 um"]}}, near=0.05,
        jkrcli__methods__layered__contact__LAYERED_MOST_NODES=350),
}
# fmt: on
