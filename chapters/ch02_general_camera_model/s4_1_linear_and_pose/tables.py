"""Algorithm 1 with the outcome of its steps, and the linear stage without noise."""

from chapters.ch02_general_camera_model.s4_1_linear_and_pose.results import exact_errors
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Check, Table

EXACT_DEG = 1e-6
STEPS = (
    (
        "image the grid in three or more overlapping poses, and in more "
        "poses to cover the field of view",
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
    """Return the outcome of the six steps for one camera, in words."""

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
        f"{found('others.left_out'):.0f} excluded; largest error of a "
        f"position {found('others.pose_mm'):.1g} mm",
        f"{found('table.matrices'):.0f} matrices, "
        f"{100 * found('table.share'):.0f} % of the pixels; median ray "
        f"error {found('table.median_deg'):.1g}°",
    ]


@table("alg_1", needs=("alg_1_run",), evidence="synthetic")
def alg_1(results):
    """Tabulate Algorithm 1 and check that the run reproduces the rays."""
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
        "Standard generic calibration: the six steps, the library function of "
        "each, and its outcome in one run without noise.",
        Check(
            bool(exact < EXACT_DEG and median < pixel / 2),
            f"the rays of the pinhole are reproduced to {exact:.1g}° "
            f"(all), those of the fisheye to {median:.2g}° (median), less "
            f"than half a pixel of {pixel:.2g}°",
        ),
    )


@table(
    "ext_linear_stage",
    needs=("exp_c2_rank_D", "exp_c2_linear_exact"),
    evidence="synthetic",
)
def linear_stage(results):
    """Tabulate the worst singular values, null vectors and errors."""
    ranks, exact = results["exp_c2_rank_D"], results["exp_c2_linear_exact"]
    rows = [
        (
            "$D$: fifth singular value, relative to the first",
            "smallest",
            ranks.column("orthonormal.fifth").min(),
        ),
        (
            "$D$: sixth singular value, relative to the first",
            "largest",
            ranks.column("orthonormal.sixth").max(),
        ),
        (
            "null vectors of $D$ where the thesis states zero",
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
        "Singular values, null-vector entries and errors of the linear stage "
        f"without noise, in {exact.trials_per_condition} scenes. Quantities "
        "that should be zero are zero to rounding.",
    )
