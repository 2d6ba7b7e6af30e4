"""Camera files: .npz archives with a field `kind`, read with every field checked."""

import inspect
import json
import math
from functools import cache

import numpy as np

from raxel.errors import InputError
from raxel.io.archives import Archive
from raxel.io.files import replacing

# Cameras stored by the names of their constructor's arguments.


@cache
def argument_names(camera_class):
    """(all, needed) names of a camera class's constructor arguments."""
    arguments = inspect.signature(camera_class).parameters
    needed = [name for name, given in arguments.items() if given.default is given.empty]
    return list(arguments), needed


class NamedFields:
    """Mixin for a camera that stores each constructor argument under its name.

    Arguments that are None are not stored.
    """

    def _fields(self):
        names, _ = argument_names(type(self))
        values = {
            name: getattr(self, name)
            for name in names
            if name not in ("width", "height")
        }
        return {name: np.array(v) for name, v in values.items() if v is not None}

    @classmethod
    def _from_file(cls, file):
        names, needed = argument_names(cls)
        return cls(**{n: file.value(n) for n in names if n in needed or file.has(n)})


# A camera has about a hundred parameters; only tables of the image have more.
MAX_N_PARAMETERS = 4096
MAX_BOARD_BYTES = 1 << 22
# As in an image set.
MAX_SIDE_PX = 32_000
# A viewer of a mirror, and mirrors in it.
MAX_NESTING_DEPTH = 4


def write_camera(path, kind, fields, board=None, board_cells=None):
    """Write a camera's fields, its board as the bytes of JSON and the area that boards
    cover, if there are such, to `path`, compressed and atomically."""
    if board_cells is not None:
        fields = fields | {"board_cells": board_cells}
    if board is not None:
        text = json.dumps(board).encode()
        fields = fields | {"board": np.frombuffer(text, np.uint8)}
    with replacing(path) as temporary, temporary.open("wb") as stream:
        np.savez_compressed(stream, kind=np.array(kind), **fields)


class CameraFile:
    """Open camera file: every fault becomes an InputError with file and field.

    kinds: dict name -> class of the allowed cameras, also nested ones.
    """

    depth = 0

    def __init__(self, path, kinds):
        self.path, self.kinds = path, kinds
        self._archive = Archive(path, "camera file")
        self.kind = self.text("kind")

    def __enter__(self):
        return self

    def __exit__(self, *fault):
        self._archive.close()

    def array(self, name, most=MAX_N_PARAMETERS):
        """The array under `name`, of at most `most` numbers."""
        return self._archive.array(name, most)

    def shape(self, name):
        """Shape of the array under `name`, from its header."""
        return self._archive.shape(name)

    def has(self, name):
        """Whether there is a field `name`."""
        return self._archive.has(name)

    def number(self, name):
        """The single number under `name`, finite."""
        value = self.array(name)
        if value.shape != () or value.dtype.kind not in "iuf":
            raise self._fault(
                name, f"found {value.dtype} {value.shape}; give a single number"
            )
        if not math.isfinite(value):
            raise self._fault(name, f"found {value}; give a finite number")
        return value.item()

    def numbers(self, name, axes=None, most=MAX_N_PARAMETERS):
        """Real numbers, or truth values, under `name`; axes: their number."""
        value = self.array(name, most)
        if axes not in (None, value.ndim):
            raise self._fault(name, f"found shape {value.shape}; give {axes} axes")
        if value.dtype.kind not in "biuf":
            raise self._fault(name, f"found {value.dtype}; give numbers")
        return value

    def table(self, name, *shapes):
        """The numbers under `name`, which has one of these shapes, however large."""
        shape = self.shape(name)
        if shape not in shapes:
            wanted = " or ".join(map(str, shapes))
            raise self._fault(name, f"found shape {shape}; give {wanted}")
        return self.numbers(name, most=math.prod(shape))

    def text(self, name):
        """The text under `name`."""
        value = self.array(name)
        if value.shape != () or value.dtype.kind != "U":
            raise self._fault(name, f"found {value.dtype} {value.shape}; give a text")
        try:
            return value.item()
        except (ValueError, SystemError) as fault:
            # Invalid code points.
            raise self._fault(name, "invalid text; save the file anew") from fault

    def value(self, name):
        """The text, number or array of numbers under `name`."""
        if self.shape(name) != ():
            return self.numbers(name)
        return (
            self.text(name) if self.array(name).dtype.kind == "U" else self.number(name)
        )

    def size(self):
        """(width, height) in pixels."""
        return tuple(self._pixels(name) for name in ("width", "height"))

    def _pixels(self, name):
        value = self.number(name)
        if value != int(value) or not 1 <= value <= MAX_SIDE_PX:
            raise self._fault(
                name,
                f"found {value}; give a whole number of pixels, 1 to {MAX_SIDE_PX}",
            )
        return int(value)

    def camera(self):
        """The camera, of the class that the field `kind` names."""
        if self.kind not in self.kinds:
            raise self._fault(
                "kind", f"found {self.kind!r}; give one of {', '.join(self.kinds)}"
            )
        self.size()
        try:
            return self.kinds[self.kind]._from_file(self)
        except InputError as fault:
            text = str(fault)
            if text.startswith(f"{self.path}:"):
                raise
            raise InputError(f"{self.path}: {text}") from fault
        except MemoryError as fault:
            raise InputError(
                f"{self.path}: not enough memory for this camera; give one with fewer "
                "pixels"
            ) from fault

    def board(self):
        """The board of the calibration as JSON, None for one as specified."""
        if not self.has("board"):
            return None
        text = self.array("board", MAX_BOARD_BYTES).tobytes()
        try:
            return json.loads(text)
        except (ValueError, RecursionError) as fault:
            raise self._fault(
                "board", f"invalid JSON ({fault}); save it again"
            ) from fault

    def board_cells(self):
        """Cells of the image that a board covered, None for a file without them."""
        if not self.has("board_cells"):
            return None
        cells = self.numbers("board_cells", 2)
        if cells.dtype != bool or not cells.size:
            raise self._fault("board_cells", f"found {cells.dtype}; give booleans")
        return cells

    def nested(self, name):
        """The camera in the fields whose names begin with `name` and a dot."""
        if self.depth == MAX_NESTING_DEPTH:
            raise self._fault(
                name,
                f"more than {MAX_NESTING_DEPTH} nested cameras; reduce the nesting",
            )
        return _FilePart(name, self).camera()

    def _fault(self, name, text):
        return InputError(f"{self.path}: field '{name}': {text}")


class _FilePart(CameraFile):
    def __init__(self, name, file):
        self.path, self.kinds = f"{file.path}: field '{name}'", file.kinds
        self._name, self._file = name, file
        self.depth = file.depth + 1
        self.kind = self.text("kind")

    def array(self, name, most=MAX_N_PARAMETERS):
        return self._file.array(f"{self._name}.{name}", most)

    def shape(self, name):
        return self._file.shape(f"{self._name}.{name}")

    def has(self, name):
        return self._file.has(f"{self._name}.{name}")
