# SPDX-License-Identifier: GPL-2.0-or-later
"""What a Recorder has written, read back: frames by time, their fields, pictures and animations."""
