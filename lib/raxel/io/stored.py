"""Arrays in temporary files, for images and points that would fill the memory."""

import tempfile

import numpy as np


class StoredArray:
    """Hold an array in a temporary file; each index returns a copy of a part.

    The file is mapped only while it is read, so its pages do not stay in the memory of
    the process. It is in the folder of `tempfile` (TMPDIR), and is deleted with this
    object.
    """

    def __init__(self, array):
        self.shape, self.dtype = array.shape, array.dtype
        self._file = tempfile.TemporaryFile()  # noqa: SIM115
        try:
            self._file.write(np.ascontiguousarray(array).data)
            self._file.flush()
        except OSError as fault:
            place = fault.errno, fault.strerror, tempfile.gettempdir()
            raise OSError(*place) from fault

    def __getitem__(self, index):
        mapped = np.memmap(self._file, self.dtype, "r", shape=self.shape)
        return np.array(mapped[index])
