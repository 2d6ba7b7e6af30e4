"""Read a camera of any kind from its file."""

from raxel.cameras.registry import CAMERAS
from raxel.cameras.storage import CameraFile


def load_camera(path):
    """The camera in an .npz file, of the class its field `kind` names.

    Raises InputError with file and field for a file that is missing, cut off, of an
    unknown kind, or holds values that no such camera can have.
    """
    with CameraFile(path, CAMERAS) as file:
        return file.camera()
