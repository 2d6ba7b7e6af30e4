"""Cameras stored by the names of their constructor's arguments."""

import inspect
from functools import cache

import numpy as np


@cache
def argument_names(camera_class):
    """(all, needed) names of a camera class's constructor arguments."""
    arguments = inspect.signature(camera_class).parameters
    needed = [name for name, given in arguments.items() if given.default is given.empty]
    return list(arguments), needed


class NamedFields:
    """For a camera that keeps each constructor argument under the argument's name.

    An argument that is None is left out of the file.
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
