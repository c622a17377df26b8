# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene inside YADE, on one clock with the discrete elements."""
