# SPDX-License-Identifier: GPL-2.0-or-later
"""What a program asks of modules that are imported later, so that it need not wait for them."""

isSmoke = False  # --smoke: a run to see whether it works, whose numbers mean nothing
drawsToFiles = False  # pictures go to files only, in the style of this project: `plot.drawToFiles`
