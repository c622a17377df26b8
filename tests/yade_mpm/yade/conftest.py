# SPDX-License-Identifier: GPL-2.0-or-later
from scenesInYade import same, steps  # noqa: F401 - fixtures
