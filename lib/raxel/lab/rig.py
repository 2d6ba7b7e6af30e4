"""A rig: camera, lens, sensor, target and poses, read from one file.

Every quantity in the file is {value, unit, origin, reason}; the schema beside this
module says which fields there are and in which unit.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from raxel.cameras.core.base import Camera
from raxel.errors import InputError
from raxel.io.documents import read_yaml, validate
from raxel.lab.blemishes import Blemishes
from raxel.lab.laboratory import Laboratory
from raxel.lab.lens_shift import ShiftedLens
from raxel.lab.lighting import Lighting
from raxel.lab.monitor import Monitor
from raxel.lab.optics import Optics
from raxel.lab.rig_camera import named, rig_camera
from raxel.lab.rig_limits import check_limits, check_memory
from raxel.lab.rig_target import (
    pattern_plan,
    read_active_grid,
    read_chessboard,
    read_monitor,
    read_poses,
    read_radiances,
)
from raxel.lab.sensor import Sensor
from raxel.lab.target_poses import (
    AroundPoses,
    DrawnPoses,
    ListedPoses,
    Visibility,
    outline_of,
)
from raxel.sets.model import ActiveGrid, Chessboard
from raxel.sets.patterns import PatternPlan

SCHEMA = Path(__file__).with_name("rig.schema.json")
# A monitor is taken as seen where this many lines each way keep their distance.
MONITOR_LINES = 9


@dataclass(frozen=True, eq=False)
class Rig:
    """What a rig file says. Lengths in mm, pixels, angles in radians.

    border_mm: white margin around a chessboard's squares, 0 for a monitor; light,
    blemishes: of a chessboard's pictures; radiances: keyword arguments of the
    ready-made scene; monitor and patterns: None for a
    chessboard; count, evaluate: views of a rendered set, and how many more of them
    are kept for evaluation.
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

    def laboratory(self):
        """The Laboratory with this rig's camera, lens and sensor."""
        return Laboratory(self.camera, self.sensor, self.optics)

    @property
    def extent(self):
        """(corner (2,), size (2,)) of the whole target in its plane, mm."""
        if isinstance(self.target, ActiveGrid):
            return np.zeros(2), np.array(self.target.monitor_mm)
        margin = self.target.pitch_mm + self.border_mm
        squares = np.array([self.target.columns, self.target.rows]) - 1
        return np.full(2, -margin), self.target.pitch_mm * squares + 2 * margin

    def draw_poses(self, rng, count):
        """T_camera_target (count, 4, 4), each with the whole target in view.

        rng: numpy Generator; a list of poses does not use it. Raises InputError with
        the count of tries and the reasons where no such poses come up.
        """
        try:
            return self.poses.draw(rng, count, self.extent, self._fault)
        except InputError as fault:
            raise InputError(named(self.path, "poses", fault)) from fault

    def view_name(self, index):
        """What the view of a monitor's pose of this number is called."""
        names = getattr(self.poses, "names", ())
        return (names[index] if index < len(names) else None) or f"pose-{index:03d}"

    def shows_chessboard(self, index):
        """Whether a monitor shows its chessboard at the pose of this number."""
        left_out = getattr(self.poses, "patterns_only", ())
        return bool(self.target.chessboard) and not any(left_out[index : index + 1])

    def at_view(self, index):
        """The rig as it is in the view of this number, its lens moved on the sensor."""
        shifts = getattr(self.poses, "lens_shifts", ())
        if not any(map(any, shifts[index : index + 1])):
            return self
        return replace(self, camera=ShiftedLens(self.camera, shifts[index]))

    def shows(self, T_camera_target):
        """Whether a pose (4, 4) has the whole target in view, as `draw_poses` asks."""
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


def load_rig(path):
    """The rig in a YAML file.

    Raises InputError, one line with file and field, for a file that cannot be read,
    unknown keys (with the nearest known one), wrong units, and numbers that no camera,
    lens, sensor or target can have.
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
    """Lists as tuples, and 4.0 as the whole number that the schema takes it for."""
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
                f"{path}: {section}: found with an active grid; only pictures of a "
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
        raise InputError("field 'response': found beside gamma; give one of the two")
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
