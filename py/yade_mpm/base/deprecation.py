# SPDX-License-Identifier: GPL-2.0-or-later
"""Old spellings, which run through one minor version, with a warning that says what to write."""

from .warn import warnUser

LAST = "0.2"  # the minor version that is the last to know them


def warnDeprecated(old, new):
    """Warns in the user's own line that an old spelling goes, and says what to write."""
    warnUser(f"{old} is deprecated, and version {LAST} is the last to know it; {new}", DeprecationWarning)
