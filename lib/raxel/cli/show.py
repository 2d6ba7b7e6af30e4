"""`raxel show WHAT [--camera CAMERA] [--corners FILE] [--seed N] [--out FILE]`"""

import os
import sys
import tempfile
import webbrowser
from pathlib import Path

from raxel.cameras.registry import load_camera
from raxel.cli.outputs import check_written
from raxel.errors import InputError
from raxel.features.boards import read_boards
from raxel.io.files import check_can_be_written, replacing
from raxel.io.rendering import need, packages_missing, rendering_missing
from raxel.sets import is_mirror_set, load_set

FORMS = (".html", ".png")


def show(options, say):
    """Draw a rig, a camera or a set: to a file, or in the browser."""
    out = options.out and Path(options.out)
    if out:
        if out.suffix.lower() not in FORMS:
            raise InputError(
                f"{out}: found ending {out.suffix or 'none'!r}; give "
                f"{' or '.join(FORMS)}"
            )
        check_can_be_written(out)
        check_written([out], [], [options.what, options.camera, options.corners])
    flat = out and out.suffix.lower() == ".png"
    need(rendering_missing() if flat else packages_missing())
    scene, title = _scene(options, out, say)
    if out is None:
        folder = Path(tempfile.mkdtemp(prefix="raxel-show-"))
        out = folder / f"{title.split(':')[0]}.html"
    _write(out, scene, title)
    print(f"{scene.note}\n{out}")
    if options.out is None and _has_display():
        webbrowser.open(out.as_uri())


def _scene(options, out, say):
    """(scene, title); `out` is no file of a set that is read for it, or None."""
    what = Path(options.what)
    if what.is_dir():
        from raxel.show.cameras import set_scene

        if is_mirror_set(what):
            raise InputError(
                f"{what}: a mirror set, whose mirror is not known yet; run raxel "
                "calibrate, then raxel show on the camera that it writes"
            )
        image_set = load_set(what)
        check_written([out], [image_set])
        camera = options.camera and load_camera(options.camera)
        boards = options.corners and read_boards(options.corners, image_set)
        scene = set_scene(image_set, camera, say, boards)
        return scene, f"{image_set.name}: targets before the camera"
    for option in ("camera", "corners"):
        if getattr(options, option):
            raise InputError(
                f"--{option}: found with {what}, which is no folder of an image set; "
                "leave it out"
            )
    if what.suffix == ".npz":
        from raxel.show.cameras import camera_scene

        return camera_scene(load_camera(what), what.stem), f"{what.stem}: a camera"
    if what.suffix in (".yaml", ".yml"):
        from raxel.lab import load_rig
        from raxel.show.cameras import rig_scene

        rig = load_rig(what)
        return rig_scene(rig, options.seed), f"{rig.name}: a rig"
    found = f"found ending {what.suffix!r}" if what.exists() else "no such file"
    raise InputError(
        f"{what}: {found}; give a rig (.yaml), a camera (.npz) or the folder of a set"
    )


def _write(out, scene, title):
    from raxel.show import html, png

    if out.suffix.lower() == ".png":
        content = png(scene)
    else:
        content = html(scene, title).encode()
    with replacing(out) as temporary:
        temporary.write_bytes(content)


def _has_display():
    if sys.platform in ("darwin", "win32"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
