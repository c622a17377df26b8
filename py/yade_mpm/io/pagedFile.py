# SPDX-License-Identifier: GPL-2.0-or-later
"""HDF5 files that are appended to all or nothing: whenever the process is killed, a reader finds them
whole."""

import io
import os
from contextlib import contextmanager

import h5py
import numpy as np

from .files import replacing, reserve

PAGE = 4096


@contextmanager
def appendingTo(file):
    """An HDF5 file open for changes that reach the disk at the end, all or nothing.

    What lies behind the old end is written first, where no reader looks. The changed pages of the old part go
    to `file`.journal, then into the file, and the journal is removed: whenever the process is killed, the
    file is as it was, or `recover` completes it. Nothing is written if the body of the `with` raises.
    """
    recover(file)
    with PagedFile(file) as pages:
        with h5py.File(pages, "r+") as h5:
            yield h5
        pages.commit()


def recover(file):
    """Completes a file whose writer was killed in the middle of a frame; returns whether that was needed."""
    journal = journalOf(file)
    if not (os.path.exists(journal) and os.path.exists(file)):
        return False
    with open(journal, "rb") as f:
        content = f.read()
    count, size = np.frombuffer(content, np.int64, 2)
    numbers = np.frombuffer(content, np.int64, count, offset=16)
    _overwrite(file, numbers, content[16 + 8 * count :], int(size))
    removeIfThere(journal)
    return True


class PagedFile(io.RawIOBase):
    """A file whose changes stay in memory until commit()."""

    def __init__(self, path):
        self.path = os.fspath(path)
        self._base = open(path, "rb")  # noqa: SIM115 - close() closes it
        self._oldSize = self._size = os.fstat(self._base.fileno()).st_size
        self._pages, self._at = {}, 0

    def readable(self):
        return True

    writable = seekable = readable

    def tell(self):
        return self._at

    def seek(self, offset, whence=io.SEEK_SET):
        self._at = offset + {io.SEEK_SET: 0, io.SEEK_CUR: self._at, io.SEEK_END: self._size}[whence]
        return self._at

    def truncate(self, size=None):
        self._size = self._at if size is None else size
        return self._size

    def readinto(self, buffer):
        target = memoryview(buffer).cast("B")
        count = max(0, min(len(target), self._size - self._at))
        for number, inside, outside in self._pieces(count):
            page = self._pages.get(number)
            if page is None:
                self._base.seek(number * PAGE + inside.start)
                length = inside.stop - inside.start
                target[outside] = self._base.read(length).ljust(length, b"\0")
            else:
                target[outside] = page[inside]
        self._at += count
        return count

    def write(self, data):
        source = memoryview(data).cast("B")
        for number, inside, outside in self._pieces(len(source)):
            self._page(number)[inside] = source[outside]
        self._at += len(source)
        self._size = max(self._size, self._at)
        return len(source)

    def _page(self, number):
        if number not in self._pages:
            self._base.seek(number * PAGE)
            self._pages[number] = bytearray(self._base.read(PAGE).ljust(PAGE, b"\0"))
        return self._pages[number]

    def _pieces(self, count):
        """Page number, slice within the page, slice within the data, of `count` bytes from here on."""
        done = 0
        while done < count:
            number, begin = divmod(self._at + done, PAGE)
            length = min(PAGE - begin, count - done)
            yield number, slice(begin, begin + length), slice(done, done + length)
            done += length

    def commit(self):
        numbers = np.array(sorted(self._pages), np.int64)
        isOld = numbers * PAGE < self._oldSize
        old, new = numbers[isOld], numbers[~isOld]
        journal = journalOf(self.path)
        try:
            with open(self.path, "r+b") as f:
                reserve(f.fileno(), self._oldSize, self._size - self._oldSize)
            _overwrite(self.path, new, self._content(new))
            with replacing(journal) as part, open(part, "wb") as f:
                head = np.array([len(old), self._size], np.int64).tobytes()
                f.write(head + old.tobytes() + self._content(old))
        except OSError:
            os.truncate(self.path, self._oldSize)
            raise
        _overwrite(self.path, old, self._content(old), self._size)
        removeIfThere(journal)

    def _content(self, numbers):
        return b"".join(self._pages[n] for n in numbers)

    def close(self):
        if not self.closed:
            self._base.close()
        super().close()


def _overwrite(file, numbers, content, size=None):
    """Writes pages in place, neighbours at once, and sets the size of the file."""
    if len(numbers) == 0 and size is None:
        return
    runs = np.flatnonzero(np.diff(numbers, prepend=-2) != 1)
    with open(file, "r+b", buffering=0) as f:
        for begin, end in zip(runs, [*runs[1:], len(numbers)]):
            _writeAll(f, int(numbers[begin]) * PAGE, memoryview(content)[begin * PAGE : end * PAGE])
        if size is not None:
            f.truncate(size)


def _writeAll(f, at, data):
    f.seek(at)
    while len(data):
        data = data[f.write(data) :]


def journalOf(file):
    return os.fspath(file) + ".journal"


def removeIfThere(file):
    if os.path.exists(file):
        os.remove(file)
