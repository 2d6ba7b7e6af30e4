"""The camera of a rig file: units, viewers, and mirrors put in their places."""

import re

import numpy as np

from raxel.cameras.core.storage import DEEPEST, argument_names
from raxel.cameras.mirrors.bent import ball_facets
from raxel.cameras.mirrors.planar import PlanarMirrorsCamera
from raxel.cameras.mirrors.quadric import QuadricMirrorCamera
from raxel.cameras.registry import CAMERAS, camera_from, with_nested
from raxel.errors import InputError, did_you_mean

# Units of camera fields. Those not named here are pure numbers, or coefficients and
# poses whose entries have several units; the file gives "1" for either.
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
# A mirror without T_viewer_mirror stands at its viewer's focus, moved and turned.
MIRROR = QuadricMirrorCamera.kind
MIRROR_FIELDS = (
    *("viewer", "shape", "axes", "rim_radius"),
    *("offset", "rotation", "distance", "side", "hole_radius", "T_viewer_mirror"),
)
# Many flat mirrors are those of a ball, unless each has a pose of its own.
FACETS = PlanarMirrorsCamera.kind
BALL_FIELDS = ("viewer", *argument_names(ball_facets)[0])
BALL_NEEDS = ("viewer", *argument_names(ball_facets)[1])


def rig_camera(path, data, field="camera"):
    """The camera of a section; complaints of its class get file and field."""
    if field.count(".") > DEEPEST:
        raise InputError(
            f"{path}: {field}: a camera in {DEEPEST} others; give one nested less "
            "deeply"
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
            f"{path}: {field}.value: no number; give degrees, or a list of them"
        ) from fault


def _placed_mirror(fields):
    """A mirror at its viewer's focus, moved by `offset` and turned by `rotation`.

    Or with its apex at a `distance` ahead, which only makes a sphere's camera.
    """
    needed = ("viewer", "shape", "axes", "rim_radius")
    _check_names(fields, MIRROR_FIELDS, needed, "a quadric mirror")
    fields = with_nested(fields)
    if "distance" in fields:
        return QuadricMirrorCamera.on_axis(**fields)
    return QuadricMirrorCamera.misaligned(**{"offset": (0, 0, 0)} | fields)


def _mirror_ball(fields):
    """A ball of facets at a `distance` ahead of its viewer."""
    _check_names(fields, BALL_FIELDS, BALL_NEEDS, "a mirror ball")
    return PlanarMirrorsCamera.on_ball(**with_nested(fields))


def _check_names(fields, known, needed, what):
    for name in fields:
        if name not in known:
            listed = f"known are {', '.join(known)}"
            advice = did_you_mean(name, known) or listed
            raise InputError(f"field '{name}': unknown key; {advice}")
    for name in needed:
        if name not in fields:
            raise InputError(f"field '{name}': missing; {what} needs it")


def named(path, section, fault):
    """The fault of a section with file and field in front; section None: the rig."""
    names, text = [section] if section else [], str(fault)
    while match := re.match(r"field '([^']+)': ", text):
        names, text = [*names, match[1]], text[match.end() :]
    return f"{path}: {'.'.join(names)}: {text}"
