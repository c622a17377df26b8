# SPDX-License-Identifier: GPL-2.0-or-later
"""What every room needs: classes made from parameter lists, warnings, old spellings."""
