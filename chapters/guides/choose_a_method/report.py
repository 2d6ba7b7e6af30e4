"""Results of this page read: values of the prose, figures, tables."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chapters.shared.general import KINDS, OF_SEEDS, STAGE_ZOOM, ZOOMS, ZoomCase, rig_of
from chapters.shared.grids import CLICKLESS, OPENCV, OPENCV_SB
from repro.run import (
    Measured,
    Table,
    cell,
    columns,
    median_and_range,
    median_interval,
    table,
)

# Boards detected correctly and wrongly: rendered sets and real images.


RENDERED = ("table_3_4_grids", "table_3_5_grids", "table_3_6_grids", "table_3_7_grids")
RECORD = "ext_detector_record"
DETECTORS = {"raxel": "raxel", "opencv": "OpenCV", "opencv-sb": "OpenCV sector-based"}
# The same detectors as 3.3.2 names them.
NAMES_OF_3_3_2 = {"raxel": CLICKLESS, "opencv": OPENCV, "opencv-sb": OPENCV_SB}


class Counted(NamedTuple):
    """Images of one kind, and the number of correct and wrong boards per detector."""

    evidence: str
    images: str
    count: int
    right: dict[str, int]
    wrong: dict[str, int]
    poses: str = ""


def rendered_counts(results):
    """Return a Counted for each set of 3.3.2 and each range of its poses."""
    names = {own: detector for detector, own in NAMES_OF_3_3_2.items()}
    found = []
    for name in RENDERED:
        for poses, some in results[name].by("poses").items():
            counts = some.column(tuple(names), ("success", "returned")).sum(axis=-1)
            right = dict(zip(names.values(), map(int, counts[:, 0]), strict=True))
            wrong = dict(zip(right, map(int, counts[:, 1] - counts[:, 0]), strict=True))
            title = f"{some.conditions[0]['set']}, {poses} range"
            count = len(some.conditions)
            found.append(Counted("rendered", title, count, right, wrong, poses))
    return found


def recorded_counts(record):
    """Return a Counted for each set of real images in the record."""
    found = []
    for name, kept in record.by("set").items():
        right, wrong = (
            {d: int(kept.column(d, what)[0]) for d in DETECTORS}
            for what in ("right", "wrong")
        )
        count = int(kept.column("images")[0])
        found.append(Counted("photographs", name, count, right, wrong))
    return found


def summed(counted, by=("evidence",)):
    """Return one Counted per kind, summed over its sets; ``by`` defines the kinds."""

    def kind(one):
        return tuple(getattr(one, name) for name in by)

    found = []
    for wanted in dict.fromkeys(map(kind, counted)):
        some = [c for c in counted if kind(c) == wanted]
        right, wrong = (
            {d: sum(getattr(c, what)[d] for c in some) for d in DETECTORS}
            for what in ("right", "wrong")
        )
        poses = dict(zip(by, wanted, strict=True)).get("poses", "")
        title = f"{len(some)} sets" + (f", {poses} range" if poses else "")
        count = sum(c.count for c in some)
        found.append(Counted(some[0].evidence, title, count, right, wrong, poses))
    return found


def count_columns(counted):
    """Return the columns of a table of Counted rows, numbers as numbers."""
    columns = {
        "Evidence": [c.evidence for c in counted],
        "Set": [c.images for c in counted],
        "Images": [c.count for c in counted],
    }
    for detector, name in DETECTORS.items():
        for what in ("right", "wrong"):
            columns[f"{name}: {what}"] = [getattr(c, what)[detector] for c in counted]
    return columns


# Errors of each method, read from results, and the numbers of the prose.


METHODS = ("parametric", "generic_well_conditioned")
GENERIC = METHODS[1]
PEER = "opencv_fisheye"
PRIMARY = {"domain": "px", "extent": "unbounded"}
FOVS_DEG = (60, 120, 150)
NARROW_DEG = FOVS_DEG[0]
SIMULATED = {
    "clean.source.mean_px": "residual, clean (px)",
    "ray_deg": "ray error (deg)",
}
BOTH = {"zhang": METHODS[0], "general": METHODS[1]}
HELD_OUT, STEPS = "held_out.corrected.rms_px", "stage.grid.deviation_mm"


def typical(result, *path, **condition):
    """Return the median over the trials; a failed one counts as the worst."""
    return median_interval(result.column(*path, **condition))


def of_both(result, name, **condition):
    """Return the same value of Zhang's and of the generic method."""
    return [typical(result, method, name, **condition) for method in METHODS]


def of_peer(result, name, **condition):
    """Return the same value of OpenCV's fisheye model; None where it was not run."""
    if not any(condition.items() <= one.items() for one in result.conditions):
        return None
    return typical(result, PEER, name, **condition)


def peer_column(results, name, at):
    """Return OpenCV's fisheye model on a set of the converter, None without runs."""
    chosen = {key: results[key] for key in OF_SEEDS}
    run = any(
        one["zoom"] == at and one.get("interpolation") == "smooth"
        for result in chosen.values()
        for one in result.conditions
    )
    case = ZoomCase(chosen, {"interpolation": "smooth"})
    return case.column(f"{PEER}.{name}", at) if run else None


def image_share(values):
    """Return the median share of an image with a ray, over the runs with a camera."""
    return np.nan if values is None else median_and_range(values).value


def held_out_share(zoom, at):
    """Return the median share of held-out corners with a ray of the generic camera."""
    rig = rig_of(at).target
    names = ("left_out", "boards")
    lost, boards = zoom.column(GENERIC, "held_out", names, zoom=at)
    return image_share(1 - lost / (boards * rig.columns * rig.rows))


def named(results):
    """Return the numbers of the prose: name -> text."""
    fov = results["fig_2_3_fov"]
    out = recorded_facts(results["ext_calibration_record"])
    out |= fisheye_facts(results["ext_fisheye_scores"])
    for model, method in BOTH.items():
        found = typical(fov, method, "ray_deg", fov_deg=NARROW_DEG, **PRIMARY)
        out[f"{model}.ray_deg.{NARROW_DEG}"] = short(found)
    return out


def recorded_facts(kept):
    """Return the errors of two methods on the widest real lens of the record."""
    widest = kept.conditions[int(kept.select().column("widest_deg").argmax())]
    models = ("opencv_fisheye", "generic")
    errors = kept.column("models", models, "px", **widest)[:, 0]
    return {
        f"record.{model}": f"{error:.2g} px" if np.isfinite(error) else "no camera"
        for model, error in zip(models, errors, strict=True)
    }


def fisheye_facts(scores):
    """Return the share of the image circle with a ray, by the boards used."""
    shares = {
        use: 100 * found.column("generic.image_with_ray")[0]
        for use, found in scores.by("boards").items()
    }
    return {f"fisheye.share.{use}": f"{share:.0f} %" for use, share in shares.items()}


def short(estimate):
    """Return a median as text."""
    if estimate is None:
        return "not measured"
    return f"{estimate.value:.2g}" if np.isfinite(estimate.value) else "∞"


# Tables of errors, detectors and predicted standard deviations.


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
INNER, ALL = "inner", "all"
WHICH = {INNER: "inner boards", ALL: "all boards"}
HELD_OUT_PX = "residual, held-out (px)"
SCORED = {"held_out_px": HELD_OUT_PX, "ray_deg": "ray error (deg)"}


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
    wanted = [
        *((HELD_OUT, "corrected view (px)", at) for at in ZOOMS),
        (STEPS, "scatter of steps (mm)", STAGE_ZOOM),
    ]
    for name, quantity, at in wanted:
        zhang, generic = (as_cell(e) for e in of_both(zoom, name, zoom=at))
        runs = peer_column(results, name, at)
        peer = None if runs is None else as_cell(median_interval(runs))
        camera = f"fisheye converter, set {at}"
        image = image_share(zoom.column(GENERIC, "share_of_image", zoom=at))
        corners = held_out_share(zoom, at) if name == HELD_OUT else np.nan
        shares = [finite(100 * share, None) for share in (corners, image)]
        yield ("rendered", camera, quantity, zhang, peer, generic, *shares)


def benchmark_rows(scores):
    """Yield ray errors on the rigs of the benchmarks."""
    for condition in scores.conditions:
        models = ("zhang", PEER, "general")
        found = map(finite, scores.column(models, "rms_deg", **condition)[:, 0])
        share = scores.column("general.share_with_ray", **condition)[0]
        camera = f"fisheye converter, set {condition['rig'].rpartition('-')[2]}"
        circle = finite(100 * share, None)
        yield ("rendered", camera, "ray error (deg)", *found, None, circle)


def fisheye_rows(scores):
    """Yield errors of the fisheye guide: boards up to the edge, and inner boards."""
    for use, which in WHICH.items():
        names = ("image_with_ray", "corners_with_ray")
        shares = 100 * scores.column("generic", names, boards=use)[:, 0]
        image, corners = (finite(share, None) for share in shares)
        for name, quantity in SCORED.items():
            models = ("zhang", PEER, "generic")
            found = map(finite, scores.column(models, name, boards=use)[:, 0])
            camera = f"fisheye, 183°, {which}"
            yield ("rendered", camera, quantity, *found, corners, image)


def finite(x, otherwise=FAILED):
    """Return a number of one run as a cell with three digits, or a substitute."""
    return float(f"{x:.3g}") if np.isfinite(x) else otherwise


def recorded_rows(kept):
    """Yield five real cameras from the record, which no build recomputes."""
    for condition in kept.conditions:
        found = [
            recorded_cell(kept, model, condition)
            for model in ("zhang", PEER, "generic")
        ]
        names = ("corners_with_ray", "image_with_ray")
        shares = 100 * kept.column(names, **condition)[:, 0]
        of_set = ("photographs", f"{condition['set']} (record)", HELD_OUT_PX)
        yield (*of_set, *found, *(finite(share, None) for share in shares))


def recorded_cell(kept, model, condition):
    """Return a recorded median with its interval, or `FAILED`."""
    ends = kept.column("models", model, ("px", "px_low", "px_high"), **condition)[:, 0]
    return Measured(*ends.tolist()) if np.isfinite(ends).all() else FAILED


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
    ]
    return Table(columns(COLUMNS, rows), CAPTION + answers(results))


@table("ext_known_motion", needs=("fig_2_2_error",), evidence="synthetic")
def ext_known_motion(results):
    """Tabulate the ray error of the two-pose method for a wrong motion."""
    wrong = results["fig_2_2_error"]
    errors = [typical(wrong, "ray_deg.1", kind=kind) for kind in KINDS]
    motions = [f"1 {unit} of {kind}" for kind, unit in KINDS.items()]
    return Table(
        {
            "Error of the motion": motions,
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
    counts = [*rendered_counts(results), *recorded_counts(results[RECORD])]
    return Table(
        count_columns(summed(counts, by=("evidence", "poses"))),
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
