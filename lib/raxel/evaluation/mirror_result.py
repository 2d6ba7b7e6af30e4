"""What a calibration of a mirror set says of every stage: RESULT.npz, version 1.

The file by which any program enters the benchmark of mirrors that bend. An .npz archive
of plain arrays:

    raxel_mirror_result   1
    set                   text: the name in the set's mirror.yaml
    size                  (2,) width and height of the photographs, px
    unit, frame           the texts 'mm' and 'viewer'
    stages                how many: one more than the set has steps
    stage0.pixels         (N, 2) pixels (u, v), columns first, the first's centre (0, 0)
    stage0.origins        (N, 3) a point of each pixel's ray, mm
    stage0.directions     (N, 3) unit vectors, from the mirror towards the scene
    stage0.points         (M, 3) points of the mirror's face, mm
    viewer.pixels         (K, 2) any pixels, and
    viewer.directions     (K, 3) where the viewer looks there, unit, before the mirror
    seconds               what the calibration took, as the entrant states it
    method                text: what it is, in a line

and so on for stage1, ... A stage has its rays, its points, or both; (0, 2) and (0, 3)
say that there is no answer. Pixels without a ray are left out. `viewer`, `seconds` and
`method` may be missing. Frame: the viewer's, origin at its centre, x along the rows of
the picture, y down its columns, z into the scene.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from raxel.errors import InputError
from raxel.io.archives import Archive
from raxel.io.documents import one_line
from raxel.io.files import replacing

VERSION, UNIT, FRAME = 1, "mm", "viewer"
WHAT = "result file of a mirror set"
# Of rays and points of a stage; as many stages as a mirror set may have, and one.
MOST_ROWS, MOST_STAGES = 10_000_000, 1001
# Nothing of a mirror on a table is farther away, mm; a unit vector's length is 1 within
# this much.
FARTHEST, UNIT_LENGTH = 1e6, 1e-3
LONGEST_TEXT = 100
SIDE_PX = 32_000


class SampledRays(NamedTuple):
    """pixels (N, 2); origins (N, 3) mm, a point of each ray; directions (N, 3) unit."""

    pixels: np.ndarray
    origins: np.ndarray
    directions: np.ndarray


class StageAnswer(NamedTuple):
    """rays: SampledRays, points: (M, 3) mm of the mirror's face; either may be None."""

    rays: SampledRays | None
    points: np.ndarray | None


class MirrorResult(NamedTuple):
    """What RESULT.npz holds.

    set: name of the mirror set; size: (width, height) px; stages: a StageAnswer each;
    viewer: (pixels (K, 2), directions (K, 3)) before the mirror, or None; seconds: of
    the calibration, or None; method: one line, '' where not given.
    """

    set: str
    size: tuple[int, int]
    stages: tuple[StageAnswer, ...]
    viewer: tuple[np.ndarray, np.ndarray] | None = None
    seconds: float | None = None
    method: str = ""


def sampled_result(mirror_set, cameras, pixels, seconds=None, method=""):
    """MirrorResult of a camera for each stage, at pixels (N, 2) where it has a ray.

    The rays of a camera with a `mirror` begin on it, and so give its points as well.
    Where there is a `viewer`, its directions are given for those of the pixels.
    """
    stages = []
    for camera in cameras:
        seen = camera.rays(pixels)
        own = seen.valid
        rays = SampledRays(pixels[own], seen.origins[own], seen.directions[own])
        on_mirror = hasattr(camera, "mirror")
        stages.append(StageAnswer(rays, rays.origins if on_mirror else None))
    viewer = getattr(cameras[0], "viewer", None)
    if viewer is not None:
        looks = viewer.rays(pixels)
        viewer = pixels[looks.valid], looks.directions[looks.valid]
    size = mirror_set.size
    return MirrorResult(mirror_set.name, size, tuple(stages), viewer, seconds, method)


def write_mirror_result(path, result):
    """Write a MirrorResult to `path`, whole or not at all."""
    fields = {
        "raxel_mirror_result": VERSION,
        "set": result.set,
        "size": result.size,
        "unit": UNIT,
        "frame": FRAME,
        "stages": len(result.stages),
    }
    for k, stage in enumerate(result.stages):
        named = {} if stage.rays is None else stage.rays._asdict()
        if stage.points is not None:
            named["points"] = stage.points
        fields |= {f"stage{k}.{name}": value for name, value in named.items()}
    if result.viewer is not None:
        fields["viewer.pixels"], fields["viewer.directions"] = result.viewer
    if result.seconds is not None:
        fields["seconds"] = float(result.seconds)
    if result.method:
        fields["method"] = result.method
    with replacing(path) as temporary, temporary.open("wb") as stream:
        np.savez_compressed(stream, **{k: np.array(v) for k, v in fields.items()})


def read_mirror_result(path):
    """The MirrorResult in the file at `path`, every field checked.

    Directions are made unit where they are a little off. Raises InputError, one line
    with file and field, for a file that is no such result or damaged; other units or
    another frame; fields missing or of another shape; numbers that are not finite or
    beyond a kilometre; pixels outside the picture or given twice.
    """
    with Archive(path, WHAT) as archive:
        reader = _ResultFields(path, archive)
        reader.check_word("raxel_mirror_result", VERSION, "of this format")
        reader.check_word("unit", UNIT, "for all lengths")
        reader.check_word("frame", FRAME, "with its origin at the viewer's centre")
        size = reader.size()
        stages = reader.whole("stages", 1, MOST_STAGES)
        return MirrorResult(
            set=reader.text("set"),
            size=size,
            stages=tuple(reader.stage(f"stage{k}", size) for k in range(stages)),
            viewer=reader.viewer(size),
            seconds=reader.seconds(),
            method=reader.text("method") if archive.has("method") else "",
        )


class _ResultFields:
    """Fields of an open archive: each fault an InputError with file and field."""

    def __init__(self, path, archive):
        self._path, self._archive = path, archive

    def check_word(self, name, wanted, meaning):
        found = self._single(name)
        if found != wanted or isinstance(found, str) != isinstance(wanted, str):
            raise self._fault(name, f"found {found!r}; give {wanted!r} {meaning}")

    def text(self, name):
        found = self._single(name)
        fits = isinstance(found, str) and len(found) <= LONGEST_TEXT
        if not fits or not found.isprintable():
            told = f"found {one_line(found)!r}; give a text of one line"
            raise self._fault(name, f"{told}, {LONGEST_TEXT} characters at most")
        return found

    def whole(self, name, least, most):
        found = self._single(name)
        if isinstance(found, (str, bool)) or not least <= found <= most:
            fits = False
        else:
            fits = found == int(found)
        if not fits:
            told = f"found {found!r}; give a whole number, {least} to {most}"
            raise self._fault(name, told)
        return int(found)

    def size(self):
        found = self._numbers("size", (2,))
        if not (np.all(found == np.rint(found)) and np.all(found >= 1)):
            told = f"found {found.tolist()}; give the width and height in pixels"
            raise self._fault("size", told)
        if found.max() > SIDE_PX:
            raise self._fault("size", f"found {found.tolist()}; no picture is so large")
        return tuple(map(int, found))

    def seconds(self):
        if not self._archive.has("seconds"):
            return None
        found = self._single("seconds")
        if isinstance(found, (str, bool)) or not 0 <= found < math.inf:
            told = f"found {found!r}; give a number, 0 or more, or leave it out"
            raise self._fault("seconds", told)
        return float(found)

    def viewer(self, size):
        names = "viewer.pixels", "viewer.directions"
        if not any(map(self._archive.has, names)):
            return None
        pixels = self._pixels(names[0], size)
        return pixels, self._directions(names[1], len(pixels))

    def stage(self, stage, size):
        parts = [f"{stage}.{name}" for name in SampledRays._fields]
        rays = None
        if any(map(self._archive.has, parts)):
            pixels = self._pixels(parts[0], size)
            origins = self._lengths(parts[1], len(pixels))
            rays = SampledRays(pixels, origins, self._directions(parts[2], len(pixels)))
        name = f"{stage}.points"
        points = self._lengths(name) if self._archive.has(name) else None
        if rays is None and points is None:
            told = "missing; give its pixels, origins and directions, or its points"
            raise self._fault(stage, told)
        return StageAnswer(rays, points)

    def _pixels(self, name, size):
        pixels = self._numbers(name, (None, 2))
        inside = np.all((pixels >= -0.5) & (pixels <= np.array(size) - 0.5), axis=1)
        if not inside.all():
            first = pixels[~inside][0].tolist()
            told = f"found {first} outside a picture of {size[0]} x {size[1]} px; give"
            raise self._fault(name, f"{told} (column, row), from 0")
        if len(np.unique(pixels, axis=0)) < len(pixels):
            raise self._fault(name, "found a pixel twice; give each once")
        return pixels

    def _lengths(self, name, count=None):
        lengths = self._numbers(name, (count, 3))
        if np.abs(lengths).max(initial=0) > FARTHEST:
            worst = np.abs(lengths).max()
            told = f"found {worst:g} mm; nothing is so far from a camera's mirror"
            raise self._fault(name, f"{told}, give mm in the viewer's frame")
        return lengths

    def _directions(self, name, count):
        directions = self._numbers(name, (count, 3))
        with np.errstate(over="ignore"):
            length = np.linalg.norm(directions, axis=1)
        if np.any(np.abs(length - 1) > UNIT_LENGTH):
            worst = length[np.argmax(np.abs(length - 1))]
            raise self._fault(name, f"found one {worst:g} long; give unit vectors")
        return directions / length[:, None]

    def _numbers(self, name, shape):
        """Real, finite numbers of a shape, None standing for any length."""
        self._need(name)
        found = self._archive.shape(name)
        wanted = tuple("N" if n is None else n for n in shape)
        fits = len(found) == len(shape) and all(
            n in (None, m) for n, m in zip(shape, found, strict=True)
        )
        if not fits or found[0] > MOST_ROWS:
            told = f"shape {found} found; {wanted} needed".replace("'", "")
            raise self._fault(name, told)
        values = self._archive.array(name, 3 * MOST_ROWS)
        if values.dtype.kind not in "iuf":
            raise self._fault(name, f"found {values.dtype}; numbers are needed")
        values = values.astype(float)
        if not np.isfinite(values).all():
            rows = np.count_nonzero(~np.isfinite(values).all(axis=-1))
            told = (
                f"found {rows} of {len(values)} rows with numbers that are not finite"
            )
            raise self._fault(name, f"{told}; leave such pixels or points out")
        return values

    def _single(self, name):
        """The single text or finite number under `name`."""
        self._need(name)
        alone = self._archive.shape(name) == ()
        value = self._archive.array(name, 1) if alone else None
        if value is None or value.dtype.kind not in "biufU":
            raise self._fault(name, "found no single number or text; give one")
        try:
            found = value.item()
        except (ValueError, SystemError) as fault:
            raise self._fault(name, "no text; save it anew") from fault
        if isinstance(found, float) and not math.isfinite(found):
            raise self._fault(name, f"found {found}; give a finite number")
        return found

    def _need(self, name):
        if not self._archive.has(name):
            told = "missing; give it as raxel calibrate --rays does for a mirror set"
            raise self._fault(name, told)

    def _fault(self, name, text):
        return InputError(f"{self._path}: field '{name}': {text}")
