# SPDX-License-Identifier: GPL-2.0-or-later
"""HDF5 files that are appended to all or nothing: whenever the process is killed, a reader finds them
whole."""

import io
import os
import threading
from contextlib import contextmanager
from hashlib import sha256

import h5py
import numpy as np

from .files import replacing, requireRegular, reserve

PAGE = 4096  # bytes
HEAD, TOTAL = 16, 32  # bytes of a journal: its first two numbers, and its SHA-256 sum

committing = threading.RLock()  # held while pages of a file change, so that no thread reads half a frame


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
        with committing:
            pages.commit()


def recover(file):
    """Completes a file whose writer was killed in the middle of a frame; returns whether that was needed.

    Raises ValueError for a journal that is not as it was written, is not of the file, or is no regular file.
    """
    journal = journalOf(file)
    for name in (file, journal):
        requireRegular("recover", name)
    if not (os.path.exists(journal) and os.path.exists(file)):
        return False
    with open(journal, "rb") as f:
        content = f.read()
    numbers, size, pages = _readJournal(content, os.path.getsize(file)) or (None, 0, b"")
    if numbers is None:
        raise ValueError(
            f"recover: '{journal}' is not as it was written, or of another file; remove it, and look with "
            f"mpm.read at what '{file}' still has"
        )
    _overwrite(file, numbers, pages, size)
    removeIfThere(journal)
    return True


def _journal(numbers, size, pages):
    """Content of a journal: how many pages, the size of the file, numbers of the pages, the pages, a sum."""
    content = np.array([len(numbers), size], np.int64).tobytes() + numbers.tobytes() + pages
    return content + sha256(content).digest()


def _readJournal(content, present):
    """Numbers, size and pages of a journal; None where it is damaged, or would write beyond the file.

    present : bytes that the file has: all that is new was written before the journal.
    """
    body, total = content[:-TOTAL], content[-TOTAL:]
    if sha256(body).digest() != total or len(body) < HEAD:
        return None
    count, size = (int(x) for x in np.frombuffer(body, np.int64, 2))
    if not (0 <= count <= len(body) and 0 <= size <= present and len(body) == HEAD + count * (8 + PAGE)):
        return None
    numbers = np.frombuffer(body, np.int64, count, offset=HEAD)
    if not ((np.diff(numbers, prepend=-1) > 0).all() and (numbers * PAGE < present).all()):
        return None
    return numbers, size, body[HEAD + 8 * count :]


class PagedFile(io.RawIOBase):
    """A file whose changes stay in memory until commit(): the changed pages of the old part, and all that is
    new behind them as one piece."""

    def __init__(self, path):
        self.path = os.fspath(path)
        self._base = open(path, "rb")  # noqa: SIM115 - close() closes it
        self._oldSize = self._size = os.fstat(self._base.fileno()).st_size
        self._pages, self._at = {}, 0
        self._oldPages = -(-self._oldSize // PAGE)
        self._new = bytearray()

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
            page = self._new if number is None else self._pages.get(number)
            if page is None:
                self._base.seek(number * PAGE + inside.start)
                length = inside.stop - inside.start
                target[outside] = self._base.read(length).ljust(length, b"\0")
            else:
                target[outside] = page[inside].ljust(inside.stop - inside.start, b"\0")
        self._at += count
        return count

    def write(self, data):
        source = memoryview(data).cast("B")
        for number, inside, outside in self._pieces(len(source)):
            page = self._new if number is None else self._page(number)
            page.extend(bytes(max(0, inside.start - len(page))))
            page[inside] = source[outside]
        self._at += len(source)
        self._size = max(self._size, self._at)
        return len(source)

    def _page(self, number):
        if number not in self._pages:
            self._base.seek(number * PAGE)
            self._pages[number] = bytearray(self._base.read(PAGE).ljust(PAGE, b"\0"))
        return self._pages[number]

    def _pieces(self, count):
        """Page number (None: the new part), slice within it, slice within the data, of `count` bytes from
        here on."""
        done = 0
        while done < count:
            number, begin = divmod(self._at + done, PAGE)
            length = min(PAGE - begin, count - done)
            if number >= self._oldPages:
                number, begin, length = None, self._at + done - self._oldPages * PAGE, count - done
            yield number, slice(begin, begin + length), slice(done, done + length)
            done += length

    def commit(self):
        old = np.array(sorted(self._pages), np.int64)
        content = b"".join(self._pages[n] for n in old)
        new = np.arange(self._oldPages, self._oldPages - (-len(self._new) // PAGE))
        journal = journalOf(self.path)
        try:
            with open(self.path, "r+b") as f:
                reserve(f.fileno(), self._oldSize, self._size - self._oldSize)
            _overwrite(self.path, new, self._new)
            with replacing(journal) as part, open(part, "wb") as f:
                f.write(_journal(old, self._size, content))
        except OSError:
            os.truncate(self.path, self._oldSize)
            raise
        _overwrite(self.path, old, content, self._size)
        removeIfThere(journal)

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
