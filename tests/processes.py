# SPDX-License-Identifier: GPL-2.0-or-later
"""Python in a process of its own; conftest.py gives it the package, and what tests share."""

import os
import subprocess
import sys


def runPython(*words, timeout=100, **variables):
    """The finished process. words : "-c" and a text, or a file, and its arguments. variables : of its
    environment."""
    environment = {**os.environ, **variables}
    command = [sys.executable, *map(str, words)]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=timeout)
