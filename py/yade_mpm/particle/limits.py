# SPDX-License-Identifier: GPL-2.0-or-later
"""Limits of particles."""

# Smallest corner of an APDI domain over its area from which on down the run warns; at 0.05 it stops, or
# converts the domain.
POOR_QUALITY = 0.2
