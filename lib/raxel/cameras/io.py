"""Read a camera of any kind from its file."""

from raxel.cameras.core.storage import CameraFile
from raxel.cameras.registry import CAMERAS


def load_camera(path):
    """The camera in an .npz file, of the class its field `kind` names.

    Raises InputError with file and field for a file that is missing, cut off, of an
    unknown kind, or holds values that no such camera can have.
    """
    with CameraFile(path, CAMERAS) as file:
        return file.camera()
