"""Read a camera of any kind from its file."""

from raxel.cameras.fisheye import FisheyeCamera
from raxel.cameras.general import GeneralCamera
from raxel.cameras.perspective import PerspectiveCamera
from raxel.cameras.storage import CameraFile
from raxel.errors import InputError

KINDS = {
    camera.kind: camera for camera in (PerspectiveCamera, FisheyeCamera, GeneralCamera)
}


def load_camera(path):
    """The camera in an .npz file, of the class its field `kind` names.

    Raises InputError with file and field for a file that is missing, cut off, of an
    unknown kind, or holds values that no such camera can have.
    """
    with CameraFile(path) as file:
        if file.kind not in KINDS:
            raise InputError(
                f"{path}: field 'kind': found {file.kind!r}; known are "
                + ", ".join(KINDS)
            )
        return file.build(KINDS[file.kind])
