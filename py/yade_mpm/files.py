# SPDX-License-Identifier: GPL-2.0-or-later
"""What checkpoints, recorders and histories ask of the files they write."""
import os


def checkWritable(file, who="checkpoint"):
    """Raises OSError unless a file of that name can be made or replaced; `who` writes it."""
    file = os.fspath(file)
    folder = os.path.dirname(os.path.abspath(file))
    if not os.path.isdir(folder):
        raise FileNotFoundError(f"{who} '{file}': there is no folder '{folder}'; make it, or give another file")
    if os.path.isdir(file):
        raise IsADirectoryError(f"{who} '{file}' is a folder; give the name of a file")
    if os.path.exists(file) and not os.path.isfile(file):
        raise OSError(f"{who} '{file}' is no regular file and would be replaced; give the name of a file")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(f"{who} '{file}': the folder '{folder}' cannot be written to; give another file")
