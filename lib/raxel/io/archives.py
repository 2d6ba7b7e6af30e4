"""Arrays out of .npz files: every size is known and judged before memory is taken."""

import math
import zipfile

import numpy as np

from raxel.errors import InputError
from raxel.io.documents import one_line
from raxel.io.files import check_file, physical_memory

# Bytes of the widest real number, truth value and text; there is nothing else.
WIDEST = {"b": 1, "i": 8, "u": 8, "f": 8, "U": 400}
# An array is copied by what it is handed to, and half of the memory is left.
SHARE_OF_MEMORY = 1 / 4


class Archive(zipfile.ZipFile):
    """An open .npz file of plain arrays, each stored as `name`.npy.

    what: its name in messages. Raises InputError, one line with file and field: for a
    file that is no such archive, and from its methods for arrays that are missing,
    damaged, of another type than numbers, truth values or text, or larger than they may
    be.
    """

    def __init__(self, path, what):
        check_file(path, what=what)
        try:
            super().__init__(path)
        except Exception as fault:  # A damaged file raises what its damage hits.
            raise InputError(
                f"{path}: not a {what}, or cut off; give an .npz file"
            ) from fault

    def has(self, name):
        """Return whether there is an array `name`."""
        return f"{name}.npy" in self.NameToInfo

    def shape(self, name):
        """Return the shape that the array `name` states; nothing more is read."""
        return self._header(name)[0]

    def array(self, name, most):
        """Return the array `name`, of at most `most` numbers, in native byte order."""
        shape, size = self._header(name)
        if math.prod(shape) > most:
            raise self._fault(
                name, f"{math.prod(shape)} values found, {most} are the most it can be"
            )
        if size > SHARE_OF_MEMORY * physical_memory():
            raise self._fault(
                name,
                f"needs {size / 1e9:.3g} GB, more than a quarter of this machine's "
                f"{physical_memory() / 1e9:.3g} GB",
                "give fewer pixels",
            )
        try:
            with self.open(f"{name}.npy") as stream:
                array = np.lib.format.read_array(stream, allow_pickle=False)
                stream.read(1)  # at its end the check sum is compared
        except Exception as fault:
            raise self._damaged(name) from fault
        return np.asarray(array, array.dtype.newbyteorder("="), order="C")

    def _header(self, name):
        """(shape, bytes) that an array states and the archive confirms."""
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
        if dtype.itemsize > WIDEST.get(dtype.kind, 0):
            raise self._fault(
                name,
                f"found {one_line(dtype)}",
                "numbers of at most 64 bit, or a short text, are needed",
            )
        if not whole:
            raise self._damaged(name)
        return shape, size

    def _damaged(self, name):
        return self._fault(name, "cannot be read; the file is damaged")

    def _fault(self, name, found, advice="save it anew"):
        return InputError(f"{self.filename}: field '{name}': {found}; {advice}")
