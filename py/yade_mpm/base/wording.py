# SPDX-License-Identifier: GPL-2.0-or-later
"""Values in errors, short whatever they are, and the name that was meant."""

import difflib
import reprlib

LONGEST = 2000  # characters of an error
MOST_SHOWN = 80  # characters of a value in it


def shortened(text, most=LONGEST):
    """A text whose middle is left out where it is too long: half of what may stay is left."""
    if len(text) <= most:
        return text
    return f"{text[: most // 4]} ... ({len(text)} characters) ... {text[-most // 4 :]}"


def shown(value):
    """A value as text, short, whatever it is."""
    try:
        return shortened(_Short().repr(value), MOST_SHOWN)
    except Exception:  # of a __repr__ of the user, too; 10**5000 has no text
        return f"<{type(value).__name__}>"


def didYouMean(name, known):
    """End of an error about an unknown name: the nearest one, or nothing."""
    spelled = {other.lower(): other for other in known}
    near = difflib.get_close_matches(name.lower(), spelled, 1)
    return f"; did you mean '{spelled[near[0]]}'?" if near else ""


class _Short(reprlib.Repr):
    def __init__(self):
        super().__init__()
        self.maxstring = self.maxother = MOST_SHOWN
        self.maxlevel = 3
