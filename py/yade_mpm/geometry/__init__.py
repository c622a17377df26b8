# SPDX-License-Identifier: GPL-2.0-or-later
"""Regions of space, lattices and meshes that fill them. Knows neither particles nor scenes."""
