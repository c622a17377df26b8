# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers of a law that are "per particle" and have no values yet."""

from contextlib import contextmanager

import numpy as np


@contextmanager
def namingUnset(body):
    """Sets the stress of a body, from which the state of its law may follow.

    Raises ValueError that names a number "per particle" without values where the state lacks it.
    """
    unset = [name for name in body.material._spatial if np.isnan(getattr(body, name)).any()]
    states = {variable[0] for variable in body.material._core.stateVariables()} - set(unset)
    refused = None
    try:
        yield
    except ValueError as error:
        refused = error
    lacks = unset and not all(np.isfinite(getattr(body, name)).all() for name in states)
    if unset and (refused or lacks):
        raise ValueError(
            f"body '{body.name}': {unset[0]} is \"per particle\" and has no values; set body.{unset[0]} "
            f"before its stress, as the state that belongs to that may follow from it"
        ) from refused
    if refused:
        raise refused
