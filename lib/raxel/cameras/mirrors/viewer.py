"""The camera that looks into mirrors: which ones can."""

import numpy as np

from raxel.cameras.core.base import Camera
from raxel.cameras.linear.orthographic import OrthographicCamera
from raxel.errors import InputError


def checked_viewer(viewer):
    """The viewer, if a mirror camera can have it.

    Raises InputError for anything but an OrthographicCamera or a central camera with
    its centre at the origin of its frame.
    """
    if not isinstance(viewer, Camera):
        raise InputError(
            f"field 'viewer': found {type(viewer).__name__}; give a camera"
        )
    if isinstance(viewer, OrthographicCamera):
        return viewer
    centre = getattr(viewer, "origins", None)
    if centre is None:
        centre = getattr(viewer, "centre", None)
    if not viewer.central or (centre is not None and np.any(centre)):
        raise InputError(
            f"field 'viewer': a {viewer.kind} camera whose rays do not all start at "
            "the origin of its frame; a central viewer or an orthographic one is needed"
        )
    return viewer
