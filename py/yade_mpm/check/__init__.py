# SPDX-License-Identifier: GPL-2.0-or-later
"""What a scene is asked: its energies and other numbers, likely mistakes, whether a run was slow enough."""
