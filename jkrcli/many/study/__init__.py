"""Studies over many bodies: maps, each a row of ``MAPS`` with its module ``<name>_map``, and convergence of meshes."""

MAPS = {
    "pull-off": "The pull-off force on a layer, in pi w R, over w R^2/(E* h^3).",
    "sticking": "What sticking changes on a layer: S and load over those of sliding, over a/h.",
    "transition": "The pull-off force on a layer between JKR and DMT, over the range of adhesion.",
    "adhesion": "Which model of adhesion holds on a layer, over its range and the load.",
    "rate": "Pull-off force and energy lost over speed, stiffness and body.",
}
