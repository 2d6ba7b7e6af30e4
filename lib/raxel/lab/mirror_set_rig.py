"""A mirror rig: all that a mirror set is photographed of, read from one file.

It names four rigs (`raxel.lab.rig`) that share one camera: the camera before a board,
the mirror before an active grid, the camera before the plate with the flat mirror, and
the mirror before the board of the steps. Beside them it says how far the mirror is bent
at each stage, what it has instead of what the rig says, how well the clamp is picked,
and how little light the pictures of each level of noise have.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from raxel.cameras.mirrors.flexible import FlexibleMirrorCamera
from raxel.errors import InputError, did_you_mean
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import transform
from raxel.io.documents import read_yaml, validate
from raxel.lab.platter_views import PlatterRing
from raxel.lab.rig import Rig, load_rig
from raxel.lab.target_poses import AroundPoses, Visibility, outline_of
from raxel.sets.model import ActiveGrid

SCHEMA = Path(__file__).with_name("mirror_set_rig.schema.json")
KEY = "raxel_mirror_rig"
RIGS = "viewer", "grids", "plate", "steps"
# Of the mirror's width, where the clamp is picked; and rays of rigs that share a
# camera agree within this, on so many pixels each way.
PICKED, AGREE, LINES = 0.9, 1e-9, 9
# A corner is found where so much of a square around it is seen.
CLEAR = 0.35
BEFORE_AND_AFTER = "not seen whole in the mirror before and after"


@dataclass(frozen=True, eq=False)
class MirrorSetRig:
    """What a mirror rig's file says. Lengths in mm, pixels, angles in radians.

    viewer, grids, plate, steps: Rigs; ring: the PlatterRing on the plate's board;
    changes: arguments of the FlexibleMirrorCamera by name, instead of those of grids;
    stages: (k + 1, loads) mm; picks, pick_sd_px: of the clamp; light: name of a level
    of noise -> share of the rigs' light that pictures of boards have, and those of
    the monitor's patterns; the first is the default.
    """

    path: Path
    name: str
    summary: str
    viewer: Rig
    grids: Rig
    plate: Rig
    steps: Rig
    ring: PlatterRing
    changes: dict
    stages: tuple
    picks: int
    pick_sd_px: float
    light: dict

    def cameras(self, seed):
        """The FlexibleMirrorCameras of the stages; `seed` draws the aberration."""
        own = self.grids.camera.arguments() | self.changes | {"seed": seed}
        return [
            FlexibleMirrorCamera(**own | {"deflections": list(deflections)})
            for deflections in self.stages
        ]

    def darker(self, level=None):
        """The same with the light of a level of noise, by its name; default: the first.

        As at a higher sensitivity: fewer electrons make white, and full wells. Raises
        InputError for a level that there is not.
        """
        level = next(iter(self.light)) if level is None else level
        if level not in self.light:
            advice = did_you_mean(level, self.light)
            advice = advice or f"known are {', '.join(self.light)}"
            raise InputError(f"{self.path}: noise: no level {level!r}; {advice}")
        boards, patterns = self.light[level]
        rigs = {}
        for name in RIGS:
            rig, share = getattr(self, name), patterns if name == "grids" else boards
            electrons = {
                field: share * getattr(rig.sensor, field)
                for field in ("white_e", "full_well_e")
            }
            rigs[name] = replace(rig, sensor=replace(rig.sensor, **electrons))
        return replace(self, light={level: (1.0, 1.0)}, **rigs)

    def clamp_pixels(self, camera, rng):
        """Pixels (n, 2) along the edge where the sheet comes out of its holder, picked
        by hand."""
        mirror = camera.mirror
        y = PICKED * mirror.half_width * np.linspace(-1, 1, self.picks)
        x = np.full(self.picks, mirror.holder)
        z = mirror.height(x, y)[0]
        edge = transform(camera.T_viewer_mirror, np.column_stack([x, y, z]))
        return self.grids.camera.viewer.project(edge).pixels + rng.normal(
            0, self.pick_sd_px, (self.picks, 2)
        )

    def step_pose(self, rng, before, after):
        """T_camera_board (4, 4), each of the board's corners in view by two cameras.

        Poses `around` a point are turned to where the middle of the sheet looks, on
        average over the two. Raises InputError where no pose comes up.
        """
        steps = replace(self.steps, visibility=Visibility(whole=False))
        both = [replace(steps, camera=camera) for camera in (before, after)]
        points = self.steps.target.points()
        poses = self.steps.poses
        if isinstance(poses, AroundPoses):
            centre, axis = np.mean(
                [_middle_ray(one) for one in (before, after)], axis=0
            )
            poses = replace(poses, centre=tuple(centre), axis=tuple(axis))

        corner = np.full(2, -CLEAR * self.steps.target.pitch_mm)
        rim = on_plane(outline_of(corner, np.ptp(points, axis=0) - 2 * corner))

        def fault(T):
            for rig in both:
                pixels, valid = rig.camera.project(transform(T, rim))
                if not (valid & rig.camera.in_image(pixels)).all() or not rig.shows(T):
                    return BEFORE_AND_AFTER
            return ""

        try:
            return poses.draw(rng, 1, self.steps.extent, fault)[0]
        except InputError as found:
            raise InputError(f"{self.steps.path}: poses: {found}") from found


def is_mirror_set_rig(path):
    """Whether a file that can be read says that it is a mirror rig's."""
    data = read_yaml(Path(path))
    return isinstance(data, dict) and KEY in data


def load_mirror_set_rig(path):
    """The MirrorSetRig in a YAML file, with the rigs that it names.

    Raises InputError, one line with file and field, as `load_rig`; also where the rigs
    do not share a camera, or a stage is none that the mirror can have.
    """
    path = Path(path)
    data = read_yaml(path)
    validate(data, path, SCHEMA)
    rigs = {name: load_rig(path.parent / data[name]) for name in RIGS}
    rig = MirrorSetRig(
        path=path,
        name=data["name"],
        summary=data.get("summary", ""),
        ring=_ring(data["platter"]),
        changes=_changes(data.get("mirror", {})),
        stages=tuple(tuple(map(float, one)) for one in data["stages"]["value"]),
        picks=int(data["clamp"]["points"]["value"]),
        pick_sd_px=float(data["clamp"]["sd"]["value"]),
        light={one["name"]: _shares(one) for one in data["noise"]},
        **rigs,
    )
    for field, fault in _faults(rig, data):
        raise InputError(f"{path}: {field}: {fault}")
    return rig


def _ring(data):
    values = {name: leaf["value"] for name, leaf in data.items()}
    centre = tuple(map(float, values["centre"]))
    return PlatterRing(
        centre, *(float(values[name]) for name in ("radius", "hub", "thickness"))
    )


def _shares(level):
    return tuple(float(level[name]["value"]) for name in ("light", "monitor"))


def _changes(data):
    values = {name: leaf["value"] for name, leaf in data.items()}
    if "rulings" in values:
        values["rulings"] = np.radians(values["rulings"])
    return values


def _faults(rig, data):
    """Each fault as (field, what was found and what to do)."""
    if len(rig.light) < len(data["noise"]):
        yield "noise", "found a name twice; give each level its own"
    if not rig.ring.hub_mm < rig.ring.radius_mm:
        yield "platter.hub", "found no less than its radius; give less"
    for name in RIGS:
        grid = isinstance(getattr(rig, name).target, ActiveGrid)
        if grid != (name == "grids"):
            found = "an active grid" if grid else "a board"
            yield name, f"its target is {found}; give a rig with the other"
            return
    if not isinstance(rig.grids.camera, FlexibleMirrorCamera):
        yield "grids", "its camera is no flexible mirror; give a rig with one"
        return
    viewer = rig.grids.camera.viewer
    for name in ("viewer", "plate"):
        if not _same_rays(getattr(rig, name).camera, viewer):
            yield name, "its camera is not the viewer of grids; give the same camera"
    if not _same_rays(rig.steps.camera, rig.grids.camera):
        yield "steps", "its camera is not that of grids; give the same camera"
    if rig.plate.count != 1:
        yield "plate", f"found {rig.plate.count} poses; give one"
    loads = len(np.atleast_1d(rig.changes.get("loads", rig.grids.camera.deflections)))
    if {len(one) for one in rig.stages} != {loads}:
        yield "stages", f"give {loads} deflections for each stage, one for each load"
        return
    try:
        rig.cameras(0)
    except InputError as fault:
        yield "stages", str(fault)


def _middle_ray(camera):
    """Origin and direction (2, 3) of the ray by the middle of the flat sheet."""
    mirror = camera.mirror
    x, y = np.array([mirror.end / 2]), np.zeros(1)
    middle = np.column_stack([x, y, mirror.height(x, y)[0]])
    pixel = camera.viewer.project(transform(camera.T_viewer_mirror, middle)).pixels
    rays = camera.rays(pixel)
    return np.stack([rays.origins[0], rays.directions[0]])


def _same_rays(first, second):
    """Whether two cameras of one size have the same rays."""
    if (first.width, first.height) != (second.width, second.height):
        return False
    u, v = (np.linspace(0, n - 1, LINES) for n in (first.width, first.height))
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    one, other = first.rays(pixels), second.rays(pixels)
    near = {"rtol": 0, "atol": AGREE, "equal_nan": True}
    return np.allclose(one.directions, other.directions, **near) and np.allclose(
        one.origins, other.origins, **near
    )
