"""Arrays from .npz files; every size is checked before memory is allocated."""

import math
import zipfile

import numpy as np

from raxel.errors import InputError
from raxel.io.documents import one_line
from raxel.io.files import check_file, physical_memory

# Bytes of the widest real number, boolean and text; other types are rejected.
MAX_ITEM_BYTES = {"b": 1, "i": 8, "u": 8, "f": 8, "U": 400}
# Callers copy an array, and half of the memory stays free.
MAX_MEMORY_SHARE = 1 / 4


class Archive(zipfile.ZipFile):
    """Open an .npz file of plain arrays, each stored as `name`.npy.

    what: its name in messages. Raises InputError, one line with file and field, for a
    file that is not such an archive. Its methods raise it for arrays that are missing,
    damaged, too large, or neither numbers, booleans nor text.
    """

    def __init__(self, path, what):
        check_file(path, what=what)
        try:
            super().__init__(path)
        except Exception as fault:  # a damaged file can raise any exception
            raise InputError(
                f"{path}: not a {what}, or truncated; give an .npz file"
            ) from fault

    def has(self, name):
        """Return whether there is an array `name`."""
        return f"{name}.npy" in self.NameToInfo

    def shape(self, name):
        """Return the shape of the array `name` from its header."""
        return self._header(name)[0]

    def array(self, name, max_values):
        """Return the array `name`, at most `max_values` values, in native order."""
        shape, size = self._header(name)
        if math.prod(shape) > max_values:
            raise self._fault(
                name, f"{math.prod(shape)} values exceed the limit of {max_values}"
            )
        if size > MAX_MEMORY_SHARE * physical_memory():
            raise self._fault(
                name,
                f"needs {size / 1e9:.3g} GB, more than a quarter of the memory of "
                f"{physical_memory() / 1e9:.3g} GB",
                "use fewer pixels",
            )
        try:
            with self.open(f"{name}.npy") as stream:
                array = np.lib.format.read_array(stream, allow_pickle=False)
                stream.read(1)  # the checksum is verified at the end
        except Exception as fault:
            raise self._damaged(name) from fault
        return np.asarray(array, array.dtype.newbyteorder("="), order="C")

    def _header(self, name):
        """Return (shape, bytes) of an array, consistent in header and archive."""
        if not self.has(name):
            raise self._fault(name, "missing")
        try:
            with self.open(f"{name}.npy") as stream:
                np.lib.format.read_magic(stream)
                shape, _, dtype = np.lib.format.read_array_header_1_0(stream)
                size = math.prod(shape) * dtype.itemsize
                whole = stream.tell() + size == self.getinfo(f"{name}.npy").file_size
        except Exception as fault:
            raise self._damaged(name) from fault
        if dtype.itemsize > MAX_ITEM_BYTES.get(dtype.kind, 0):
            raise self._fault(
                name,
                f"type is {one_line(dtype)}",
                "give numbers of at most 64 bit, or a short text",
            )
        if not whole:
            raise self._damaged(name)
        return shape, size

    def _damaged(self, name):
        return self._fault(name, "file is damaged")

    def _fault(self, name, problem, advice="save the file again"):
        return InputError(f"{self.filename}: field '{name}': {problem}; {advice}")
