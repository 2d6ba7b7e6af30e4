"""Results of this page read: values of the prose, figures, tables."""

import numpy as np

from chapters.shared.central import FISH, LINEAR_GRIDS, OMNI, RIGS
from chapters.shared.methods import LINEAR_NAMES
from chapters.shared.rigs import rig_named
from raxel.show import Labels, Polyline, framed
from raxel.show.boards import plate
from raxel.show.cameras import axes as axes_parts
from raxel.show.cameras import field_of_view, frustum, mirrors
from raxel.show.rigs import drawn_poses
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


FIELD = "sec_4_3_1_field"
TURNED = "sec_4_3_1_turned"
CAMERAS = {"omni": OMNI, "fish": FISH}
SETS = ("upright", "turned")  # the camera for grids 2 and 3


def seeds_of(result, camera, key):
    """Return a value of each run of a camera, (runs,)."""
    return result.select(camera=camera).column(key)


def name_values(open_results):
    """Name the numbers that the text quotes: medians over the runs."""
    turned = open_results(TURNED)
    for short, camera in CAMERAS.items():
        for name in SETS:
            key = f"{name}.cgsp.centre_off_mm"
            value(f"{short}.{key}", np.median(seeds_of(turned, camera, key)))
    for name in SETS:
        key = f"{name}.cgsp.ray_mean_mm"
        value(f"omni.{key}", np.median(seeds_of(turned, OMNI, key)))


# Fig. 4.5: the camera, its mirror and three grids.


SEED = 0
GRIDS = tuple(series(k)["color"] for k in (0, 1, 2))
# The mirror above its camera, as in the room, and both in front of the grids.
SIGHT, UP = (0.8, -0.5, -0.4), (0.0, 0.0, 1.0)
# Of the camera's pyramid and axes, and of the rays at the edge of the field of view.
BODY_MM, AXIS_MM, FIELD_MM = 25.0, 50.0, 110.0


@figure("fig_4_5", needs=(), evidence="analytic", scene=True)
def fig_4_5(results):
    """Draw the camera below its mirror, and the three grids of the linear stage."""
    rig = rig_named("onevr-d70")
    poses = drawn_poses(rig, SEED)[:LINEAR_GRIDS]
    corner, size = rig.extent
    parts = setup_parts(rig.camera, poses, corner, size)
    scene = framed(parts, SIGHT, up=UP, note=rig.summary)
    middles = poses[:, :3] @ [*(corner + size / 2), 0, 1]
    data = {"grid": list(range(1, len(poses) + 1))} | {
        f"{axis}_mm": middles[:, k].tolist() for k, axis in enumerate("xyz")
    }
    seen = sum(bool(rig.shows(T)) for T in poses)
    return Drawing(
        scene_figure(scene, height_in=4.6),
        data,
        "The omnidirectional camera (rig onevr-d70) and three grids in the camera "
        "frame: the z axis points from the camera to the mirror (in the room: up). "
        "Sheets 1 to 3: successive positions of one monitor for the linear stage, "
        "which may therefore cross. Light blue: edge of the field of view. The "
        "bracket, which misaligns the mirror by 1 mm, is not drawn.",
        Check(seen == len(poses), f"{seen} of {len(poses)} grids are in view"),
        scene,
    )


def setup_parts(camera, poses, corner, size):
    """Return camera, mirror and numbered monitor sheets in the camera frame.

    poses: T_camera_grid (n, 4, 4); corner, size: (2,) of the monitor in its plane, mm.
    """
    parts = [*field_of_view(camera, FIELD_MM), *mirrors(camera, opacity=1.0)]
    parts += [frustum(camera.viewer, BODY_MM), *axes_parts(AXIS_MM)]
    for number, (T, colour) in enumerate(zip(poses, GRIDS, strict=True), 1):
        name = f"grid {number}"
        sheet = plate(T, corner, size, colour=colour, opacity=0.4, label=name)
        rim = sheet.points[[0, 0, 1, 1, 0], [0, 1, 1, 0, 0]]
        parts += [sheet, Polyline(rim, colour, name, 2.5)]
        parts.append(Labels(rim[:1], [str(number)], INK, size=16.0))
    return parts


# Effect of a lens shift on a calibration, and the numbers of section 4.3.1.


WORDS = dict(zip(SETS, ("upright", "inverted"), strict=True))
FITTED = "grids and lens shift of the rig are chosen to give the printed value"


@table("ext_lens_shift", needs=("sec_4_3_1_turned",), evidence="rendered")
def ext_lens_shift(results):
    """Tabulate three methods on upright sets and on sets of an inverted camera."""
    result = results[TURNED]
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
            *(
                Measured.median(seeds_of(result, camera, f"{how}.{method}.{key}"))
                for key in heads
            ),
        )
        for camera in CAMERAS.values()
        for method, name in LINEAR_NAMES.items()
        for how, words in WORDS.items()
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
    field, turned = results[FIELD], results[TURNED]
    rigs = {camera: rig_named(name) for camera, name in RIGS.items()}
    omni, fish = (field.select(camera=camera) for camera in (OMNI, FISH))
    shifts = {
        camera: Value.of_seeds(
            seeds_of(turned, camera, "shift_2_px"), "px", put_in=FITTED
        )
        for camera in (OMNI, FISH)
    }
    angle = np.degrees(rigs[FISH].camera.max_angle)
    sizes = {
        camera: Value(f"{rig.camera.width}x{rig.camera.height}", unit="px")
        for camera, rig in rigs.items()
    }
    return {
        "s4_3_1_d70_size": sizes[OMNI],
        "s4_3_1_cp_size": sizes[FISH],
        "s4_3_1_omni_h": Value.of_seeds(
            omni.column("horizontal_deg"), "deg", put_in=FITTED
        ),
        "s4_3_1_omni_v": Value.of_seeds(
            omni.column("vertical_deg"), "deg", put_in=FITTED
        ),
        "s4_3_1_fish": Value.of_seeds(100 * fish.column("share"), "%", put_in=FITTED),
        "s4_3_1_fish_fov": Value(round(2 * float(angle), 6), unit="deg"),
        "s4_3_1_lin": Value(LINEAR_GRIDS, unit="count"),
        "s4_3_1_omni_extra": Value(rigs[OMNI].count - LINEAR_GRIDS, unit="count"),
        "s4_3_1_fish_extra": Value(rigs[FISH].count - LINEAR_GRIDS, unit="count"),
        "s4_3_1_d70_shift": shifts[OMNI],
        "s4_3_1_cp_shift": shifts[FISH],
    }
