# SPDX-License-Identifier: GPL-2.0-or-later
"""What is looked at before and during a run: likely mistakes, bending, domains; limits of them."""
