"""Camera files: .npz archives with a field `kind`, read with every field checked."""

import zipfile
import zlib

import numpy as np

from raxel.errors import InputError
from raxel.files import replacing


def write_camera(path, kind, fields):
    """Write a camera's fields to `path`, compressed, whole or not at all."""
    with replacing(path) as temporary, temporary.open("wb") as stream:
        np.savez_compressed(stream, kind=np.array(kind), **fields)


class CameraFile:
    """An open camera file: every fault becomes an InputError with file and field.

    kinds: dict name -> class of the cameras that it may hold, in it or nested.
    """

    def __init__(self, path, kinds):
        self.path, self.kinds = path, kinds
        try:
            self._archive = np.load(path, allow_pickle=False)
        except FileNotFoundError as fault:
            raise InputError(f"{path}: no such camera file; check the name") from fault
        except (OSError, ValueError, EOFError, zipfile.BadZipFile) as fault:
            raise InputError(f"{path}: not a camera file, or cut off") from fault
        if not isinstance(self._archive, np.lib.npyio.NpzFile):
            raise InputError(f"{path}: one array found; a camera (.npz) is needed")
        self.kind = self.text("kind")

    def __enter__(self):
        return self

    def __exit__(self, *fault):
        self._archive.close()

    def array(self, name):
        """The array under `name`."""
        if name not in self._archive.files:
            raise InputError(f"{self.path}: field '{name}': missing; save it anew")
        try:
            return self._archive[name]
        except (OSError, ValueError, EOFError, zipfile.BadZipFile, zlib.error) as fault:
            raise InputError(
                f"{self.path}: field '{name}': cannot be read; the file is damaged"
            ) from fault

    def number(self, name):
        """The single number under `name`."""
        value = self.array(name)
        if value.shape != () or value.dtype.kind not in "iuf":
            raise InputError(
                f"{self.path}: field '{name}': found {value.dtype} {value.shape}; a "
                "single number is needed"
            )
        return value.item()

    def numbers(self, name):
        """The array of real numbers, or of truth values, under `name`."""
        value = self.array(name)
        if value.dtype.kind not in "biuf":
            raise InputError(
                f"{self.path}: field '{name}': found {value.dtype}; numbers are needed"
            )
        return value

    def text(self, name):
        """The text under `name`."""
        value = self.array(name)
        if value.shape != () or value.dtype.kind != "U":
            raise InputError(
                f"{self.path}: field '{name}': found {value.dtype} {value.shape}; a "
                "text is needed"
            )
        return value.item()

    def has(self, name):
        """Whether there is a field `name`."""
        return name in self._archive.files

    def value(self, name):
        """The text, number or array of numbers under `name`."""
        value = self.array(name)
        if value.shape == () and value.dtype.kind == "U":
            return value.item()
        return self.number(name) if value.shape == () else self.numbers(name)

    def camera(self):
        """The camera, of the class that the field `kind` names."""
        if self.kind not in self.kinds:
            raise InputError(
                f"{self.path}: field 'kind': found {self.kind!r}; known are "
                + ", ".join(self.kinds)
            )
        try:
            return self.kinds[self.kind]._from_file(self)
        except InputError as fault:
            text = str(fault)
            if text.startswith(f"{self.path}:"):
                raise
            raise InputError(f"{self.path}: {text}") from fault

    def nested(self, name):
        """The camera in the fields whose names begin with `name` and a dot."""
        return _FilePart(name, self).camera()


class _FilePart(CameraFile):
    def __init__(self, name, file):
        self.path, self.kinds = f"{file.path}: field '{name}'", file.kinds
        self._name, self._file = name, file
        self.kind = self.text("kind")

    def array(self, name):
        return self._file.array(f"{self._name}.{name}")

    def has(self, name):
        return self._file.has(f"{self._name}.{name}")
