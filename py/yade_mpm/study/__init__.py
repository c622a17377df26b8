# SPDX-License-Identifier: GPL-2.0-or-later
"""What scripts and studies share: command lines, and results that are measured on a scene."""
