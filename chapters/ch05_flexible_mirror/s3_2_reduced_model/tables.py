"""What residual and back-projection say of the final curve, beside what is true."""

from chapters.ch05_flexible_mirror.s3_2_reduced_model.results import RUNS
from chapters.ch05_flexible_mirror.s3_2_reduced_model.trials.run import PUBLISHED_WAY
from chapters.shared.mirror_bench import BENCHES
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

# Column of the trials -> what it is.
MEASURES = {
    "residual_mm": "residual of the refinement, mm",
    "back.own_mm": "back-projection at 400 mm, own pose, mm",
    "back.true_mm": "back-projection at 400 mm, true pose, mm",
    "before.angle_deg": "rays before bending, degrees off",
    "final.angle_deg": "rays after bending, degrees off",
    "before.camera_mm": "primary error, mm",
    "linear.camera_mm": "linear error, mm",
    "final.camera_mm": "final error, mm",
    "final.shared_mm": "final error, aligned before bending, mm",
    "final.alone_mm": "final error, each aligned, mm",
    "linear.deflection_mm": "deflection, linear estimate, mm",
    "final.deflection_mm": "deflection, final estimate, mm",
}


@table("ext_reduced_scores", needs=("fig_5_7_runs",), evidence="rendered")
def ext_reduced_scores(results):
    """Medians over the seeds of geometry A, on both benches."""
    result = results[RUNS]
    return Table(
        {"Measure": list(MEASURES.values())}
        | {
            bench: [
                Measured.median(result.column(f"{bench}.{PUBLISHED_WAY}.{name}"))
                for name in MEASURES
            ]
            for bench in BENCHES
        },
        f"Geometry A, {result.trials_per_condition} seeds: medians with 95 % "
        "intervals. Back-projection after bending; errors are mean distances from the "
        "true mirror, in the camera's frame if nothing else is said.",
    )
