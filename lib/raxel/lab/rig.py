"""A rig: camera, lens, sensor, target and poses, read from one file.

Each quantity in the file is {value, unit, origin, reason}. The schema next to this
module defines the fields and their units.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.cameras.core.base import Camera, Projection, as_rows, checked_array
from raxel.cameras.core.storage import MAX_NESTING_DEPTH, argument_names
from raxel.cameras.mirrors.bent import ball_facets
from raxel.cameras.mirrors.planar import PlanarMirrorsCamera
from raxel.cameras.mirrors.quadric import QuadricMirrorCamera
from raxel.cameras.registry import CAMERAS, camera_from, with_nested
from raxel.errors import InputError, did_you_mean
from raxel.geometry.poses import pose, rotation_from_vector
from raxel.io.documents import read_yaml, validate
from raxel.io.files import physical_memory
from raxel.lab.lighting import Blemishes, Lighting
from raxel.lab.optics import Crop, Optics
from raxel.lab.rendering import render
from raxel.lab.scene import TexturedScene
from raxel.lab.sensor import Sensor
from raxel.lab.target_poses import (
    AroundPoses,
    DrawnPoses,
    ListedPoses,
    Visibility,
    outline_of,
)
from raxel.sets.model import ActiveGrid, Chessboard, MonitorChessboard
from raxel.sets.patterns import PatternPlan, plan_of_cells

# A monitor as a light source: pattern value and viewing angle in, radiance out.


@dataclass(frozen=True)
class Monitor:
    """How a monitor turns the value of a pixel into light.

    Attributes
    ----------
    gamma : float
        The radiance between black and white rises as value^gamma.
    black_level : float
        Radiance of value 0 as a share of white.
    falloff_exponent : float
        n of cos^n of the viewing angle.
    white : float
        Radiance of value 1 seen straight on; 1.0 is a white diffuse surface.

    Raises
    ------
    InputError
        Naming the field that no monitor can have.

    Examples
    --------
    >>> from raxel.lab import Monitor
    >>> monitor = Monitor(gamma=2.0, falloff_exponent=1.0)
    >>> print(f"{monitor.radiance(0.5, 1.0):.3f} {monitor.radiance(0.5, 0.5):.3f}")
    0.250 0.125
    """

    gamma: float = 2.2
    black_level: float = 0.0
    falloff_exponent: float = 0.0
    white: float = 1.0

    def __post_init__(self):
        limits = {
            "gamma": (self.gamma > 0, "it must be above 0"),
            "black_level": (0 <= self.black_level < 1, "give a share of white below 1"),
            "falloff_exponent": (self.falloff_exponent >= 0, "it must be 0 or more"),
            "white": (self.white > 0, "it must be above 0"),
        }
        for name, (good, advice) in limits.items():
            if not good:
                found = getattr(self, name)
                raise InputError(f"field '{name}': value is {found}; {advice}")

    def radiance(self, value: ArrayLike, cosine: ArrayLike) -> np.ndarray:
        """Return the radiance of pixels seen under a viewing angle.

        Parameters
        ----------
        value : array_like
            Values of the pixels, 0 to 1.
        cosine : array_like
            Cosine of the viewing angle, of the same shape; from behind (below 0) it
            is dark.
        """
        return self.light(value) * self.falloff(cosine)

    def light(self, value: ArrayLike) -> np.ndarray:
        """Return the radiance, seen straight on, of `value`, an array or a number."""
        value = np.clip(value, 0, 1)
        share = self.black_level + (1 - self.black_level) * value**self.gamma
        return self.white * share

    def falloff(self, cosine: ArrayLike) -> np.ndarray:
        """Return the share of `light` that is left at an angle of this cosine."""
        return (np.asarray(cosine) > 0) * np.maximum(cosine, 0) ** self.falloff_exponent


# A lens that sits on its camera a little to one side. A heavy lens sags: the image on
# the sensor moves when the camera is turned over.


class ShiftedLens(Camera):
    """Represent a camera whose lens has shifted the image by `shift` px on the sensor.

    camera: any Camera; shift: (2,), right and down. Rays are those of `camera`, at
    shifted pixels. It is valid for one view and is never written to disk.
    """

    def __init__(self, camera, shift):
        self.camera, self.shift = camera, checked_array("lens_shift", shift, (2,))
        self.width, self.height = camera.width, camera.height
        self.kind, self.continuous = camera.kind, camera.continuous
        self.projects = camera.projects

    @property
    def central(self):
        """As that of the camera."""
        return self.camera.central

    @property
    def parameters(self):
        """Return those of the camera; a known shift is not a parameter."""
        return self.camera.parameters

    def _rays(self, pixels):
        """Rays of pixels (N, 2)."""
        return self.camera.rays(as_rows(pixels, 2) - self.shift)

    def project(self, points):
        """Pixels of points (N, 3)."""
        pixels, valid = self.camera.project(points)
        return Projection(pixels + self.shift, valid)

    def _fields(self):
        raise InputError(
            f"{self.kind}: cannot be stored (shifted lens); save the camera before it",
            code="moved-lens",
        )

    @classmethod
    def _from_file(cls, file):
        raise InputError(f"{cls.kind}: cannot be stored; save the camera before it")


# Limits that combine several quantities of a rig. The schema bounds each of them alone.
# Here each is compared with the size of the image or target, before it is used.


# Peak memory of one pixel on its way through lens and sensor, per channel.
BYTES_PER_PIXEL = 150
# Blur as a share of the shorter side: a point would spread over a sixth of the image,
# and no target could be detected.
MAX_BLUR_SHARE = 1 / 40
# Distance of the optical centre from the image, in image sizes.
MAX_CENTRE_DISTANCE = 1.0
# px of a square or of a monitor's period.
MIN_SQUARE_PX = 2
# Share of the shorter side.
MAX_SHIFT_SHARE = 0.1
# How often spots may cover the image over and over.
MAX_SPOT_COVERS = 10


def check_memory(camera, sensor):
    """Raise InputError if an image requires more than half of the memory."""
    channels = 3 if "bayer" in sensor else 1
    need = camera.width * camera.height * BYTES_PER_PIXEL * channels
    if need > physical_memory() / 2:
        raise InputError(
            f"field 'camera.width': an image of {camera.width} x {camera.height} px "
            f"needs {need / 1e9:.3g} GB, more than half of this machine's "
            f"{physical_memory() / 1e9:.3g} GB; give fewer pixels"
        )


def check_limits(camera, optics, blemishes, target, poses):
    """Raise InputError, with the section's field, for values that no image can show.

    camera: the rig's; optics: its Optics; blemishes: its Blemishes; target, poses: the
    sections' values by name.
    """
    _check_centre(camera, optics)
    _check_blur(camera, optics)
    _check_blemishes(camera, blemishes)
    if target["kind"] == "chessboard":
        _check_board(camera, target)
    else:
        _check_patterns(target)
    _check_poses(camera, poses)


def _check_centre(camera, optics):
    if optics.centre_px is None:
        return
    for value, size in zip(
        optics.centre_px, (camera.width, camera.height), strict=True
    ):
        if not -MAX_CENTRE_DISTANCE <= value / size <= 1 + MAX_CENTRE_DISTANCE:
            raise InputError(
                f"field 'optics.centre.value': found {list(optics.centre_px)}; give a "
                f"pixel in the image of {_size(camera)} px, or at most its own size "
                "away from it"
            )


def _check_blur(camera, optics):
    maximum = MAX_BLUR_SHARE * min(camera.width, camera.height)
    strongest = optics.strongest_blur_px(camera.width, camera.height)
    if strongest > max(maximum, 1):
        raise InputError(
            f"field 'optics.blur_sd.value': found {list(optics.blur_sd_px)}, up to "
            f"{strongest:.4g} px in the image of {_size(camera)} px; give at most "
            f"{max(maximum, 1):.4g}, a fortieth of its shorter side"
        )


def _check_blemishes(camera, blemishes):
    diagonal = math.hypot(camera.width, camera.height)
    for name in ("spot_radius", "glare_radius", "glare_within"):
        largest = getattr(blemishes, name)[1]
        if largest > diagonal:
            raise InputError(
                f"field 'blemishes.{name}.value': found {largest:g} px in an image of "
                f"{_size(camera)} px; give at most its diagonal"
            )
    area = blemishes.spots * math.pi * blemishes.spot_radius[1] ** 2
    if area > MAX_SPOT_COVERS * camera.width * camera.height:
        raise InputError(
            f"field 'blemishes.spots.value': found {blemishes.spots} of up to "
            f"{blemishes.spot_radius[1]:g} px, which cover an image of {_size(camera)} "
            f"px more than {MAX_SPOT_COVERS} times; give fewer or smaller ones"
        )


def _check_board(camera, target):
    columns, rows = target["columns"], target["rows"]
    if columns * rows * MIN_SQUARE_PX**2 > camera.width * camera.height:
        raise InputError(
            f"field 'target.columns.value': {columns} x {rows} corners have squares of "
            f"less than {MIN_SQUARE_PX} px in an image of {_size(camera)} px; give "
            "fewer"
        )


def _check_patterns(target):
    size = target["monitor_px"]
    for axis, bits, pixels in zip(
        "xy", target.get("gray_bits", (0, 0)), size, strict=True
    ):
        if 2**bits > pixels:
            raise InputError(
                f"field 'target.gray_bits.value': {bits} bits along {axis} make "
                f"{2**bits} cells on {pixels} px of the monitor; give at most "
                f"{int(math.log2(pixels))}"
            )
    _check_monitor_chessboard(target)
    periods = target.get("phase_periods", (0, 0))
    for axis, count, pixels in zip("xy", periods, size, strict=True):
        if count * MIN_SQUARE_PX > pixels:
            raise InputError(
                f"field 'target.phase_periods.value': {count:g} periods along {axis} "
                f"are narrower than {MIN_SQUARE_PX} of the monitor's {pixels} px; give "
                f"at most {pixels // MIN_SQUARE_PX}"
            )


def _check_monitor_chessboard(target):
    board = target.get("chessboard")
    if not board:
        return
    for axis, count, first, pixels in zip(
        "xy",
        (board["columns"], board["rows"]),
        board["origin"],
        target["monitor_px"],
        strict=True,
    ):
        low, high = first - board["pitch"], first + count * board["pitch"]
        if low < 0 or high > pixels:
            raise InputError(
                f"field 'target.chessboard.origin.value': squares from {low:g} to "
                f"{high:g} along {axis} on {pixels} px of the monitor; give a smaller "
                "pitch, or another origin"
            )


def _check_poses(camera, poses):
    side = min(camera.width, camera.height)
    if 2 * poses["margin"] >= side:
        raise InputError(
            f"field 'poses.margin.value': found {poses['margin']:g} px, which leaves "
            f"nothing of an image of {_size(camera)} px; give less than half a side"
        )
    if poses["least_spacing"] > side:
        raise InputError(
            f"field 'poses.least_spacing.value': found {poses['least_spacing']:g} px "
            f"in an image of {_size(camera)} px; give less than its shorter side"
        )
    for index, entry in enumerate(poses.get("list", ())):
        if math.hypot(*entry.get("lens_shift", (0, 0))) > MAX_SHIFT_SHARE * side:
            raise InputError(
                f"field 'poses.list[{index}].lens_shift.value': found "
                f"{list(entry['lens_shift'])} px in an image of {_size(camera)} px; "
                f"give at most {MAX_SHIFT_SHARE * side:g}, a tenth of its shorter side"
            )
    axis = poses.get("axis", (0, 0, 1))
    if math.hypot(*axis) < 1e-6:
        raise InputError(
            f"field 'poses.axis.value': found {list(axis)}, which is no direction; "
            "give one such as [0, 0, 1]"
        )


def _size(camera):
    return f"{camera.width} x {camera.height}"


# Camera of a rig file: units, viewers, and poses of mirrors.


# Units of camera fields. Other fields are pure numbers, or coefficients and poses whose
# entries have several units; the file gives "1" for either.
CAMERA_UNITS = {
    **dict.fromkeys(("width", "height", "K", "principal_point", "centre"), "px"),
    **dict.fromkeys(("focal_px", "pixels_per_unit"), "px"),
    **dict.fromkeys(("principal_column", "reference_row"), "px"),
    **dict.fromkeys(("axes", "rim_radius", "hole_radius", "offset"), "mm"),
    **dict.fromkeys(("slit_points", "image_distance", "pupil_shift"), "mm"),
    **dict.fromkeys(("velocity", "outlines"), "mm"),
    **dict.fromkeys(("size", "heights", "distance"), "mm"),
    **dict.fromkeys(("ball_radius", "facet_size", "gap"), "mm"),
    **dict.fromkeys(("loads", "deflections", "aberration", "wavelengths"), "mm"),
    **dict.fromkeys(("strain", "strain_reach", "holder"), "mm"),
    **dict.fromkeys(("max_angle", "rotation", "cap", "tilt_sd", "angle"), "deg"),
    "rulings": "deg",
    "pixels_per_mm": "px/mm",
}
# A mirror without T_viewer_mirror is at its viewer's focus, moved and rotated.
MIRROR = QuadricMirrorCamera.kind
MIRROR_FIELDS = (
    *("viewer", "shape", "axes", "rim_radius"),
    *("offset", "rotation", "distance", "side", "hole_radius", "T_viewer_mirror"),
)
# Several flat mirrors form a ball, unless each has a pose.
FACETS = PlanarMirrorsCamera.kind
BALL_FIELDS = ("viewer", *argument_names(ball_facets)[0])
BALL_REQUIRED = ("viewer", *argument_names(ball_facets)[1])


def rig_camera(path, data, field="camera"):
    """The camera of a section; complaints of its class get file and field."""
    if field.count(".") > MAX_NESTING_DEPTH:
        raise InputError(
            f"{path}: {field}: camera nested in {MAX_NESTING_DEPTH} others; "
            "use fewer levels"
        )
    fields = {}
    for name, entry in data.items():
        if name == "kind":
            continue
        if isinstance(entry, str):
            fields[name] = entry
        elif "kind" in entry:
            fields[name] = rig_camera(path, entry, f"{field}.{name}")
        elif name in _camera_fields(data["kind"]):
            fields[name] = _camera_value(path, f"{field}.{name}", name, entry)
        else:
            # The camera's own refusal knows the names.
            fields[name] = entry["value"]
    try:
        if data["kind"] == MIRROR and "T_viewer_mirror" not in fields:
            return _placed_mirror(fields)
        if data["kind"] == FACETS and "T_viewer_facets" not in fields:
            return _mirror_ball(fields)
        return camera_from(data["kind"], fields)
    except InputError as fault:
        raise InputError(named(path, field, fault)) from fault


def _camera_fields(kind):
    if kind == MIRROR:
        return MIRROR_FIELDS
    if kind == FACETS:
        return (*BALL_FIELDS, *argument_names(PlanarMirrorsCamera)[0])
    return argument_names(CAMERAS[kind])[0] if kind in CAMERAS else ()


def _camera_value(path, field, name, leaf):
    """The leaf's value, radians for an angle, after a check of its unit."""
    unit = CAMERA_UNITS.get(name, "1")
    if leaf["unit"] != unit:
        raise InputError(
            f"{path}: {field}.unit: found {leaf['unit']!r}; give {unit!r}, the unit of "
            "this field"
        )
    if unit != "deg":
        return leaf["value"]
    try:
        return np.radians(np.array(leaf["value"], float))[()]
    except (TypeError, ValueError, OverflowError) as fault:
        raise InputError(
            f"{path}: {field}.value: not a number; give degrees, or a list of them"
        ) from fault


def _placed_mirror(fields):
    """Return a mirror at its viewer's focus, moved by `offset`, rotated by `rotation`.

    Or with its apex at a `distance` in front, which only makes a camera of a sphere.
    """
    needed = ("viewer", "shape", "axes", "rim_radius")
    _check_names(fields, MIRROR_FIELDS, needed, "a quadric mirror")
    fields = with_nested(fields)
    if "distance" in fields:
        return QuadricMirrorCamera.on_axis(**fields)
    return QuadricMirrorCamera.misaligned(**{"offset": (0, 0, 0)} | fields)


def _mirror_ball(fields):
    """A ball of facets at a `distance` ahead of its viewer."""
    _check_names(fields, BALL_FIELDS, BALL_REQUIRED, "a mirror ball")
    return PlanarMirrorsCamera.on_ball(**with_nested(fields))


def _check_names(fields, known, needed, what):
    for name in fields:
        if name not in known:
            listed = f"known are {', '.join(known)}"
            advice = did_you_mean(name, known) or listed
            raise InputError(f"field '{name}': unknown key; {advice}")
    for name in needed:
        if name not in fields:
            raise InputError(f"field '{name}': missing; add it ({what} requires it)")


def named(path, section, fault):
    """Return the fault of a section with file and field; section None: the rig."""
    names, text = [section] if section else [], str(fault)
    while match := re.match(r"field '([^']+)': ", text):
        names, text = [*names, match[1]], text[match.end() :]
    return f"{path}: {'.'.join(names)}: {text}"


# The target of a rig and its poses, from the values in the rig's file.


RADIANCES = {
    "chessboard": {"black": 0.05, "white": 0.9, "background": 0.4},
    "active_grid": {"background": 0.05},
}
PLAN = ("gray_bits", "gray_inverse", "phase_steps", "phase_periods", "cell_px")


def read_chessboard(values):
    """The Chessboard of a section `target`."""
    return Chessboard(values["columns"], values["rows"], float(values["pitch"]))


def read_active_grid(values):
    """The ActiveGrid of a section `target`, with the chessboard that it shows."""
    board = values.get("chessboard")
    if board:
        origin = tuple(map(float, board["origin"]))
        counts = board["columns"], board["rows"]
        board = MonitorChessboard(*counts, float(board["pitch"]), origin)
    size_mm = tuple(map(float, values["monitor_mm"]))
    return ActiveGrid(values["monitor_px"], size_mm, board)


def read_monitor(values):
    """The Monitor of a section `target`. Raises InputError as Monitor does."""
    names = ("gamma", "black_level", "falloff_exponent", "white")
    return Monitor(**{name: values[name] for name in names if name in values})


def read_radiances(values):
    """Keyword arguments of the ready-made scene."""
    usual = RADIANCES[values["kind"]]
    return {name: values.get(name, value) for name, value in usual.items()}


def pattern_plan(values):
    """Return the PatternPlan of `cells`, or of separate bits and periods.

    Raises InputError if both are given, or no pattern.
    """
    given = {name: values[name] for name in PLAN if name in values}
    if "cells" not in values:
        plan = PatternPlan(**given)
        if not any(plan.gray_bits) and not any(plan.phase_periods):
            raise InputError(
                "field 'gray_bits': no patterns; give gray_bits or "
                "phase_periods, or cells"
            )
        return plan
    steps = given.pop("phase_steps", PatternPlan.phase_steps)
    if given:
        raise InputError(
            f"field '{next(iter(given))}': redundant with cells; give one of the two"
        )
    return plan_of_cells(values["monitor_px"], values["cells"], steps)


def read_poses(values):
    """Return (DrawnPoses, AroundPoses or ListedPoses, number of calibration views).

    Raises InputError for reversed ranges, repeated names, and a list without a
    calibration view.
    """
    if values["kind"] == "listed":
        return _listed(values)
    around = values["kind"] == "around"
    names = ("polar", "subtense") if around else ("distance", "off_axis")
    ranges = {}
    for name in (*names, "tilt", "turn"):
        low, high = values[name]
        if low > high:
            raise InputError(
                f"field '{name}.value': found [{low}, {high}]; give the least first, "
                "then the greatest"
            )
        ranges[name] = (low, high) if name == "distance" else np.radians((low, high))
    if around:
        place = AroundPoses(values["centre"], values["axis"], **ranges)
        return place, values["count"]
    distance = ranges.pop("distance")
    return DrawnPoses(distance, **ranges), values["count"]


def _listed(values):
    entries = values["list"]
    vectors = np.radians([entry["rotation"] for entry in entries])
    shifts = np.array([entry["translation"] for entry in entries], float)
    evaluate = values.get("evaluate", 0)
    if evaluate >= len(shifts):
        raise InputError(
            f"field 'evaluate.value': found {evaluate} of {len(shifts)} poses; leave "
            "some to calibrate with"
        )
    names = tuple(entry.get("name") for entry in entries)
    for index, name in enumerate(names):
        if name and name in names[:index]:
            raise InputError(
                f"field 'list[{index}].name': found {name!r}, which "
                f"list[{names.index(name)}] has already; give each its own"
            )
    by_hand = values.get("set_up", {"shift": 0, "turn": 0})
    listed = ListedPoses(
        pose(rotation_from_vector(vectors), shifts),
        names,
        tuple(entry.get("patterns_only", False) for entry in entries),
        tuple(entry.get("lens_shift", (0, 0)) for entry in entries),
        float(by_hand["shift"]),
        float(np.radians(by_hand["turn"])),
    )
    return listed, len(shifts) - evaluate


# A camera with its lens and sensor: the physical order of imaging.
# Scene radiance; blur, vignetting and chromatic aberration of the lens; charge with
# its shot noise, saturation and blooming; read noise; tone curve; rounding.


# Subpixels per sensor pixel along each axis where the lens blurs: with two, corners of
# a chessboard are as accurate as with four.
SUBPIXELS = 2


@dataclass(frozen=True)
class Laboratory:
    """A camera with its lens and sensor, which takes images of scenes.

    Attributes
    ----------
    camera : Camera
        Any camera with rays.
    sensor : Sensor
        Turns light into the numbers of a file.
    optics : Optics
        Vignetting, blur and chromatic aberration of the lens.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.cameras import PerspectiveCamera
    >>> from raxel.lab import Laboratory, Sensor, TexturedScene
    >>> K = [[50, 0, 15.5], [0, 50, 11.5], [0, 0, 1]]
    >>> camera = PerspectiveCamera(K, [], 32, 24)
    >>> laboratory = Laboratory(camera, Sensor(white_e=1e4, full_well_e=1e4))
    >>> scene = TexturedScene((), background=0.5)
    >>> image = laboratory.render(scene, np.eye(4), np.random.default_rng(0))
    >>> image.shape, image.dtype.name
    ((24, 32), 'uint8')
    """

    camera: Camera
    sensor: Sensor
    optics: Optics = field(default_factory=Optics)

    def render(
        self,
        scene: TexturedScene,
        T_world_camera: ArrayLike,
        rng: np.random.Generator,
        *,
        colour: bool = False,
    ) -> np.ndarray:
        """Return an image of the scene as the camera saves it.

        Behind a mosaic the scene is always taken in colour.

        Parameters
        ----------
        scene : TexturedScene
            Surfaces and background.
        T_world_camera : (4, 4) array_like
            Pose of the camera in the world, mm.
        rng : numpy.random.Generator
            Used for noise alone.
        colour : bool
            Whether to return red, green and blue.

        Returns
        -------
        (H, W) or (H, W, 3) uint8 or uint16 array
            The image.

        Raises
        ------
        InputError
            For an image too large for the memory.
        """
        coloured = colour or self.sensor.bayer is not None
        irradiance = self.irradiance(scene, T_world_camera, colour=coloured)
        return self.sensor.expose(irradiance, rng, colour=colour)

    def irradiance(
        self,
        scene: TexturedScene,
        T_world_camera: ArrayLike,
        *,
        colour: bool = False,
        window: Crop | None = None,
    ) -> NDArray[np.float32]:
        """Return the light on the sensor, or on a part of it.

        Parameters
        ----------
        scene : TexturedScene
            Surfaces and background.
        T_world_camera : (4, 4) array_like
            Pose of the camera in the world, mm.
        colour : bool
            Whether to return red, green and blue.
        window : Crop or None
            Part of the sensor; None: all of it.

        Returns
        -------
        (H, W) or (H, W, 3) float32 array
            Irradiance.

        Raises
        ------
        InputError
            For an image too large for the memory.
        """
        fineness = SUBPIXELS if max(self.optics.blur_sd_px) > 0 else 1
        radiance = render(
            self.camera,
            T_world_camera,
            scene,
            colour=colour,
            fineness=fineness,
            window=window,
        )
        return self.optics.apply(radiance, fineness, window)

    def develop(
        self,
        radiance: np.ndarray,
        rng: np.random.Generator,
        *,
        colour: bool = False,
        fineness: int = 1,
    ) -> np.ndarray:
        """Return the image that radiance leaves in the file.

        Parameters
        ----------
        radiance : (H, W) or (H, W, 3) array
            Linear radiance, with `fineness` times as many pixels each way as the
            sensor.
        rng : numpy.random.Generator
            Draws the noise.
        colour : bool
            Whether to return red, green and blue.
        fineness : int
            As in `Optics.apply`.

        Returns
        -------
        (H, W) or (H, W, 3) uint8 or uint16 array
            The image.
        """
        if self.sensor.bayer is not None and radiance.ndim == 2:
            radiance = np.repeat(radiance[..., None], 3, axis=-1)
        irradiance = self.optics.apply(radiance, fineness)
        return self.sensor.expose(irradiance, rng, colour=colour)


SCHEMA = Path(__file__).with_name("rig.schema.json")
# A monitor counts as visible if so many lines along each axis keep their distance.
MONITOR_LINES = 9


@dataclass(frozen=True, eq=False)
class Rig:
    """A rig: camera, lens, sensor, target and poses. Lengths in mm, angles in radians.

    Attributes
    ----------
    path : Path
        The rig file.
    name, summary : str
        As in the file.
    camera : Camera
        Its model.
    optics : Optics
        Its lens.
    light, blemishes : Lighting, Blemishes
        Of a chessboard's images.
    sensor : Sensor
        Turns light into the numbers of a file.
    target : Chessboard or ActiveGrid
        What the images show.
    border_mm : float
        White margin around a chessboard's squares, 0 for a monitor.
    radiances : dict
        Keyword arguments of the ready-made scene.
    monitor, patterns : Monitor, PatternPlan or None
        None for a chessboard.
    poses : DrawnPoses, AroundPoses or ListedPoses
        Distribution or list of T_camera_target.
    visibility : Visibility
        Conditions that each pose must meet.
    count, evaluate : int
        Views of a rendered set, and how many more of them are held out for evaluation.
    """

    path: Path
    name: str
    summary: str
    camera: Camera
    optics: Optics
    light: Lighting
    blemishes: Blemishes
    sensor: Sensor
    target: Chessboard | ActiveGrid
    border_mm: float
    radiances: dict
    monitor: Monitor | None
    patterns: PatternPlan | None
    poses: DrawnPoses | AroundPoses | ListedPoses
    visibility: Visibility
    count: int
    evaluate: int

    def laboratory(self) -> Laboratory:
        """Return the Laboratory with this rig's camera, lens and sensor."""
        return Laboratory(self.camera, self.sensor, self.optics)

    @property
    def extent(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return corner (2,) and size (2,) of the whole target in its plane, mm."""
        if isinstance(self.target, ActiveGrid):
            return np.zeros(2), np.array(self.target.monitor_mm)
        margin = self.target.pitch_mm + self.border_mm  # type: ignore[operator]
        squares = np.array([self.target.columns, self.target.rows]) - 1
        return np.full(2, -margin), self.target.pitch_mm * squares + 2 * margin

    def draw_poses(self, rng: np.random.Generator, count: int) -> NDArray[np.float64]:
        """Return poses of the target, each with the whole target in view.

        Parameters
        ----------
        rng : numpy.random.Generator
            Draws the poses; a list of poses uses it for errors of the set-up alone.
        count : int
            Number of poses.

        Returns
        -------
        (count, 4, 4) array
            T_camera_target, mm.

        Raises
        ------
        InputError
            With the count of tries and the reasons where no such poses are found.
        """
        try:
            return self.poses.draw(rng, count, self.extent, self._fault)
        except InputError as fault:
            raise InputError(named(self.path, "poses", fault)) from fault

    def view_name(self, index: int) -> str:
        """Return the name of the view of a monitor's pose of this number."""
        names = getattr(self.poses, "names", ())
        return (names[index] if index < len(names) else None) or f"pose-{index:03d}"

    def shows_chessboard(self, index: int) -> bool:
        """Return whether a monitor shows its chessboard at the pose of this number."""
        excluded = getattr(self.poses, "patterns_only", ())[index : index + 1]
        return bool(self.target.chessboard) and not any(excluded)  # type: ignore[union-attr]

    def at_view(self, index: int) -> Rig:
        """Return the rig in the view of this number, its lens shifted on the sensor."""
        shifts = getattr(self.poses, "lens_shifts", ())
        if not any(map(any, shifts[index : index + 1])):
            return self
        return replace(self, camera=ShiftedLens(self.camera, shifts[index]))

    def shows(self, T_camera_target: NDArray[np.float64]) -> bool:
        """Return whether a pose (4, 4) shows the target, as `draw_poses` requires."""
        return not self._fault(T_camera_target)

    def _fault(self, T):
        corner, size = self.extent
        return self.visibility.fault(
            self.camera, T, outline_of(corner, size), self._lattice()
        )

    def _lattice(self):
        if isinstance(self.target, Chessboard):
            shape = self.target.rows, self.target.columns, 2
            return self.target.points().reshape(shape)
        corner, size = self.extent
        share = np.linspace(0, 1, MONITOR_LINES)
        return corner + np.stack(np.meshgrid(share, share), axis=-1) * size


def load_rig(path: str | Path) -> Rig:
    """Return the rig in a YAML file.

    Parameters
    ----------
    path : str or Path
        The rig file.

    Returns
    -------
    Rig
        Its camera, lens, sensor, target and poses.

    Raises
    ------
    InputError
        One line with file and field: for a file that cannot be read, unknown keys (with
        the nearest known one), and wrong units. Also for numbers that no camera, lens,
        sensor or target can have.
    """
    path = Path(path)
    data = read_yaml(path)
    validate(data, path, SCHEMA)
    camera = rig_camera(path, data["camera"])
    _built(path, None, lambda sensor: check_memory(camera, sensor), data["sensor"])
    plain = {key: _values(data.get(key, {})) for key in ("sensor", "target", "poses")}
    target, sensor = plain["target"], plain["sensor"]
    poses, count = _built(path, "poses", read_poses, plain["poses"])
    is_board = target["kind"] == "chessboard"
    _check_monitor_is_plain(path, data, is_board)
    _check_board_is_whole(path, camera, is_board)
    optics = _built(path, "optics", _optics, _values(data.get("optics", {})))
    blemishes = _ranges(path, data, "blemishes", Blemishes)
    _built(
        path,
        None,
        lambda target: check_limits(camera, optics, blemishes, target, plain["poses"]),
        target,
    )
    return Rig(
        path=path,
        name=data["name"],
        summary=data.get("summary", ""),
        camera=camera,
        optics=optics,
        light=_ranges(path, data, "light", Lighting),
        blemishes=blemishes,
        sensor=_built(path, "sensor", _sensor, sensor),
        target=read_chessboard(target) if is_board else read_active_grid(target),
        border_mm=float(target["border"]) if is_board else 0.0,
        radiances=read_radiances(target),
        monitor=None if is_board else _built(path, "target", read_monitor, target),
        patterns=None if is_board else _built(path, "target", pattern_plan, target),
        poses=poses,
        visibility=Visibility(
            plain["poses"]["margin"],
            plain["poses"]["least_spacing"],
            plain["poses"].get("whole", True),
        ),
        count=count,
        evaluate=plain["poses"].get("evaluate", 0),
    )


def _values(data):
    """A section with each leaf replaced by its value, lists by tuples."""
    if isinstance(data, dict):
        if "value" in data and "unit" in data:
            return _tuples(data["value"])
        return {key: _values(part) for key, part in data.items()}
    return [_values(part) for part in data] if isinstance(data, list) else data


def _tuples(value):
    """Return lists as tuples, and 4.0 as an integer, as the schema does."""
    if isinstance(value, list):
        return tuple(map(_tuples, value))
    whole = isinstance(value, float) and value.is_integer()
    return int(value) if whole else value


def _optics(values):
    falloff = values.get("falloff")
    return Optics(
        blur_sd_px=values.get("blur_sd", (0.0, 0.0)),
        exit_pupil_px=values.get("exit_pupil"),
        falloff=falloff and (falloff["radius"], falloff["light"]),
        chromatic_scale=values.get("chromatic_scale", (1.0, 1.0, 1.0)),
        centre_px=values.get("centre"),
    )


def _ranges(path, data, section, kind):
    """Lighting or Blemishes, whose arguments are the section's fields by name."""
    values = _values(data.get(section, {}))
    return _built(path, section, lambda fields: kind(**fields), values)


def _check_monitor_is_plain(path, data, is_board):
    for section in ("light", "blemishes"):
        if section in data and not is_board:
            raise InputError(
                f"{path}: {section}: found with an active grid; only images of a "
                "chessboard have it"
            )


def _check_board_is_whole(path, camera, is_board):
    if is_board and not camera.continuous:
        raise InputError(
            f"{path}: target.kind: found a chessboard before a {camera.kind} camera, "
            "which may see a corner twice or not at all; give an active_grid"
        )


def _sensor(values):
    if "gamma" in values and "response" in values:
        raise InputError("field 'response': redundant with gamma; give one of the two")
    response = values.get("response")
    return Sensor(
        white_e=values["white"],
        full_well_e=values["full_well"],
        read_noise_e=values.get("read_noise", 0.0),
        blooming=values.get("blooming", 0.0),
        gamma=values.get("gamma", 1.0),
        response=response and (response["charge"], response["value"]),
        black_level=values.get("black_level", 0.0),
        bits=values["bits"],
        bayer=values.get("bayer"),
        jpeg=values.get("jpeg"),
    )


def _built(path, section, build, values):
    try:
        return build(values)
    except InputError as fault:
        raise InputError(named(path, section, fault)) from fault
