"""What an unwrapped pixel is made of, in the first and in the last row."""

from chapters.ch01_introduction.s1_1_panorama.trials import RIG_MIRROR
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Table

SCALES = {
    "area": "area (pixels)",
    "along_row": "along the row (pixels)",
    "along_column": "along the column (pixels)",
}


@table("ext_fig_1_1_rows", needs=("fig_1_1_resolution",), evidence="analytic")
def unwrapped_rows(results):
    """Source pixels of one unwrapped pixel at the top and at the bottom."""
    ran, rows = results["fig_1_1_resolution"], []
    for name, label in SCALES.items():
        scale = ran.arrays(name, mirror=RIG_MIRROR)[0]
        top, bottom = float(scale[0]), float(scale[-1])
        rows.append((label, top, bottom, top / bottom))
    return Table(
        columns(("One unwrapped pixel", "Top row", "Bottom row", "Ratio"), rows),
        "How much of the source picture makes one pixel of the panorama: its "
        "area, and its length each way, in pixels of the source.",
    )
