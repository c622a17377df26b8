# SPDX-License-Identifier: GPL-2.0-or-later
"""Materials, as registered in pkg/mpm/material, and a single point of one."""
