# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of 2D scenes with matplotlib.

`Scene.plot` and `mpm.read(...)[k].plot` draw one picture; the functions here are for pictures of several
scenes or times. Nothing here changes the settings of matplotlib but `drawToFiles`, which programs call.
"""

from .figures import (
    STYLE,
    Snapshot,
    Snapshots,
    colourBar,
    domains,
    drawDomains,
    drawToFiles,
    panels,
    plt,
    save,
)
from .maps import terrainMaps
from .structure import structure
