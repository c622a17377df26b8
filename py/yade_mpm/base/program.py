# SPDX-License-Identifier: GPL-2.0-or-later
"""What a program asks of modules that are imported later, so that it need not wait for them."""

drawsToFiles = False  # pictures go to files only, in the style of this project: `plot.drawToFiles`
