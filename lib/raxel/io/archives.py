"""Arrays out of .npz files: every size is known and judged before memory is taken."""

import math
import warnings
import zipfile
from typing import NamedTuple

import numpy as np

from raxel.errors import InputError
from raxel.io.documents import one_line
from raxel.io.files import file_size
from raxel.io.machine import physical_memory

ENCRYPTED = 0x1
# Deflate makes at most 1032 bytes of one.
MOST_FROM_ONE_BYTE = 1032
# Bytes of the widest real number, truth value and text; there is nothing else.
WIDEST = {"b": 1, "i": 8, "u": 8, "f": 8, "U": 400}
CHUNK = 1 << 20
# An array is copied by what it is handed to, and half of the memory is left.
SHARE_OF_MEMORY = 1 / 4


class Header(NamedTuple):
    """What an array says of itself: shape, dtype, whether columns run first."""

    shape: tuple
    dtype: np.dtype
    by_columns: bool

    @property
    def count(self):
        """How many numbers it has."""
        return math.prod(self.shape)

    @property
    def bytes(self):
        """How much memory it needs."""
        return self.count * self.dtype.itemsize


class Archive:
    """An open .npz file of plain arrays, each stored once as `name`.npy.

    what: its name in messages. Raises InputError, one line with file and field: for a
    file that is no such archive, and from its methods for arrays that are missing,
    given twice, encrypted, packed in another way than numpy does, damaged, of another
    type than numbers, truth values or text, or larger than they may be.
    """

    def __init__(self, path, what):
        self.path = path
        file_size(path, what)
        try:
            self._zip = zipfile.ZipFile(path)
        except Exception as fault:  # A damaged file raises what its damage hits.
            raise InputError(
                f"{path}: not a {what}, or cut off; give an .npz file"
            ) from fault
        self._members = {}
        for member in self._zip.infolist():
            if member.filename in self._members:
                name = one_line(member.filename.removesuffix(".npy"))
                self._zip.close()
                raise self._fault(name, "given twice")
            self._members[member.filename] = member

    def __enter__(self):
        return self

    def __exit__(self, *fault):
        self._zip.close()

    def has(self, name):
        """Whether there is an array `name`."""
        return f"{name}.npy" in self._members

    def shape(self, name):
        """The shape that the array `name` says it has; nothing more is read."""
        with self._open(name) as stream:
            return self._header(name, stream).shape

    def packing(self, name):
        """(bytes that the array `name` needs, bytes that it takes in the file)."""
        with self._open(name) as stream:
            need = self._header(name, stream).bytes
        return need, self._members[f"{name}.npy"].compress_size

    def array(self, name, most):
        """The array `name`, of at most `most` numbers, in this machine's byte order."""
        with self._open(name) as stream:
            header = self._header(name, stream)
            if header.count > most:
                raise self._fault(
                    name, f"{header.count} values found, {most} are the most it can be"
                )
            if header.bytes > SHARE_OF_MEMORY * physical_memory():
                raise self._fault(
                    name,
                    f"needs {header.bytes / 1e9:.3g} GB, more than a quarter of this "
                    f"machine's {physical_memory() / 1e9:.3g} GB",
                    "give fewer pixels",
                )
            try:
                return _filled(stream, header)
            except MemoryError as fault:
                raise self._fault(
                    name, f"needs {header.bytes / 1e9:.3g} GB", "free some memory"
                ) from fault
            except Exception as fault:
                raise self._damaged(name) from fault

    def _open(self, name):
        member = self._members.get(f"{name}.npy")
        if member is None:
            raise self._fault(name, "missing")
        if member.flag_bits & ENCRYPTED:
            raise self._fault(name, "encrypted", "save it without a password")
        if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise self._fault(
                name, f"packed by method {member.compress_type}, which numpy never uses"
            )
        if member.file_size > MOST_FROM_ONE_BYTE * (member.compress_size + 1):
            raise self._damaged(name)
        try:
            return self._zip.open(member)
        except Exception as fault:
            raise self._damaged(name) from fault

    def _header(self, name, stream):
        member = self._members[f"{name}.npy"]
        try:
            header = _header(stream)
            whole = stream.tell() + header.bytes == member.file_size
        except Exception as fault:
            raise self._damaged(name) from fault
        if header.dtype.itemsize > WIDEST.get(header.dtype.kind, 0):
            raise self._fault(
                name,
                f"found {one_line(header.dtype)}",
                "numbers of at most 64 bit, or a short text, are needed",
            )
        if not whole or min(header.shape, default=0) < 0:
            raise self._damaged(name)
        return header

    def _damaged(self, name):
        return self._fault(name, "cannot be read; the file is damaged")

    def _fault(self, name, found, advice="save it anew"):
        return InputError(f"{self.path}: field '{name}': {found}; {advice}")


def _header(stream):
    """The Header of an .npy stream, which then stands at the first number.

    Only version 1.0, whose header has an end at 64 kB; others are for named columns.
    """
    if np.lib.format.read_magic(stream) != (1, 0):
        raise ValueError("not version 1.0")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        shape, by_columns, dtype = np.lib.format.read_array_header_1_0(stream)
    return Header(shape, dtype, by_columns)


def _filled(stream, header):
    """The array behind a Header. The stream's end checks its sum."""
    content = np.empty(header.bytes, np.uint8)
    view = memoryview(content)
    for start in range(0, len(view), CHUNK):
        part = view[start : start + CHUNK]
        if stream.readinto(part) != len(part):
            raise EOFError("cut off")
    if stream.read(1):
        raise ValueError("more than the header says")
    if header.dtype.kind == "b":
        content = content != 0
    order = "F" if header.by_columns else "C"
    array = content.view(header.dtype).reshape(header.shape, order=order)
    return array.astype(header.dtype.newbyteorder("="), order="C", copy=False)
