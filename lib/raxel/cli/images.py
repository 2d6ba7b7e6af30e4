"""New images: `raxel undistort`, `raxel render` and `raxel show`."""

import os
import sys
import tempfile
import webbrowser
from collections.abc import Callable, Sequence
from pathlib import Path, PurePath
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from raxel.cameras.core.base import Camera, centrality, pixel_grid
from raxel.cameras.registry import load_camera
from raxel.cli.findings import of_unused, reported
from raxel.cli.outputs import check_written
from raxel.cli.sets import CAMERA, CORNERS, opened_set
from raxel.cli.terminal import Say, on_one_line
from raxel.errors import InputError
from raxel.features.boards import read_boards
from raxel.features.grids import has_points, read_grid
from raxel.io.files import (
    check_can_be_written,
    png_names,
    read_json,
    replacing,
    write_json,
)
from raxel.io.rendering import need, packages_missing, rendering_missing
from raxel.multiview.views import (
    FAR_RANGE_MM,
    CylindricalView,
    EquirectangularView,
    PerspectiveView,
    panoramic_view,
    perspective_view,
    plane_scale,
    range_shift,
    remap_to_plane,
    resample,
    share_seen,
    source_pixels,
)
from raxel.sets import ImageSet, is_mirror_set, read_colour
from raxel.sets.folder import SIDECAR
from raxel.sets.image_files import write_png

MAX_PERSPECTIVE_FOV_DEG = 170
MIN_SHARE = 0.5  # of the pixels; below it, most of the image is black
ENDINGS = (".html", ".png")
MAPS = "maps.npz"
SIDECAR_MARK = "raxel_undistorted"  # its first key
PANORAMAS: dict[str, Any] = {
    "cylinder": CylindricalView,
    "equirectangular": EquirectangularView,
}
View = PerspectiveView | CylindricalView | EquirectangularView
VIEW_OPTIONS = "projection", "fov", "size", "down", "range", "maps"
# Distance, in RMS distances of the rays from one point, at which the shift of points is
# proportional to the inverse of the distance.
FAR_FROM_RAYS = 1000


class Undistortion(NamedTuple):
    """Function of an image; fraction of the pixels that show anything; what shows
    these; possible causes of a small fraction; content of SIDECAR; source pixels
    (h, w, 2), None for a grid."""

    of_image: Callable[[np.ndarray], np.ndarray]
    share: float
    source: str
    causes: str
    geometry: dict[str, Any]
    maps: np.ndarray | None = None


def undistort(options: SimpleNamespace, say: Say) -> None:
    """Write the images of a set as a pinhole at the camera's centre would see them, as
    a panorama, or mapped onto the plane of an active grid."""
    out = Path(options.out)
    image_set = opened_set(options)
    files = list(dict.fromkeys(name for v in image_set.views for name in v.files))
    targets = png_names(files)
    _check_targets(out, targets, image_set, options.camera)
    by = _by_grid if has_points(options.camera) else _by_camera
    new = by(options, image_set)
    disk = out if out.is_dir() else out.parent
    with tempfile.TemporaryDirectory(dir=disk, prefix=".undistort-") as room:
        folder = Path(room) / "images"
        for number, (name, target) in enumerate(zip(files, targets, strict=True), 1):
            write_png(folder / target, new.of_image(read_colour(image_set, name)))
            renamed = (
                f" as {target}" if target != PurePath(name).with_suffix(".png") else ""
            )
            say(f"{number}/{len(files)} {name}{renamed}")
        (out / MAPS).unlink(missing_ok=True)  # of an earlier run
        if options.maps and new.maps is not None:
            u, v = np.moveaxis(new.maps, 2, 0)
            np.savez_compressed(folder / MAPS, u=u, v=v)
            targets.append(PurePath(MAPS))
        written = [target.as_posix() for target in targets]
        about = {SIDECAR_MARK: 1, "files": written} | new.geometry
        write_json(folder / SIDECAR, about)
        for target in [PurePath(SIDECAR), *targets]:
            (out / target).parent.mkdir(parents=True, exist_ok=True)
            os.replace(folder / target, out / target)
    print(
        f"{image_set.name}: {len(files)} images in {on_one_line(out)}; {new.source} "
        f"{100 * new.share:.0f} % of their pixels"
    )
    if new.share < MIN_SHARE:
        print(f"the rest is black: {new.causes}")
    reported(of_unused(image_set))


def _by_camera(options: SimpleNamespace, image_set: ImageSet) -> Undistortion:
    from raxel.cli.evaluate import check_size

    camera = load_camera(options.camera)
    check_size(options.camera, camera, image_set)
    exact = options.range or FAR_RANGE_MM
    try:
        view = _view(camera, options)
    except InputError as fault:
        raise InputError(f"{options.camera}: {fault}") from fault
    sources = source_pixels(camera, view, exact)
    unit = image_set.target.unit
    if not camera.central:
        print(f"{image_set.name}: {_range_text(camera, view, options.range, unit)}")
    geometry = {
        "camera": str(options.camera),
        "projection": options.projection,
        "range": None if camera.central else options.range,
        "unit": unit,
        **{name: np.asarray(value).tolist() for name, value in view._asdict().items()},
    }
    return Undistortion(
        lambda image: resample(image, sources),
        share_seen(sources, camera),
        "the camera sees",
        "the field of view exceeds that of the camera, or the calibration targets "
        "covered little of the image; see --projection and --fov",
        geometry,
        sources,
    )


def _view(camera: Camera, options: SimpleNamespace) -> View:
    fov = options.fov and np.radians(options.fov)
    if options.projection != "perspective":
        kind = PANORAMAS[options.projection]
        return panoramic_view(kind, camera, options.down, fov, options.size)
    if options.down or (options.fov or 0) > MAX_PERSPECTIVE_FOV_DEG:
        raise InputError(
            "--projection: perspective has at most --fov "
            f"{MAX_PERSPECTIVE_FOV_DEG}, and no --down; give cylinder or "
            "equirectangular"
        )
    return perspective_view(camera, fov, options.size)


def _range_text(camera: Camera, view: View, range_mm: float | None, unit: str) -> str:
    """Where a view of rays without a common point is exact, and errors elsewhere."""
    exact = range_mm or FAR_RANGE_MM
    start = "rays do not meet in one point: images are exact " + (
        f"at {range_mm:.4g} {unit}" if range_mm else "far away"
    )
    boards = camera.board_distance
    if boards is not None:
        shift = range_shift(camera, view, exact, boards)
        return f"{start}; at {boards:.4g} {unit} (boards) off by up to {shift:.2g} px"
    rays = camera.rays(
        pixel_grid(camera.width, camera.height)[:: max(camera.width // 7, 1)]
    )
    tried = FAR_FROM_RAYS * centrality(rays)
    shift = range_shift(camera, view, exact, tried)
    near = float(f"{shift / (shift / exact + abs(1 / tried - 1 / exact)):.2g}")
    return f"{start}; nearer than {near:g} {unit} off by more than 1 px"


def _by_grid(options: SimpleNamespace, image_set: ImageSet) -> Undistortion:
    path = options.camera
    for name in VIEW_OPTIONS:
        if getattr(options, name) not in (None, False, "perspective"):
            raise InputError(
                f"--{name}: found with points of a grid, whose plane is the view; "
                "remove it, or give a camera"
            )
    shape = image_set.height, image_set.width
    location, sigma, mask = read_grid(path, (*shape, 2))
    try:
        scale = plane_scale(location, mask)
        _, known = remap_to_plane(
            np.zeros(shape, np.uint8), location, sigma, mask, *scale
        )
    except InputError as fault:
        raise InputError(f"{path}: {fault}") from fault
    return Undistortion(
        lambda image: remap_to_plane(image, location, sigma, mask, *scale)[0],
        float(np.mean(known)),
        "the grid's points cover",
        "the grid covered little of the image; move the monitor closer",
        {"points": str(path), "projection": "plane", "length_per_px": scale[1]},
    )


def _check_targets(
    out: Path, targets: Sequence[PurePath], image_set: ImageSet, camera: str
) -> None:
    """Raise InputError for an image outside `out`, or over a file of another kind."""
    if out.is_dir() and out.resolve() == image_set.folder.resolve():
        raise InputError(f"{out}: is the image set itself; choose another folder")
    check_can_be_written(out / "image.png" if out.is_dir() else out)
    paths = [out / target for target in targets]
    own = out / SIDECAR, out / MAPS
    check_written([*paths, *own], [image_set], [camera])
    earlier: set[Path] = set()
    if own[0].exists() and SIDECAR_MARK in own[0].read_text(errors="replace"):
        earlier = {*own, *(out / name for name in read_json(own[0])["files"])}
    for path in (*own, *paths):
        if not path.parent.resolve().is_relative_to(out.resolve()):
            raise InputError(
                f"{path.parent}: found a link that leads out of {out}; remove it, or "
                "choose another --out"
            )
        folder = next(folder for folder in path.parents if os.path.lexists(folder))
        if not folder.is_dir():
            raise InputError(f"{folder}: not a folder; choose another --out")
        check_can_be_written(folder / "image.png")
        if path.exists() and path not in earlier:
            raise InputError(
                f"{path}: not written by raxel undistort; choose another --out, or "
                "remove the file"
            )


def render(options: SimpleNamespace, say: Say) -> None:
    """Render the image set or the mirror set of a rig file."""
    from raxel.lab import load_rig, render_set
    from raxel.lab.mirror_set_rig import (
        is_mirror_set_rig,
        load_mirror_set_rig,
        render_mirror_set,
    )

    if is_mirror_set_rig(options.rig):
        made = render_mirror_set(
            load_mirror_set_rig(options.rig),
            options.out,
            options.seed,
            options.noise,
            say,
        )
        for field, image_set in made.image_sets.items():
            print(f"{made.name}: {field}: {_contents(image_set)}")
        print(f"{made.name}: {len(made.steps) + 1} stages", end=", ")
    elif options.noise:
        raise InputError(
            f"--noise: found with {options.rig}, which has one noise level; remove it"
        )
    else:
        made = render_set(load_rig(options.rig), options.out, options.seed, say)
        print(f"{made.name}: {_contents(made)}", end=", ")
    print(f"in {on_one_line(made.folder)}")


def _contents(image_set: ImageSet) -> str:
    return (
        f"{len(image_set.views)} views, {sum(len(v.files) for v in image_set.views)} "
        f"images of {image_set.width} x {image_set.height} px"
    )


def show(options: SimpleNamespace, say: Say) -> None:
    """Draw a rig, a camera or a set: to a file, or in the browser."""
    out = options.out and Path(options.out)
    if out:
        if out.suffix.lower() not in ENDINGS:
            raise InputError(
                f"{out}: found ending {out.suffix or 'none'!r}; give "
                f"{' or '.join(ENDINGS)}"
            )
        check_can_be_written(out)
        check_written([out], [], [options.what, options.camera, options.corners])
    as_image = out and out.suffix.lower() == ".png"
    need(rendering_missing() if as_image else packages_missing())
    scene, title = _scene(options, out, say)
    if out is None:
        folder = tempfile.mkdtemp(prefix="raxel-show-")
        out = Path(folder, f"{title.split(':')[0]}.html")
    from raxel.show import html, png

    content = png(scene) if as_image else html(scene, title).encode()
    with replacing(out) as temporary:
        temporary.write_bytes(content)
    print(f"{scene.note}\n{out}")
    display = sys.platform in ("darwin", "win32") or os.environ.get("DISPLAY")
    if options.out is None and (display or os.environ.get("WAYLAND_DISPLAY")):
        webbrowser.open(out.as_uri())


def _scene(options: SimpleNamespace, out: Path | None, say: Say) -> tuple[Any, str]:
    """Return the scene and its title; `out` must not be a file of a set it shows."""
    from raxel.show.cameras import camera_scene, rig_scene, set_scene

    what = Path(options.what)
    if what.is_dir():
        if is_mirror_set(what):
            raise InputError(
                f"{what}: a mirror set, whose mirror is not calibrated; run raxel "
                "calibrate and show the camera that it writes"
            )
        for option, name in (("camera", CAMERA), ("corners", CORNERS)):
            if not getattr(options, option) and (what / name).is_file():
                setattr(options, option, str(what / name))
        options.set = options.what
        image_set = opened_set(options)
        check_written([out], [image_set])
        camera = options.camera and load_camera(options.camera)
        boards = options.corners and read_boards(options.corners, image_set)
        return (
            set_scene(image_set, camera, say, boards),
            f"{image_set.name}: targets in front of the camera",
        )
    for option in ("camera", "corners"):
        if getattr(options, option):
            raise InputError(
                f"--{option}: found with {what}, which is not an image set; remove it"
            )
    if what.suffix == ".npz":
        return camera_scene(load_camera(what), what.stem), f"{what.stem}: a camera"
    if what.suffix in (".yaml", ".yml"):
        from raxel.lab import load_rig

        rig = load_rig(what)
        return rig_scene(rig, options.seed), f"{rig.name}: a rig"
    found = f"found ending {what.suffix!r}" if what.exists() else "no such file"
    raise InputError(
        f"{what}: {found}; give a rig (.yaml), a camera (.npz) or the folder of a set"
    )
