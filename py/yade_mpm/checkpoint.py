# SPDX-License-Identifier: GPL-2.0-or-later
"""Checkpoints."""
def save(scene, file): raise NotImplementedError
def load(file): raise NotImplementedError
