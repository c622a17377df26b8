# SPDX-License-Identifier: GPL-2.0-or-later
"""Particle types, as registered in pkg/mpm/particle, and bodies: named sets of particles."""
