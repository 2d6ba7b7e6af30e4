"""Tables of errors, detectors and predicted standard deviations."""

import numpy as np

from chapters.guides.choose_a_method.results.compared import compared_sets
from chapters.guides.choose_a_method.results.detector_counts import (
    count_columns,
    every_count,
    summed,
)
from chapters.guides.choose_a_method.results.prose import (
    FOVS_DEG,
    HELD_OUT,
    METHODS,
    PRIMARY,
    SIMULATED,
    STEPS,
    held_out_share,
    image_share,
    of_both,
    of_peer,
    peer_column,
    peer_in_zoom,
    typical,
)
from chapters.shared.general_cameras import KINDS
from chapters.shared.photographs.reading import PEER
from chapters.shared.zoom_rigs import STAGE_ZOOM, ZOOMS
from repro.run.columns import cell, columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

FAILED = "failed"
COLUMNS = (
    "Evidence",
    "Camera",
    "Quantity",
    "Zhang",
    "OpenCV fisheye",
    "Generic",
    "Corners with a ray (%)",
    "Image or circle with a ray (%)",
)
CAPTION = (
    "Errors of each calibration method, by kind of evidence. Medians with 95 % "
    "intervals. A failed trial counts as worst, and a method that failed in half "
    "of the trials has no median. OpenCV fisheye has fewer trials than the others "
    "in the simulated rows and on the sets of the converter. With a ray: share of "
    "the generic camera, of the whole image, or of the image circle for the 183° "
    "lens; not measured for simulated cameras. "
)
GENERIC = METHODS[1]
INNER, ALL = "inner", "all"
WHICH = {INNER: "inner boards", ALL: "all boards"}
HELD_OUT_PX = "residual, held-out (px)"
SCORED = {"kept_out_px": HELD_OUT_PX, "ray_deg": "ray error (deg)"}


def as_cell(estimate):
    """Return a median with its interval as a cell; None where it was not measured.

    Where at least half of the trials failed, the worst is the median.
    """
    if estimate is None:
        return None
    if not np.isfinite(estimate.value):
        return FAILED
    return Measured(*estimate[:3])


def simulated_rows(fov, fisheye):
    """Yield Fig. 2.3: ray error and residual at three fields of view."""
    for name, quantity in SIMULATED.items():
        for at in FOVS_DEG:
            where = {"fov_deg": at, **PRIMARY}
            zhang, generic = (as_cell(e) for e in of_both(fov, name, **where))
            peer = as_cell(of_peer(fisheye, name, **where))
            camera = f"fisheye, {at}°"
            yield (
                "simulated", camera, quantity, zhang, peer, generic, None, None,
            )  # fmt: skip


def rendered_rows(results):
    """Yield Table 2.2: errors in held-out images, and the stage."""
    zoom = results["table_2_2_redrawn"]
    asked = [
        *((HELD_OUT, "corrected view (px)", at) for at in ZOOMS),
        (STEPS, "scatter of steps (mm)", STAGE_ZOOM),
    ]
    for name, quantity, at in asked:
        zhang, generic = (as_cell(e) for e in of_both(zoom, name, zoom=at))
        peer = as_cell(peer_in_zoom(results, name, at))
        camera = f"fisheye converter, set {at}"
        seen = zoom.column(f"{GENERIC}.share_of_image", zoom=at)
        kept = held_out_share(zoom, at) if name == HELD_OUT else np.nan
        shares = [finite(100 * share, None) for share in (kept, image_share(seen))]
        yield ("rendered", camera, quantity, zhang, peer, generic, *shares)


def benchmark_rows(scores):
    """Yield ray errors on the rigs of the benchmarks."""
    for condition in scores.conditions:
        found = [
            finite(scores.column(f"{model}.rms_deg", **condition)[0])
            for model in ("zhang", "opencv_fisheye", "general")
        ]
        share = scores.column("general.share_with_ray", **condition)[0]
        camera = f"fisheye converter, set {condition['rig'].rpartition('-')[2]}"
        circle = finite(100 * share, None)
        yield ("rendered", camera, "ray error (deg)", *found, None, circle)


def fisheye_rows(scores):
    """Yield errors of the fisheye guide: boards up to the edge, and inner boards."""
    for use, which in WHICH.items():
        image, corners = (
            finite(100 * scores.column(f"generic.{what}", boards=use)[0], None)
            for what in ("image_with_ray", "corners_with_ray")
        )
        for name, quantity in SCORED.items():
            found = [
                finite(scores.column(f"{model}.{name}", boards=use)[0])
                for model in ("zhang", "opencv_fisheye", "generic")
            ]
            camera = f"fisheye, 183°, {which}"
            yield ("rendered", camera, quantity, *found, corners, image)


def finite(x, otherwise=FAILED):
    """Return a number of one run as a cell with three digits, or a substitute."""
    return float(f"{x:.3g}") if np.isfinite(x) else otherwise


def photograph_rows(study):
    """Yield every image set of the build: residual in held-out images."""
    for one in compared_sets(study):
        found = [as_cell(one.errors.get(model)) for model in ("zhang", PEER, "general")]
        shares = (finite(100 * x, None) for x in (one.share, one.image_share))
        yield ("photographs", one.name, HELD_OUT_PX, *found, *shares)


def recorded_rows(kept):
    """Yield five real cameras from the record, which no build recomputes."""
    for condition in kept.conditions:
        found = [
            recorded_cell(kept, model, condition)
            for model in ("zhang", "opencv_fisheye", "generic")
        ]
        shares = (
            finite(100 * kept.column(name, **condition)[0], None)
            for name in ("corners_with_ray", "image_with_ray")
        )
        yield (
            "photographs",
            f"{condition['set']} (record)",
            HELD_OUT_PX,
            *found,
            *shares,
        )


def recorded_cell(kept, model, condition):
    """Return a recorded median with its interval, or `FAILED`."""
    ends = [
        kept.column(f"models.{model}.{x}", **condition)[0]
        for x in ("px", "px_low", "px_high")
    ]
    return Measured(*ends) if np.isfinite(ends).all() else FAILED


def answers(results):
    """Return where the other methods have rays, for the caption."""
    share = image_share(peer_column(results, "share_of_image", STAGE_ZOOM))
    share_text = (
        f": on set {STAGE_ZOOM} of the converter, {100 * share:.0f} % of the image"
        if np.isfinite(share)
        else ""
    )
    return (
        "Zhang's camera has rays wherever its formula is invertible, correct or not. "
        "OpenCV fisheye has rays as far out as its fitted formula "
        f"rises{share_text}. Compare within a row only: rows differ in camera, unit "
        "and noise."
    )


# Of the three kinds of evidence, the one furthest from calculation is named.
@table(
    "ext_methods",
    needs=(
        "fig_2_3_fov",
        "fig_2_3_fisheye",
        "table_2_2_redrawn",
        "table_2_2_readings",
        "fig_2_7_smooth",
        "photograph_study",
        "ext_calibration_record",
        "ext_benchmark_scores",
        "ext_fisheye_scores",
    ),
    evidence="photograph",
)
def ext_methods(results):
    """Tabulate the errors of all methods, from all experiments that compare them."""
    fov, fisheye = results["fig_2_3_fov"], results["fig_2_3_fisheye"]
    rows = [
        *simulated_rows(fov, fisheye),
        *rendered_rows(results),
        *benchmark_rows(results["ext_benchmark_scores"]),
        *fisheye_rows(results["ext_fisheye_scores"]),
        *recorded_rows(results["ext_calibration_record"]),
        *photograph_rows(results["photograph_study"]),
    ]
    return Table(columns(COLUMNS, rows), CAPTION + answers(results))


@table("ext_known_motion", needs=("fig_2_2_error",), evidence="synthetic")
def ext_known_motion(results):
    """Tabulate the ray error of the two-pose method for a wrong motion."""
    wrong = results["fig_2_2_error"]
    errors = [typical(wrong, "ray_deg.1", kind=kind) for kind in KINDS]
    return Table(
        {
            "Error of the motion": [
                f"1 {unit} of {kind}" for kind, unit in KINDS.items()
            ],
            "Ray error (deg)": [as_cell(e) for e in errors],
        },
        "Ray error for a wrong motion of the target, in a simulated fisheye of 120° "
        f"with two grids ({wrong.settings['grids']}). Medians with 95 % intervals.",
    )


@table(
    "ext_detectors_in_short",
    needs=(
        "table_3_4_grids",
        "table_3_5_grids",
        "table_3_6_grids",
        "table_3_7_grids",
        "ext_detector_record",
    ),
    evidence="photograph",
)
def ext_detectors_in_short(results):
    """Tabulate correct boards of all rendered sets, and of all real images."""
    return Table(
        count_columns(summed(every_count(results), by=("evidence", "poses"))),
        "Boards detected correctly and wrongly, given only the number of corners: the "
        "rendered sets of 3.3.2 by the range of their poses, and a record of real "
        "images of five cameras.",
    )


@table("ext_stated_errors", needs=("ext_stated_record",), evidence="rendered")
def ext_stated_errors(results):
    """Tabulate predicted standard deviations and actual errors by quantity."""
    kept = results["ext_stated_record"]
    every = kept.select().column
    return Table(
        {
            "Quantity": [condition["quantity"] for condition in kept.conditions],
            "n": every("errors").astype(int).tolist(),
            "Predicted SD (px)": [cell(x) for x in every("sd_px")],
            "Actual error (px)": [cell(x) for x in every("error_px")],
            "Actual over predicted": every("ratio.median").tolist(),
            "Least case": every("ratio.least").tolist(),
            "Worst case": every("ratio.most").tolist(),
            "Within 3 SD (%)": every("within3").tolist(),
        },
        "Predicted standard deviations and actual errors: medians over the cases "
        "(kinds of blur, noise, light, lens) of a record, and the range of the ratio. "
        "n: number of errors. Actual errors are robust standard deviations; of a "
        f"Gaussian, 99.7 % are within 3 SD. The record is made by "
        f"`{kept.settings['command']}`.",
    )
