"""The mirror set, version 1: the images for the calibration of a flexible mirror.

A folder with a mirror.yaml, and image sets in separate folders: a board that the camera
views directly, an active grid in two positions or more that it views in the flexible
mirror and in a flat reference mirror, the board under the flat mirror, and a board in
the flexible mirror before and after each deflection (thesis 5.2).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path, PureWindowsPath

from raxel.errors import InputError
from raxel.io.documents import field_name, one_line, read_yaml, validate
from raxel.sets.image_set import load_set
from raxel.sets.model import ActiveGrid, Charuco, Chessboard, ImageSet

DESCRIPTION = "mirror.yaml"
SCHEMA = Path(__file__).with_name("mirror_set.schema.json")
PICKED_SD_PX = 1.0  # of a point picked by hand on an edge
MIN_N_POSITIONS = 2
OF_PRIMARY = ("grids", "platter", "plate")


@dataclass(frozen=True)
class PickedClamp:
    """Describe the clamp of the mirror in an image before the first deflection.

    Attributes
    ----------
    points : tuple of (float, float)
        Pixels (u, v) along the edge of the clamp.
    sd_px : float
        Standard deviation of the points across the edge, px.
    hidden_mm : float
        Largest distance, mm, from the edge to the true clamp, where a holder occludes
        the clamp.
    """

    points: tuple[tuple[float, float], ...]
    sd_px: float = PICKED_SD_PX
    hidden_mm: float = 0.0


@dataclass(frozen=True)
class MirrorStep:
    """Describe one deflection of the mirror.

    Attributes
    ----------
    before, after : str
        Names of images with the board in one position, before and after the deflection.
    evaluate : tuple of str
        Names of other images after the deflection, for scoring.
    deflection_mm : float or None
        Motion of the mirror, mm; None where unknown.
    """

    before: str
    after: str
    evaluate: tuple[str, ...] = ()
    deflection_mm: float | None = None


@dataclass(frozen=True)
class MirrorSet:
    """Hold the content of mirror.yaml, with its image sets read.

    Attributes
    ----------
    name : str
        Name of the set.
    folder : Path
        Folder of mirror.yaml.
    viewer : ImageSet or Path
        Images of boards, or the file of a camera.
    grids, platter : ImageSet
        Images of one active grid; see `platter_views`.
    plate : ImageSet
        One image for each view of `platter`.
    thickness_mm : float
        Thickness of the flat reference mirror, mm.
    clamp : PickedClamp
        Clamp of the mirror.
    stages : ImageSet
        Images of a board.
    steps : tuple of MirrorStep
        The deflections.
    """

    name: str
    folder: Path
    viewer: ImageSet | Path
    grids: ImageSet
    platter: ImageSet
    plate: ImageSet
    thickness_mm: float
    clamp: PickedClamp
    stages: ImageSet
    steps: tuple[MirrorStep, ...]

    @property
    def description(self) -> Path:
        """Return the path of mirror.yaml, as messages name it."""
        return self.folder / DESCRIPTION

    @property
    def image_sets(self) -> dict[str, ImageSet]:
        """Return the image sets by field of mirror.yaml, in order of use."""
        named = {"viewer": self.viewer} if isinstance(self.viewer, ImageSet) else {}
        return named | {
            "primary.grids": self.grids,
            "primary.platter": self.platter,
            "primary.plate": self.plate,
            "stages.set": self.stages,
        }

    @property
    def size(self) -> tuple[int, int]:
        """Return (width, height) of the images, px."""
        return self.grids.width, self.grids.height

    def platter_views(self, position: str) -> list[int]:
        """Return the views of `platter` with the grid where a view of `grids` has it.

        These are the views of the same name, and of that name with a dot and more.

        Parameters
        ----------
        position : str
            Label of a view of `grids`.

        Returns
        -------
        list of int
            Indices of the views of `platter`.
        """
        return [
            index
            for index, view in enumerate(self.platter.views)
            if view.label == position or view.label.startswith(f"{position}.")
        ]


def is_mirror_set(folder: str | Path) -> bool:
    """Return whether a folder holds a mirror.yaml.

    Parameters
    ----------
    folder : str or Path
        The folder.

    Returns
    -------
    bool
        Whether the file exists.
    """
    return (Path(folder) / DESCRIPTION).is_file()


def load_mirror_set(folder: str | Path) -> MirrorSet:
    """Read and check the mirror set in a folder, and every image set that it names.

    Parameters
    ----------
    folder : str or Path
        Folder with a mirror.yaml.

    Returns
    -------
    MirrorSet
        The set.

    Raises
    ------
    InputError
        As `load_set`, and if the image sets do not fit together. The message has one
        line: file, field, problem, what to do.
    """
    folder = Path(folder)
    if not is_mirror_set(folder):
        raise InputError(
            f"{folder}: not a mirror set (no {DESCRIPTION}); give a folder with one"
        )
    where = folder / DESCRIPTION
    data = read_yaml(where)
    validate(data, where, SCHEMA)
    mirror_set = _from_plain(data, folder)
    for path, fault in _faults(mirror_set):
        raise InputError(f"{where}: {field_name(path)}: {fault}")
    return mirror_set


def _from_plain(data, folder):
    primary, stages, clamp = data["primary"], data["stages"], data["clamp"]
    sets = {
        key: _image_set(folder, ("primary", key), primary[key]) for key in OF_PRIMARY
    }
    return MirrorSet(
        name=data["name"],
        folder=folder,
        viewer=_viewer(folder, data["viewer"]),
        thickness_mm=float(primary["thickness_mm"]),
        clamp=PickedClamp(
            tuple((float(u), float(v)) for u, v in clamp["points"]),
            float(clamp.get("sd_px", PICKED_SD_PX)),
            float(clamp.get("hidden_mm", 0.0)),
        ),
        stages=_image_set(folder, ("stages", "set"), stages["set"]),
        steps=tuple(map(_step, stages["steps"])),
        **sets,
    )


def _step(data):
    moved = data.get("deflection_mm")
    return MirrorStep(
        data["before"],
        data["after"],
        tuple(data.get("evaluate", ())),
        None if moved is None else float(moved),
    )


def _viewer(folder, name):
    path = _inside(folder, ("viewer",), name)
    if path.suffix == ".npz":
        if not path.is_file():
            raise InputError(
                f"{folder / DESCRIPTION}: viewer: no file {name}; give the .npz file "
                "of a camera, or the folder of an image set"
            )
        return path
    return load_set(path)


def _image_set(folder, field, name):
    return load_set(_inside(folder, field, name))


def _inside(folder, field, name):
    where = f"{folder / DESCRIPTION}: {field_name(field)}: {one_line(name)}"
    parts = PureWindowsPath(name).parts
    if PureWindowsPath(name).anchor or Path(name).is_absolute() or ".." in parts:
        raise InputError(
            f"{where} is outside the set's folder; move the image set into the folder"
        )
    if not name.isprintable():
        raise InputError(f"{where} has a control character; rename the folder")
    return folder / name


def _faults(mirror_set):
    """Yield each fault as (path of the field, problem and what to do)."""
    yield from _size_faults(mirror_set)
    yield from _target_faults(mirror_set)
    yield from _position_faults(mirror_set)
    yield from _clamp_faults(mirror_set)
    yield from _step_faults(mirror_set)


def _size_faults(mirror_set):
    for field, image_set in mirror_set.image_sets.items():
        size = image_set.width, image_set.height
        if size != mirror_set.size:
            sizes = (
                f"{width} x {height} px" for width, height in (size, mirror_set.size)
            )
            fault = "images have {}, those of primary.grids {}; use one camera"
            yield (field,), fault.format(*sizes)


def _target_faults(mirror_set):
    for field, image_set in mirror_set.image_sets.items():
        grid = field in ("primary.grids", "primary.platter")
        target = image_set.target
        if grid and not isinstance(target, ActiveGrid):
            yield (field,), "target is a board; give an image set of an active grid"
        elif not grid and type(target) not in (Chessboard, Charuco):
            fault = "target is no chessboard or ChArUco board; give an image set of one"
            yield (field,), fault
        elif target.unit != "mm":
            unknown = "monitor_mm" if grid else "pitch_mm"
            yield (field,), f"target.{unknown} is null; give the measured value in mm"
        elif not grid and target.columns is None:
            yield (field,), "target.columns and rows are null; give both counts"
    if mirror_set.grids.target != mirror_set.platter.target:
        fault = "target differs from that of primary.grids; use one monitor for both"
        yield ("primary", "platter"), fault


def _position_faults(mirror_set):
    names = [view.label for view in mirror_set.grids.views]
    if len(names) < MIN_N_POSITIONS:
        fault = f"{len(names)} position of the active grid"
        yield ("primary", "grids"), f"{fault}; give {MIN_N_POSITIONS} or more"
    for name in names:
        if not mirror_set.platter_views(name):
            fault = f"no view {one_line(name)} (a view of primary.grids); add the grid"
            yield ("primary", "platter"), f"{fault} in the flat mirror at that position"
    count = len(mirror_set.platter.views)
    placed = {k for name in names for k in mirror_set.platter_views(name)}
    for k in sorted(set(range(count)) - placed):
        label = one_line(mirror_set.platter.views[k].label)
        fault = f"view {label} has no position of primary.grids; name it after one"
        yield ("primary", "platter"), fault
    if len(mirror_set.plate.views) != count:
        fault = f"{len(mirror_set.plate.views)} images for {count} views of platter"
        yield ("primary", "plate"), f"{fault}; give one per view, in their order"


def _clamp_faults(mirror_set):
    points = mirror_set.clamp.points
    if len(set(points)) < 2:
        yield ("clamp", "points"), "all points are equal; pick points along the edge"
    width, height = mirror_set.size
    for k, (u, v) in enumerate(points):
        if not (-0.5 <= u <= width - 0.5 and -0.5 <= v <= height - 0.5):
            fault = f"[{u:g}, {v:g}] is outside the image of {width} x {height} px"
            yield ("clamp", "points", k), f"{fault}; pick a point in the image"


def _step_faults(mirror_set):
    known = [view.label for view in mirror_set.stages.views]
    state_of = {}
    for k, step in enumerate(mirror_set.steps):
        for key, name, state in _images(step, k):
            path = ("stages", "steps", k, key)
            if name not in known:
                where = one_line(mirror_set.stages.name)
                fault = f"{one_line(name)} is not a view of {where}"
                yield path, f"{fault}; add it to the views, or correct the name"
            elif state_of.setdefault(name, state) != state:
                states = f"{state_of[name]} deflections elsewhere, after {state} here"
                fault = f"{one_line(name)} is taken after {states}"
                yield path, f"{fault}; use an image for one state of the mirror"


def _images(step, k):
    """Yield (key, name, deflections before it) of the images of step k."""
    yield "before", step.before, k
    yield "after", step.after, k + 1
    for name in step.evaluate:
        yield "evaluate", name, k + 1
