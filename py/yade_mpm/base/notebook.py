# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of a notebook: the import of the package makes matplotlib's inline backend ready.

Without that the backend gets ready with the first figure. matplotlib up to 3.8 beside IPython from 8.24 on
fails on that way (it imports `IPython.core.pylabtools.backend2gui`, which is gone), tries again when the cell
has ended, and closes the figure that nobody has seen.
"""

import os
import sys

BACKEND = "matplotlib_inline.backend_inline"
NAMES = ("inline", f"module://{BACKEND}")


def makeInlineReady():
    """Does what `%matplotlib inline` does, in a kernel that asks for this backend and has not loaded any."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    if shell is None or BACKEND in sys.modules or os.environ.get("MPLBACKEND") not in NAMES:
        return
    import matplotlib

    if matplotlib.get_backend() in NAMES:
        shell.run_line_magic("matplotlib", "inline")
