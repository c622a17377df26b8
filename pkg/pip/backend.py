# SPDX-License-Identifier: GPL-2.0-or-later
"""What pip builds the package with (pyproject.toml): scikit-build-core without its hook for the metadata.

Without that hook pip builds the wheel first and takes the metadata from it. So a library that is missing ends
pip within seconds, and not after it has downloaded everything that the package depends on.
"""

from scikit_build_core.build import (
    build_editable,
    build_sdist,
    build_wheel,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    get_requires_for_build_wheel,
)

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
]
