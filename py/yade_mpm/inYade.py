# SPDX-License-Identifier: GPL-2.0-or-later
"""The public name of `yade_mpm.yade.attach`: a scene inside YADE.

from yade_mpm import inYade
soil = inYade.attach(scene)   # adds engines before the NewtonIntegrator, chooses O.dt
O.run(1000, True)
"""

import builtins
import sys

from .yade.attach import *  # noqa: F403 - all that the module has

builtins.inYade = sys.modules[__name__]  # where the commands of the engines find it, wherever it was imported
