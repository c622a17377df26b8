# SPDX-License-Identifier: GPL-2.0-or-later
"""The scene, its run, and scenes from checkpoints."""
