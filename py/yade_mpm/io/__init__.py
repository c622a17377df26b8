# SPDX-License-Identifier: GPL-2.0-or-later
"""Files: recorder, history, checkpoints."""
