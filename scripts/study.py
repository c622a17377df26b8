#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs a scene for many cases: `scripts/run study --help`, doc/howto/studies.md."""

from yade_mpm import app
from yade_mpm.study.program import main

if __name__ == "__main__":
    app.run(main)
