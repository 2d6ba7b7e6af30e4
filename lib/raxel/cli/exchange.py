"""Cameras in the files of other programs: `raxel export` and `raxel import`."""

from types import SimpleNamespace

from raxel.cameras.registry import load_camera
from raxel.cli.outputs import check_writable, check_written
from raxel.cli.terminal import Say, on_one_line
from raxel.errors import InputError
from raxel.formats.exchange import export_camera, import_camera


def export(options: SimpleNamespace, say: Say) -> None:
    """Write a camera in the format of another program."""
    check_writable(options.out)
    check_written([options.out], [], [options.camera])
    camera = load_camera(options.camera)
    try:
        made = export_camera(
            camera, options.out, options.format, options.allow_residual
        )
    except InputError as fault:
        raise InputError(f"{options.camera}: {fault}", code=fault.code) from fault
    contents = made.lines() if made else [f"{options.format}, exact"]
    print(f"{on_one_line(options.out)}: {'; '.join(contents)}")


def import_(options: SimpleNamespace, say: Say) -> None:
    """Read a camera from the file of another program."""
    check_writable(options.out)
    check_written([options.out], [], [options.file])
    camera = import_camera(options.file, options.format)
    camera.save(options.out)
    print(
        f"{on_one_line(options.out)}: {camera.kind} camera of {camera.width} x "
        f"{camera.height} px, {camera.parameters} parameters"
    )
