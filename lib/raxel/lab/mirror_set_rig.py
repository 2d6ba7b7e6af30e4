"""Mirror rigs: the description of a rendered mirror set, read from one file.

A mirror rig names four rigs (`raxel.lab.rig`) with one camera: camera and board, mirror
and active grid, camera and plate with the flat mirror, mirror and board of the steps.
It also states the deflection of the mirror at each stage, parameters that replace those
of the rig, the precision of the clamp's picks, and the light at each noise level.
"""

import itertools
import os
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml

from raxel.cameras.mirrors.flexible import FlexibleMirrorCamera
from raxel.cameras.mirrors.planar import PlanarMirrorsCamera
from raxel.errors import InputError, did_you_mean
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import pose, transform
from raxel.io.documents import read_yaml, validate
from raxel.io.files import check_can_be_written, write_json, write_whole
from raxel.lab.rig import Laboratory, Rig, load_rig
from raxel.lab.scenes import board_scene
from raxel.lab.set_rendering import TRUTH, render_board, render_set, write_image
from raxel.lab.surfaces import Disc, Rectangle
from raxel.lab.target_poses import AroundPoses, ListedPoses, Visibility, outline_of
from raxel.lab.textures import Plain
from raxel.sets.image_set import write_set
from raxel.sets.mirror_set import DESCRIPTION, load_mirror_set
from raxel.sets.model import ActiveGrid, ImageSet, View

# A flat mirror next to a chessboard, on one plate, to measure the pose of a monitor.
# The silvered ring of a hard disk's platter lies on a board (thesis 5.2.1, Fig.
# 5.3b). The board's corners give the mirror's plane; in the mirror the viewer sees
# the monitor.


# Corners of the polygon along half of an edge.
N_EDGE_CORNERS = 90
# Margin of the plate around the mirror, mm, its reflectance, and its distance behind
# the face of the board, mm.
PLATE_MARGIN_MM, PLATTER_PLATE, BEHIND_MM = 4.0, 0.25, 1e-3


class PlatterRing(NamedTuple):
    """Hold a ring-shaped flat mirror on a board.

    centre_mm: (2,) in the board's plane, whose origin is the first interior corner;
    radius_mm, hub_mm: of the reflecting ring; thickness_mm: distance of its face from
    the board's face, towards the camera.
    """

    centre_mm: tuple[float, float]
    radius_mm: float
    hub_mm: float
    thickness_mm: float

    def T_board_mirror(self):
        """Pose (4, 4) of the silvered face: origin at its centre, z away from light."""
        return pose(np.eye(3), [*self.centre_mm, -self.thickness_mm])


def camera_in_platter(viewer, ring, T_camera_board):
    """Return the camera (PlanarMirrorsCamera) that views the world in the ring only.

    viewer: central camera; ring: PlatterRing on the board in pose T_camera_board
    (4, 4), mm. The ring is represented by two half rings, which are polygons.
    """
    angle = np.linspace(0, np.pi, N_EDGE_CORNERS)
    rim = np.column_stack([np.cos(angle), np.sin(angle)])
    half = np.concatenate([ring.radius_mm * rim, ring.hub_mm * rim[::-1]])
    T = T_camera_board @ ring.T_board_mirror()
    return PlanarMirrorsCamera(viewer, [T, T], [half, -half])


def render_plate(rig, ring, T_camera_board, rng):
    """Return the image (H, W) of the board with the ring, which reflects a dark room.

    rig: a Rig of a central camera and a board; ring: PlatterRing; T_camera_board:
    (4, 4), mm; rng: numpy Generator of the image's noise.
    """
    scene = board_scene(rig.target, T_camera_board, rig.border_mm, **rig.radiances)
    disc = Disc(T_camera_board @ ring.T_board_mirror(), ring.radius_mm, ring.hub_mm)
    reach = ring.radius_mm + PLATE_MARGIN_MM
    corner = np.array(ring.centre_mm) - reach
    behind = T_camera_board @ pose(np.eye(3), [0, 0, BEHIND_MM])
    plate = Rectangle(behind, 2 * reach, 2 * reach, corner)
    parts = (disc, Plain(0.0)), *scene.parts, (plate, Plain(PLATTER_PLATE))
    laboratory = Laboratory(rig.camera, rig.sensor, rig.optics)
    light = laboratory.irradiance(replace(scene, parts=parts), np.eye(4))
    return rig.sensor.expose(light, rng, colour=False)


SCHEMA = Path(__file__).with_name("mirror_set_rig.schema.json")
KEY = "raxel_mirror_rig"
RIGS = "viewer", "grids", "plate", "steps"
# Of the mirror's width, where the clamp is picked; and rays of rigs that share a
# camera agree within this, on so many pixels each way.
PICKED, AGREE, LINES = 0.9, 1e-9, 9
# A corner is detectable if so much of a square around it is visible.
CORNER_SQUARE_SHARE = 0.35
NOT_VISIBLE = "not entirely visible in the mirror before and after"


@dataclass(frozen=True, eq=False)
class MirrorSetRig:
    """Hold the content of a mirror rig's file. Lengths in mm, px, angles in radians.

    viewer, grids, plate, steps: Rigs; ring: the PlatterRing on the plate's board;
    changes: arguments of the FlexibleMirrorCamera by name that replace those of grids;
    stages: (k + 1, loads) mm; picks, pick_sd_px: of the clamp; light: name of a noise
    level -> share of the rigs' light in images of boards, and in those of the monitor's
    patterns; the first level is the default.
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
        """Return the rig with the light of a noise level, by its name; default: first.

        As with a higher sensitivity: fewer electrons make white, and full wells.
        Raises InputError for an unknown level.
        """
        level = next(iter(self.light)) if level is None else level
        if level not in self.light:
            advice = did_you_mean(level, self.light)
            advice = advice or f"known levels are {', '.join(self.light)}"
            raise InputError(f"{self.path}: noise: unknown level {level!r}; {advice}")
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
        """Return hand-picked pixels (n, 2) along the edge of the clamp."""
        mirror = camera.mirror
        y = PICKED * mirror.half_width * np.linspace(-1, 1, self.picks)
        x = np.full(self.picks, mirror.holder)
        z = mirror.height(x, y)[0]
        edge = transform(camera.T_viewer_mirror, np.column_stack([x, y, z]))
        return self.grids.camera.viewer.project(edge).pixels + rng.normal(
            0, self.pick_sd_px, (self.picks, 2)
        )

    def step_pose(self, rng, before, after):
        """Return T_camera_board (4, 4) with all corners in view of two cameras.

        Poses `around` a point are rotated to the mean viewing direction of the centre
        of the mirror in both. Raises InputError if no pose is found.
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

        corner = np.full(2, -CORNER_SQUARE_SHARE * self.steps.target.pitch_mm)
        rim = on_plane(outline_of(corner, np.ptp(points, axis=0) - 2 * corner))

        def fault(T):
            for rig in both:
                pixels, valid = rig.camera.project(transform(T, rim))
                if not (valid & rig.camera.in_image(pixels)).all() or not rig.shows(T):
                    return NOT_VISIBLE
            return ""

        try:
            return poses.draw(rng, 1, self.steps.extent, fault)[0]
        except InputError as found:
            raise InputError(f"{self.steps.path}: poses: {found}") from found


def is_mirror_set_rig(path):
    """Whether a readable file is a mirror rig."""
    data = read_yaml(Path(path))
    return isinstance(data, dict) and KEY in data


def load_mirror_set_rig(path):
    """Return the MirrorSetRig in a YAML file, with the rigs that it names.

    Raises InputError, one line with file and field, as `load_rig`; also if the rigs
    have different cameras, or a stage is impossible for the mirror.
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
    """Yield each fault as (field, problem and what to do)."""
    if len(rig.light) < len(data["noise"]):
        yield "noise", "a name is repeated; give each level its own name"
    if not rig.ring.hub_mm < rig.ring.radius_mm:
        yield "platter.hub", "not below the radius of the ring; give a smaller hub"
    for name in RIGS:
        grid = isinstance(getattr(rig, name).target, ActiveGrid)
        if grid != (name == "grids"):
            kind = "a board" if grid else "an active grid"
            yield name, f"target is not {kind}; give a rig with {kind}"
            return
    if not isinstance(rig.grids.camera, FlexibleMirrorCamera):
        yield "grids", "camera is not a flexible mirror; give a rig with one"
        return
    viewer = rig.grids.camera.viewer
    for name in ("viewer", "plate"):
        if not _same_rays(getattr(rig, name).camera, viewer):
            yield name, "camera differs from the viewer of grids; give the same camera"
    if not _same_rays(rig.steps.camera, rig.grids.camera):
        yield "steps", "camera differs from that of grids; give the same camera"
    if rig.plate.count != 1:
        yield "plate", f"{rig.plate.count} poses; give one"
    loads = len(np.atleast_1d(rig.changes.get("loads", rig.grids.camera.deflections)))
    if {len(one) for one in rig.stages} != {loads}:
        yield "stages", f"wrong number of deflections; give {loads} for each stage"
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


# Rendering of a mirror set from a mirror rig, with its ground truth. The set has the
# form of a recorded one (`raxel.sets.mirror_set`). In folders `truth`, opened by
# evaluation alone, are the cameras of the stages, the boards' poses, and what
# detectors and decoders ought to find. Without these folders nothing is lost but
# scores.


# Streams of random numbers, so that no draw depends on how many came before. Images
# of one are counted from 1: a stream that ends in 0 is the same as without it.
VIEWER, GRIDS, PLATTER, PLATE, STEPS, CLAMP, SPECIMEN = range(7)


def render_mirror_set(rig, out, seed, level=None, say=None):
    """Render all images of a MirrorSetRig; return the MirrorSet in `out`.

    level: of the noise, by name, default the first; the set's name ends in level and
    seed. seed: integer, 0 or more; it determines poses, noise and the mirror's
    aberration, and equal seeds give equal bytes. say: callable for one line of progress
    per part. Raises InputError for a folder that exists or cannot be created, and as
    the rigs' poses. An incomplete folder is removed.
    """
    out = Path(out)
    if out.exists() or out.is_symlink():
        raise InputError(f"{out}: exists already; name a new folder")
    check_can_be_written(out)
    say = say or (lambda line: None)
    rig = rig.darker(level)
    cameras = rig.cameras(seed)
    with tempfile.TemporaryDirectory(dir=out.parent, prefix=f".{out.name}-") as room:
        folder = Path(room) / "set"
        folder.mkdir()
        say("boards in view of the camera")
        render_set(rig.viewer, folder / "viewer", _seed(seed, VIEWER))
        _write_primary(rig, cameras[0], folder, seed, say)
        steps, poses = _write_steps(rig, cameras, folder / "stages", seed, say)
        _write_truth(folder / TRUTH, cameras, poses)
        picked = rig.clamp_pixels(cameras[0], np.random.default_rng([seed, CLAMP]))
        text = yaml.safe_dump(_described(rig, picked, steps, seed), sort_keys=False)
        write_whole(folder / DESCRIPTION, text)
        load_mirror_set(folder)
        os.rename(folder, out)
    return load_mirror_set(out)


def _seed(seed, stream):
    """Return a separate seed for one of the image sets."""
    return int(np.random.SeedSequence([seed, stream]).generate_state(1)[0])


def _write_primary(rig, camera, folder, seed, say):
    """The active grid in the mirror, the same in the platter, and the plate's board."""
    drawn = rig.grids.draw_poses(np.random.default_rng([seed, GRIDS]), rig.grids.count)
    names = tuple(rig.grids.view_name(k) for k in range(len(drawn)))
    poses = ListedPoses(drawn, names, (False,) * len(names))
    grids = replace(rig.grids, poses=poses, evaluate=0)
    say("active grid in the flexible mirror")
    render_set(replace(grids, camera=camera), folder / "grids", _seed(seed, GRIDS))
    say("active grid in the flat mirror")
    T = rig.plate.draw_poses(np.random.default_rng([seed, PLATE]), 1)[0]
    seen = camera_in_platter(rig.plate.camera, rig.ring, T)
    shown = replace(grids, camera=seen)
    render_set(shown, folder / "platter", _seed(seed, PLATTER))
    plate = folder / "plate"
    plate.mkdir()
    files = [f"{name}.png" for name in names]
    for k, name in enumerate(files, 1):
        rng = np.random.default_rng([seed, PLATE, k])
        write_image(plate / name, render_plate(rig.plate, rig.ring, T, rng))
    _write_boards(rig.plate, files, plate)


def _write_steps(rig, cameras, folder, seed, say):
    """(steps for mirror.yaml, true poses by image)"""
    folder.mkdir()
    steps, poses = [], {}
    for k, pair in enumerate(itertools.pairwise(cameras), 1):
        say(f"step {k}")
        T = rig.step_pose(np.random.default_rng([seed, STEPS, k]), *pair)
        names = {key: f"s{k}-{key}.png" for key in ("before", "after")}
        for name, camera in zip(names.values(), pair, strict=True):
            noise = np.random.default_rng([seed, STEPS, k, len(poses) + 1])
            specimen = np.random.default_rng([seed, SPECIMEN])
            taken = replace(rig.steps, camera=camera)
            write_image(folder / name, render_board(taken, T, noise, specimen))
            poses[name] = T.tolist()
        moved = np.subtract(rig.stages[k], rig.stages[k - 1])
        # With several loads no single number describes the motion of the mirror.
        stated = {"deflection_mm": float(moved[0])} if len(moved) == 1 else {}
        steps.append(names | stated)
    _write_boards(rig.steps, list(poses), folder)
    return steps, poses


def _write_boards(rig, images, folder):
    described = ImageSet(
        name=folder.name,
        width=rig.camera.width,
        height=rig.camera.height,
        target=rig.target,
        views=tuple(View(image=image) for image in images),
        folder=folder,
        camera=rig.summary,
        origin={"source": "rendered", "note": f"by raxel's laboratory: {rig.name}"},
    )
    write_set(described)


def _write_truth(folder, cameras, poses):
    folder.mkdir()
    for k, camera in enumerate(cameras):
        camera.save(folder / f"stage-{k}.npz")
    write_json(folder / "poses.json", {"unit": "mm", "T_camera_target": poses})


def _described(rig, picked, steps, seed):
    """The content of mirror.yaml."""
    (level,) = rig.light
    hidden = float(rig.changes.get("holder", rig.grids.camera.mirror.holder))
    clamp = {"points": picked.round(2).tolist(), "sd_px": rig.pick_sd_px}
    sets = {name: name for name in ("grids", "platter", "plate")}
    return {
        "raxel_mirror_set": 1,
        "name": f"{rig.name}-{level}-{seed}",
        "viewer": "viewer",
        "primary": sets | {"thickness_mm": rig.ring.thickness_mm},
        "clamp": clamp | ({"hidden_mm": hidden} if hidden else {}),
        "stages": {"set": "stages", "steps": steps},
    }
