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

# Bytes of the widest real number, truth value and text; there is nothing else.
WIDEST = {"b": 1, "i": 8, "u": 8, "f": 8, "U": 400}
# An array is copied by what it is handed to, and half of the memory is left.
SHARE_OF_MEMORY = 1 / 4


class Header(NamedTuple):
    """What an array says of itself."""

    shape: tuple
    dtype: np.dtype

    @property
    def bytes(self):
        """How much memory it needs."""
        return math.prod(self.shape) * self.dtype.itemsize


class Archive:
    """An open .npz file of plain arrays, each stored once as `name`.npy.

    what: its name in messages. Raises InputError, one line with file and field: for a
    file that is no such archive, and from its methods for arrays that are missing,
    given twice, damaged, of another type than numbers, truth values or text, or larger
    than they may be.
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
        self._members = {member.filename: member for member in self._zip.infolist()}
        for member in self._zip.infolist():
            if self._members[member.filename] is not member:
                self._zip.close()
                name = one_line(member.filename.removesuffix(".npy"))
                raise self._fault(name, "given twice")

    def __enter__(self):
        return self

    def __exit__(self, *fault):
        self._zip.close()

    def has(self, name):
        """Return whether there is an array `name`."""
        return f"{name}.npy" in self._members

    def shape(self, name):
        """Return the shape that the array `name` states; nothing more is read."""
        return self._header(name).shape

    def array(self, name, most):
        """Return the array `name`, of at most `most` numbers, in native byte order."""
        header = self._header(name)
        count = math.prod(header.shape)
        if count > most:
            raise self._fault(
                name, f"{count} values found, {most} are the most it can be"
            )
        if header.bytes > SHARE_OF_MEMORY * physical_memory():
            raise self._fault(
                name,
                f"needs {header.bytes / 1e9:.3g} GB, more than a quarter of this "
                f"machine's {physical_memory() / 1e9:.3g} GB",
                "give fewer pixels",
            )
        try:
            with self._zip.open(f"{name}.npy") as stream:
                array = np.lib.format.read_array(stream, allow_pickle=False)
                stream.read(1)  # at its end the check sum is compared
        except Exception as fault:
            raise self._damaged(name) from fault
        return np.ascontiguousarray(array, array.dtype.newbyteorder("=")).reshape(
            header.shape
        )

    def _header(self, name):
        """The Header of an array: of version 1.0, others are for named columns."""
        if not self.has(name):
            raise self._fault(name, "missing")
        try:
            with self._zip.open(f"{name}.npy") as stream, warnings.catch_warnings():
                warnings.simplefilter("ignore")
                whole = np.lib.format.read_magic(stream) == (1, 0)
                shape, _, dtype = np.lib.format.read_array_header_1_0(stream)
                header = Header(shape, dtype)
                end = stream.tell() + header.bytes
        except Exception as fault:
            raise self._damaged(name) from fault
        if dtype.itemsize > WIDEST.get(dtype.kind, 0):
            raise self._fault(
                name,
                f"found {one_line(dtype)}",
                "numbers of at most 64 bit, or a short text, are needed",
            )
        whole = whole and end == self._members[f"{name}.npy"].file_size
        if not whole or min(shape, default=0) < 0:
            raise self._damaged(name)
        return header

    def _damaged(self, name):
        return self._fault(name, "cannot be read; the file is damaged")

    def _fault(self, name, found, advice="save it anew"):
        return InputError(f"{self.path}: field '{name}': {found}; {advice}")
