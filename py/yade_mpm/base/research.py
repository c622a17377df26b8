# SPDX-License-Identifier: GPL-2.0-or-later
"""Options for comparisons of methods: they work as others do, but help, completion and the reference of a
class leave them out. doc/reference/research.md explains each one."""

OPTIONS = {
    "APDI": ("hourglass",),
    "Contact": ("constraints", "impactLoss", "sharedCells", "slip"),
    "History": ("average",),
    "MohrCoulombDruckerPrager": ("coneFit",),
    "Recorder": ("compress",),
    "RigidContact": (
        "checkBalance",
        "hertzOverlap",
        "normalDamping",
        "normalLaw",
        "shearRatio",
        "soilFriction",
        "stiffnessFactor",
    ),
    "Scene": ("allowUnstable", "scheme"),
    "Scene.add": ("inertiaScale",),
    "UGIMP": ("outline",),
}

LOOPS = {  # what engines and loops of your own need
    "Scene": (
        "cellSizeAt",
        "dtSpeed",
        "faceNodes",
        "isGraded",
        "nodePositions",
        "nodesInside",
        "prepare",
        "stepper",
    )
}
# Completion leaves these out and help has them: numbers behind what `describe`, `run` and `quasiStatic` say.
SELDOM = {
    "Scene": (
        "changes",
        "constraints",
        "criticalTimeStep",
        "dim",
        "dtCritical",
        "dtStable",
        "lines",
        "particleCount",
        "stiffest",
        "step",
        "timing",
        "unbalancedForce",
    )
}
SET_BY_METHODS = {"Contact": ("pairs",), "RigidContact": ("masses", "pairs")}  # as pair() and addBody()


def hiddenOf(kind):
    """Names that help and completion of a class leave out, those of its bases included."""
    return {
        name
        for base in kind.__mro__
        for table in (OPTIONS, LOOPS, SET_BY_METHODS)
        for name in table.get(base.__name__, ())
    }
