"""The table of a mirror set's page."""

from chapters.photographs.mirror.results import STUDY, MirrorStudy
from repro.page.wording import literal
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Table


@table(
    "ext_mirror_found", needs=("mirror_study",), evidence="photograph",
    per_set=("mirror",),
)  # fmt: skip
def ext_mirror_found(results):
    """A row for each stage: how it moved, residual, corners, what is predicted."""
    study = MirrorStudy(results[STUDY])
    stated = [None, *study.settings["stated_mm"]]
    rows = [
        (
            stage,
            study.name(stage),
            stated[stage],
            study.moved_mm(stage),
            study.number("residual_mm", stage),
            int(study.number("corners", stage)),
            int(study.number("wrong", stage)),
            study.number("predicted_deg", stage),
        )
        for stage in range(study.stages)
    ]
    head = (
        "Stage", "Photograph", "Stated (mm)", "Moved at the end (mm)", "Residual (mm)",
        "Corners", "Left out", "Predicted (deg)",
    )  # fmt: skip
    caption = (
        "Every stage: the deflection as stated, how far the end of the profile moved, "
        "the mean distance of corners from their rays, and the standard deviation that "
        "the calibration predicts of rays among its corners, the median."
    )
    if study.refusal:
        caption = f"{caption} None: {literal(study.refusal)}."
    return Table(columns(head, rows), caption, texts=("Photograph",))
