# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene inside YADE, on one clock with the discrete elements.

    import yade_mpm as mpm
    soil = mpm.inYade(scene)   # adds engines before the NewtonIntegrator, chooses O.dt
    O.run(1000, True)

inYade, attach             puts a scene into O.engines; returns the Coupling
Bodies, Plane              bodies of YADE that touch the scene, from scene.contact; planes for scenes in 2D
Display                    shows the soil in YADE's view
setCommand                 what the command of a PyRunner of YADE calls
checkpointOf, act          the scene's checkpoint beside YADE's file; what an engine of ours does
"""

from .attach import attach, inYade
from .bodies import Bodies
from .commands import setCommand
from .coupling import Coupling
from .display import Display
from .loop import act
from .output import checkpointOf
from .plane import Plane

for _name in ("attach", "Bodies", "Display", "Plane", "act", "checkpointOf", "setCommand"):
    setattr(inYade, _name, globals()[_name])  # mpm.inYade was the name of this room
