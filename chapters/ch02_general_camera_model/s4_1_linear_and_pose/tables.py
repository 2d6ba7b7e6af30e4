"""Algorithm 1 with what its steps gave, one worked row, and what was counted."""

import numpy as np

from chapters.ch02_general_camera_model.s4_1_linear_and_pose.results import exact_errors
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Check, Table

EXACT_DEG = 1e-6
WORKED_SHARE = 1e-9
STEPS = (
    (
        "image the grid in three or more overlapping poses, and more "
        "of them to cover the field of view",
        "BoardView",
    ),
    ("find the location on each grid that each pixel sees", "locate_pixels"),
    ("estimate the poses, and the centre, linearly", "linear_well_conditioned"),
    ("bundle adjust poses and rays", "bundle_adjust_fixed_centre"),
    (
        "pose of each further grid, then its rays; bundle adjust",
        "pose_from_rays, bundle_adjust_fixed_centre",
    ),
    ("store the rays as Plücker matrices", "GeneralCamera.pluecker"),
)


def outcomes(ran, camera):
    """What the six steps gave for one camera, in words."""

    def found(name):
        return float(ran.column(name, camera=camera)[0])

    return [
        f"{found('overlap.boards'):.0f} boards; "
        f"{100 * found('overlap.one'):.0f} % of the pixels on one or more, "
        f"{100 * found('overlap.three'):.0f} % on three or more",
        f"{found('locate.pixels'):.0f} locations, median error "
        f"{found('locate.median_mm'):.1g} mm",
        f"three boards; largest error of a position {found('linear.pose_mm'):.1g} mm",
        f"ray-point distance (RMS) from {found('bundle.start_mm'):.3g} to "
        f"{found('bundle.end_mm'):.3g} mm; largest error of a position "
        f"{found('bundle.pose_mm'):.1g} mm",
        f"{found('others.boards'):.0f} more boards, "
        f"{found('others.left_out'):.0f} left out; largest error of a "
        f"position {found('others.pose_mm'):.1g} mm",
        f"{found('table.matrices'):.0f} matrices, "
        f"{100 * found('table.share'):.0f} % of the pixels; median ray "
        f"error {found('table.median_deg'):.1g}°",
    ]


@table("alg_1", needs=("alg_1_run",), evidence="synthetic")
def alg_1(results):
    """Algorithm 1; its check is that the run reproduces the rays."""
    ran = results["alg_1_run"]
    exact = ran.column("table.largest_deg", camera="pinhole")[0]
    median = ran.column("table.median_deg", camera="fisheye")[0]
    pixel = ran.column("table.pixel_deg", camera="fisheye")[0]
    return Table(
        {
            "Step": list(range(1, 7)),
            "What": [what for what, _ in STEPS],
            "raxel": [f"`{name}`" for _, name in STEPS],
            "Pinhole": outcomes(ran, "pinhole"),
            "Fisheye": outcomes(ran, "fisheye"),
        },
        "Standard generic calibration: the six steps, the function that "
        "performs each, and what it gave in one run without noise.",
        Check(
            bool(exact < EXACT_DEG and median < pixel / 2),
            f"the rays of the pinhole are reproduced to {exact:.1g}° "
            f"(all), those of the fisheye to {median:.2g}° (median), less "
            f"than half a pixel of {pixel:.2g}°",
        ),
    )


@table("ext_worked_row", needs=("ext_worked_row_scene",), evidence="synthetic")
def worked_row(results):
    """The first row of (2.24) with the numbers of one scene."""
    result = results["ext_worked_row_scene"]
    found = {
        name: result.arrays(name)[0]
        for name in ("coefficients", "unknowns", "left", "right", "scales")
    }
    v, u = found["coefficients"][0], found["unknowns"]
    gap = np.abs(found["left"] - found["right"]).max()
    size = np.abs(found["right"]).max()
    rows = [
        (r"$\lambda_1$", "scale of the vectors of grid 2", found["scales"][0]),
        ("$V'_4$", r"seen: $\lambda_1 R^2_{31}$", v[3]),
        ("$V'_7$", r"seen: $\lambda_1(C_z R^2_{21} - C_y R^2_{31})$", v[6]),
        ("$u_2$", "sought: $C_y$ (mm)", u[1]),
        ("$u_7$", r"sought: $\lambda_1 C_z R^2_{21}$", u[6]),
        ("$u_7 - V'_4 u_2$", "left side of the row", found["left"][0]),
        ("$V'_7$", "right side of the row", found["right"][0]),
    ]
    return Table(
        columns(("Symbol", "What it is", "Value"), rows),
        "The first row of (2.24) in the scene of the figure, with the true "
        "centre and poses put in. Left and right side agree.",
        Check(
            bool(gap < WORKED_SHARE * size),
            f"in all twelve rows both sides agree, to {gap / size:.1g} of the largest",
        ),
    )


@table(
    "ext_linear_stage",
    needs=("exp_c2_rank_D", "exp_c2_linear_exact"),
    evidence="synthetic",
)
def linear_stage(results):
    """Singular values, null vectors and errors, at their worst."""
    ranks, exact = results["exp_c2_rank_D"], results["exp_c2_linear_exact"]
    rows = [
        (
            "$D$: fifth singular value, as a share of the first",
            "smallest",
            ranks.column("orthonormal.fifth").min(),
        ),
        (
            "$D$: sixth singular value, as a share of the first",
            "largest",
            ranks.column("orthonormal.sixth").max(),
        ),
        (
            "null vectors of $D$ where the thesis says zero",
            "largest",
            ranks.column("orthonormal.null_entry").max(),
        ),
        (
            r"the same, $\mathbf{b}$ and $\mathbf{c}$ not orthonormal",
            "largest",
            ranks.column("any.null_entry").max(),
        ),
        (
            "centre, corrected formulas: error (mm)",
            "largest",
            exact_errors(exact, "corrected")["centre_mm"],
        ),
        (
            "centre, well conditioned: error (mm)",
            "largest",
            exact_errors(exact, "well_conditioned")["centre_mm"],
        ),
    ]
    return Table(
        columns(("Quantity", "Over all scenes", "Value"), rows),
        "The linear stage without noise, in "
        f"{exact.trials_per_condition} scenes: what should be zero is zero "
        "to rounding.",
    )


@table("ext_three_points", needs=("exp_c2_pose_eight",), evidence="synthetic")
def three_points(results):
    """How many triplets have how many real solutions."""
    ran = results["exp_c2_pose_eight"]
    found = {
        anchors: ran.column("solutions", anchors=anchors).astype(int)
        for anchors in ("common", "distinct")
    }
    counts = sorted(set(np.concatenate(list(found.values())).tolist()))
    return Table(
        {
            "Real solutions": counts,
            "Triplets, rays from one point": [
                int((found["common"] == n).sum()) for n in counts
            ],
            "Triplets, rays from three points": [
                int((found["distinct"] == n).sum()) for n in counts
            ],
        },
        "How many poses of a grid fit the distances of three of its points. "
        "Solutions behind the camera count too.",
    )
