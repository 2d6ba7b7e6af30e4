"""The report of a bending mirror: shapes, support, residuals, what was flagged."""

from html import escape
from pathlib import Path
from typing import NamedTuple

import numpy as np

from raxel.calibration.mirror.observations import normalised
from raxel.features.detector import as_8_bit
from raxel.report.canvas import encoded
from raxel.report.folder import PAGE
from raxel.report.mirror_pictures import profile_picture, profiles, shape_picture
from raxel.report.page import document, figure, numbers, pairs, told, warnings
from raxel.report.pictures import ArrowScale, residual_picture
from raxel.sets import read_image

HEADS = (
    "Stage", "Stated (mm)", "Moved at the end (mm)", "Residual (mm)", "Corners",
    "Left out", "Rays, median (deg)", "Rays, worst (deg)",
)  # fmt: skip


class ShownView(NamedTuple):
    """A photograph of a board: its stage, its name, and its picture of residuals."""

    stage: int
    name: str
    residuals: str


def write_mirror_report(folder, mirror_set, found, result):
    """Write the report of a mirror set's calibration into an empty folder.

    found: MirrorCalibration; result: what `raxel calibrate` writes as JSON. Files are
    numbered, so that no name of a photograph becomes one.
    """
    folder = Path(folder)
    photographs = {view.label: view.photograph for view in mirror_set.stages.views}
    off = found.bundle.residuals
    scale = ArrowScale.of(np.concatenate(off), mirror_set.size[0])
    views, of_stage = [], {}
    for number, (shown, residuals) in enumerate(zip(found.views, off, strict=True), 1):
        name = shown.view.name
        image = as_8_bit(read_image(mirror_set.stages, photographs[name]))
        of_stage.setdefault(shown.stage, image)
        views.append(ShownView(shown.stage, name, f"residuals-{number:03}.jpg"))
        pixels = _counted(found.cameras[shown.stage], shown.view.pixels)
        drawn = residual_picture(image, pixels, residuals, scale)
        (folder / views[-1].residuals).write_bytes(encoded(drawn, ".jpg"))
    for stage, image in of_stage.items():
        drawn = shape_picture(image, found, stage)
        (folder / _shape_name(stage)).write_bytes(encoded(drawn, ".jpg"))
    along, height = profiles(found)
    drawn = profile_picture(along, height)
    (folder / "profiles.png").write_bytes(encoded(drawn, ".png"))
    before = np.interp(along[:, -1], along[0], height[0])
    moved = height[:, -1] - before
    text = _page(mirror_set, result, views, moved)
    (folder / PAGE).write_text(text, "utf-8")


def _counted(camera, pixels):
    """Those of pixels (N, 2) that count in the bundle: found, and between the knots."""
    with np.errstate(invalid="ignore"):
        return pixels[camera.grid.inside(normalised(camera.viewer, pixels))]


def _page(mirror_set, result, views, moved):
    """The page as text; moved (n,) mm: the end of each profile, off the first shape."""
    title = escape(f"{mirror_set.name}: calibration, {result['model']}")
    parts = [
        f"<h1>{title}</h1>",
        *warnings(result["warnings"]),
        pairs(_numbers(result)),
        "<h2>Shapes</h2>",
        figure(
            "profiles.png",
            "The mirror's middle line at all stages, from the clamp's line to the end "
            "of the knots, beyond which no corner was seen: heights over the plane of "
            "the first shape, towards the camera. The table has how far the end of "
            "each moved.",
        ),
        _table(result["stages"], moved),
    ]
    for stage, about in enumerate(result["stages"]):
        parts += _stage(stage, about, [view for view in views if view.stage == stage])
    return document(title, parts)


def _numbers(result):
    """[(what, value in words)] of the camera, the first shape and the bundle."""
    clamp, primary, bundle = result["clamp"], result["primary"], result["bundle"]
    yield "Camera", result["viewer"]
    yield (
        "Clamp's line",
        f"{len(clamp['points'])} points, {told(clamp['rms_px'], '.2f', ' px')} from a "
        f"straight line, {clamp['hidden_mm']:g} mm of the mirror hidden before it",
    )
    yield (
        "Rays of the first shape meet within",
        told(primary["points_from_rays_mm"], ".3f", " mm"),
    )
    yield (
        "Corners of the platter's board",
        told(primary["platter_rms_px"], ".3f", " px"),
    )
    for motion in primary["grids"]:
        yield (
            f"Monitor, {motion['first']} to {motion['second']}",
            f"{told(motion['distance_mm'], '.2f', ' mm')} (SD "
            f"{told(motion['distance_sd_mm'], '.2f', '')}), turned by "
            f"{told(motion['angle_deg'], '.3f', ' deg')}",
        )
    yield (
        "All stages at once",
        f"{bundle['freedom']} numbers beyond the unknowns, variance "
        f"{told(bundle['corners_variance'], '.2f', '')}, "
        f"{'settled' if bundle['converged'] else 'stopped before it settled'}",
    )


def _table(stages, moved):
    head = "".join(f"<th>{name}</th>" for name in HEADS)
    rows = []
    for stage, (about, way) in enumerate(zip(stages, moved, strict=True)):
        sure = about["predicted_ray_error_deg"]
        stated = about.get("deflection_mm")
        cells = (
            "" if stated is None else f"{stated:g}",
            told(way, ".2f", "") if stage else "",
            told(about["residual_mm"]["mean"], ".3f", ""),
            about.get("corners", ""),
            about.get("wrong_corners", ""),
            told(sure["median"], ".3f", ""),
            told(sure["largest"], ".3f", ""),
        )
        rows.append(f"<tr><td>{stage}</td>{numbers(cells)}</tr>")
    return f"<table>\n<tr>{head}</tr>\n" + "\n".join(rows) + "\n</table>"


def _stage(stage, about, views):
    """HTML of one stage: its shape and knots, its flags, its boards' residuals."""
    parts = [f"<h2>Stage {stage}</h2>"]
    if stage:
        support = about["support"]
        counts = ", ".join(map(str, support["along_u"]))
        across = ", ".join(map(str, support["along_v"]))
        parts.append(
            f"<p>From {escape(about['before'])} to {escape(about['after'])}. Corners "
            f"for each knot interval: {counts} along the mirror, {across} across it."
            "</p>"
        )
        parts += [f"<p>flagged: {escape(text)}</p>" for text in about["flags"]]
    else:
        parts.append(
            "<p>The first shape rests on the monitor, not on the corners that are "
            "counted in the picture.</p>"
        )
    parts.append(
        figure(
            _shape_name(stage),
            "Lines of equal height over the first shape's plane, and the knots. Where "
            "a number is 0 no corner says what the shape is.",
        )
    )
    for view in views:
        parts.append(
            figure(view.residuals, f"Residuals of {view.name}, on one scale for all.")
        )
    return parts


def _shape_name(stage):
    return f"shape-{stage:03}.jpg"
