"""Cameras in the files of other programs: `raxel export` and `raxel import`."""

from pathlib import Path
from types import SimpleNamespace

from raxel.cameras.registry import load_camera
from raxel.cli.outputs import check_writable, check_written
from raxel.cli.terminal import Say, on_one_line
from raxel.errors import InputError
from raxel.formats.exchange import export_camera, import_with_residual


def export(options: SimpleNamespace, say: Say) -> None:
    """Write a camera in the format of another program."""
    _check_out(options, options.camera)
    camera = load_camera(options.camera)
    try:
        made = export_camera(
            camera, options.out, options.format, options.allow_residual
        )
    except InputError as fault:
        raise InputError(f"{options.camera}: {fault}", code=fault.code) from fault
    far = " for far points" * (options.format == "maps" and not camera.central)
    contents = made.lines() if made else [f"{options.format}, exact{far}"]
    print("\n  ".join([f"{on_one_line(options.out)}: {contents[0]}", *contents[1:]]))


def import_(options: SimpleNamespace, say: Say) -> None:
    """Read a camera from the file of another program."""
    _check_out(options, options.file)
    camera, (rms, largest) = import_with_residual(options.file, options.format)
    camera.save(options.out)
    residual = f", refitted: residual {rms:.2g} px RMS, {largest:.2g} px at most"
    print(
        f"{on_one_line(options.out)}: {camera.kind} camera of {camera.width} x "
        f"{camera.height} px, {camera.parameters} parameters{residual * (rms > 0)}"
    )


def _check_out(options, source):
    check_writable(options.out)
    check_written([options.out], [], [source])
    if Path(options.out).exists() and not options.force:
        raise InputError(f"{options.out}: exists; give --force to replace it")
