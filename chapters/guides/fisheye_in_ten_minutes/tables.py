"""The three calibrations in numbers, and the steps with what they print."""

from __future__ import annotations

from chapters.guides.fisheye_in_ten_minutes.results import (
    NAMES,
    SCORES,
    SETS,
    said,
)
from chapters.shared.run_times import rounded_seconds
from repro.page.reader import Shown, pipe_table
from repro.page.wording import literal
from repro.run.experiment import table
from repro.run.outcomes import Table

QUANTITIES = {
    "Fitted boards: RMS (px)": ("fitted_px", 1),
    "Kept out: RMS (px)": ("kept_out_px", 1),
    "Kept out: angle (deg)": ("kept_out_deg", 1),
    "Corners with a ray (%)": ("corners_with_ray", 100),
    "Image circle with a ray (%)": ("image_with_ray", 100),
    "Error of the rays (deg)": ("ray_deg", 1),
}
WHICH = {"inner": "inner rings", "all": "all"}


@table(
    "ext_fisheye_models",
    needs=("ext_fisheye_scores",),
    evidence="rendered",
)
def ext_fisheye_models(results):
    """Zhang, OpenCV's fisheye model and the generic camera on the same corners."""
    scores = results[SCORES]
    rows, refused = [], []
    for use in SETS:
        count = int(scores.column("boards", boards=use)[0])
        for model, name in NAMES.items():
            reason = scores.texts(f"{model}.reason", boards=use)[0]
            row = {"Boards": f"{WHICH[use]} ({count})", "Model": name}
            for title, (quantity, unit) in QUANTITIES.items():
                x = scores.column(f"{model}.{quantity}", boards=use)[0]
                row[title] = None if reason else unit * float(x)
            rows.append(row)
            if reason:
                refused.append(
                    f" No camera: {name}, boards: {WHICH[use]} "
                    f"({literal(reason)})."
                )
    return Table(
        {title: [row[title] for row in rows] for title in rows[0]},
        "Three models from the same corners. Kept out: boards that no "
        "calibration saw, only their pose being fitted. Error of the rays: "
        "median angle to the true rays, over the pixels where the model has "
        "one, after the best rotation." + "".join(refused),
    )


def transcript(result, *commands):
    """Commands as typed, each with what it printed when it was run."""
    text = "\n".join(
        f"$ raxel {' '.join(typed)}\n{said(result, typed[0]).rstrip()}\n"
        for typed in commands
    )
    return Shown(f"````text\n{text}````", f"<pre>{text}</pre>")


def steps(took):
    """Table of the steps: [(step, command, seconds or words)]."""
    rows = [
        [step, command, x if isinstance(x, str) else rounded_seconds(x)]
        for step, command, x in took
    ]
    text = pipe_table(["Step", "With", "Takes"], rows, [False] * 3)
    return Shown(text, f"<pre>{text}</pre>")
