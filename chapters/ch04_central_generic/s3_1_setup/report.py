"""Results of this page read: values of the prose, figures, tables."""

from itertools import product

import numpy as np

from chapters.shared.central import FISH, LINEAR_GRIDS, OMNI, RIGS
from chapters.shared.methods import LINEAR_NAMES
from chapters.shared.rigs import rig_named
from raxel.show import (
    Labels,
    Polyline,
    drawn_poses,
    field_of_view,
    framed,
    frustum,
    mirrors,
    plate,
)
from raxel.show import axes as axes_parts
from repro.page import INK, series, value
from repro.page.space import scene_figure
from repro.run import (
    Check,
    Drawing,
    Measured,
    Table,
    Value,
    columns,
    figure,
    numbers,
    table,
)

# Results of section 4.3.1, and the numbers of the text.


CAMERAS = {"omni": OMNI, "fish": FISH}
# The camera for grids 2 and 3: name in the trials -> words.
ORIENTATIONS = {"upright": "upright", "turned": "inverted"}


def name_values(open_results):
    """Name the numbers that the text quotes: medians over the runs."""
    by_camera = open_results("sec_4_3_1_turned").by("camera")
    for name, short, key in (
        *product(ORIENTATIONS, CAMERAS, ["centre_off_mm"]),
        *product(ORIENTATIONS, ["omni"], ["ray_mean_mm"]),
    ):
        found = by_camera[CAMERAS[short]].column(name, "cgsp", key)
        value(f"{short}.{name}.cgsp.{key}", np.median(found))


# Fig. 4.5: the camera, its mirror and three grids.


GRIDS = tuple(series(k)["color"] for k in (0, 1, 2))
# The mirror above its camera, as in the room, and both in front of the grids.
SIGHT = (0.8, -0.5, -0.4)


@figure("fig_4_5", needs=(), evidence="analytic", scene=True)
def fig_4_5(results):
    """Draw the camera below its mirror, and the three grids of the linear stage."""
    rig = rig_named("onevr-d70")
    poses = drawn_poses(rig, 0)[:LINEAR_GRIDS]
    corner, size = rig.extent
    parts = setup_parts(rig.camera, poses, corner, size)
    scene = framed(parts, SIGHT, up=(0.0, 0.0, 1.0), note=rig.summary)
    middles = poses[:, :3] @ [*(corner + size / 2), 0, 1]
    data = {"grid": list(range(1, len(poses) + 1))} | {
        f"{axis}_mm": middles[:, k].tolist() for k, axis in enumerate("xyz")
    }
    in_view = sum(bool(rig.shows(T)) for T in poses)
    return Drawing(
        scene_figure(scene, height_in=4.6),
        data,
        "The omnidirectional camera (rig onevr-d70) and three grids in the camera "
        "frame: the z axis points from the camera to the mirror (in the room: up). "
        "Sheets 1 to 3: successive positions of one monitor for the linear stage, "
        "which may therefore cross. Light blue: edge of the field of view. The "
        "bracket, which misaligns the mirror by 1 mm, is not drawn.",
        Check(in_view == len(poses), f"{in_view} of {len(poses)} grids are in view"),
        scene,
    )


def setup_parts(camera, poses, corner, size):
    """Return camera, mirror and numbered monitor sheets in the camera frame.

    poses: T_camera_grid (n, 4, 4); corner, size: (2,) of the monitor in its plane, mm.
    """
    parts = [*field_of_view(camera, 110.0), *mirrors(camera, opacity=1.0)]
    parts += [frustum(camera.viewer, 25.0), *axes_parts(50.0)]
    for number, (T, colour) in enumerate(zip(poses, GRIDS, strict=True), 1):
        name = f"grid {number}"
        sheet = plate(T, corner, size, colour=colour, opacity=0.4, label=name)
        rim = sheet.points[[0, 0, 1, 1, 0], [0, 1, 1, 0, 0]]
        label = Labels(rim[:1], [str(number)], INK, size=16.0)
        parts += [sheet, Polyline(rim, colour, name, 2.5), label]
    return parts


# Effect of a lens shift on a calibration, and the numbers of section 4.3.1.


FITTED = "grids and lens shift of the rig are chosen to give the printed value"


@table("ext_lens_shift", needs=("sec_4_3_1_turned",), evidence="rendered")
def ext_lens_shift(results):
    """Tabulate three methods on upright sets and on sets of an inverted camera."""
    by_camera = results["sec_4_3_1_turned"].by("camera")
    heads = {
        "ray_mean_mm": "Ray-point error (mm)",
        "ba_mean_mm": "after BA (mm)",
        "centre_off_mm": "Centre error (mm)",
    }
    rows = [
        (
            camera,
            name,
            words,
            *map(Measured.median, by_camera[camera].column(how, method, tuple(heads))),
        )
        for camera in CAMERAS.values()
        for method, name in LINEAR_NAMES.items()
        for how, words in ORIENTATIONS.items()
    ]
    return Table(
        columns(("Camera", "Method", "Grids 2, 3", *heads.values()), rows),
        "Ray-point errors before and after bundle adjustment (BA), and errors of the "
        "centre, of calibrations from three grids. The camera is upright or inverted "
        "for grids 2 and 3. Median and range over the runs, images of reduced size, "
        "low-noise level.",
    )


@numbers(
    "sec_4_3_1", needs=("sec_4_3_1_field", "sec_4_3_1_turned"), evidence="rendered"
)
def numbers_of_section(results):
    """Return calibrated fields, numbers of grids, and lens shifts."""
    rigs = {camera: rig_named(name) for camera, name in RIGS.items()}
    fields, turned = (
        results[name].by("camera") for name in ("sec_4_3_1_field", "sec_4_3_1_turned")
    )
    found = {
        "s4_3_1_omni_h": (fields[OMNI].column("horizontal_deg"), "deg"),
        "s4_3_1_omni_v": (fields[OMNI].column("vertical_deg"), "deg"),
        "s4_3_1_fish": (100 * fields[FISH].column("share"), "%"),
        "s4_3_1_d70_shift": (turned[OMNI].column("shift_2_px"), "px"),
        "s4_3_1_cp_shift": (turned[FISH].column("shift_2_px"), "px"),
    }
    sizes = {
        f"s4_3_1_{name}_size": Value(f"{camera.width}x{camera.height}", unit="px")
        for name, camera in (("d70", rigs[OMNI].camera), ("cp", rigs[FISH].camera))
    }
    angle = float(np.degrees(rigs[FISH].camera.max_angle))
    return sizes | {
        **{name: Value.of_seeds(*one, put_in=FITTED) for name, one in found.items()},
        "s4_3_1_fish_fov": Value(round(2 * angle, 6), unit="deg"),
        "s4_3_1_lin": Value(LINEAR_GRIDS, unit="count"),
        "s4_3_1_omni_extra": Value(rigs[OMNI].count - LINEAR_GRIDS, unit="count"),
        "s4_3_1_fish_extra": Value(rigs[FISH].count - LINEAR_GRIDS, unit="count"),
    }
