"""Cameras stored by the names of their constructor's arguments."""

import inspect

import numpy as np


def argument_names(camera_class):
    """(all, needed) names of a camera class's constructor arguments."""
    arguments = inspect.signature(camera_class).parameters
    needed = [name for name, given in arguments.items() if given.default is given.empty]
    return list(arguments), needed


class NamedFields:
    """For a camera that keeps each constructor argument under the argument's name."""

    def _fields(self):
        names, _ = argument_names(type(self))
        return {
            name: np.array(getattr(self, name))
            for name in names
            if name not in ("width", "height")
        }

    @classmethod
    def _from_file(cls, file):
        names, _ = argument_names(cls)
        return cls(**{name: file.value(name) for name in names})
