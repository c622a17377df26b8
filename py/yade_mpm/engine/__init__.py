# SPDX-License-Identifier: GPL-2.0-or-later
"""Engines of the step, as registered in pkg/mpm/step and contact, prescribed motions, and callbacks."""

from .engines import Callback, Engine, Prescribed, classes
from .prescribed import MotionTable, Steering
