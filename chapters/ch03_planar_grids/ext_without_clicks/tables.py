"""Tables of the page on extraction without clicks: boards, and refusals."""

import numpy as np

from chapters.ch03_planar_grids.ext_without_clicks.results import ROWS, found_row, known
from chapters.ch03_planar_grids.ext_without_clicks.trials.requests import RIGHT_PX
from repro.run.columns import in_columns
from repro.run.experiment import table
from repro.run.outcomes import Check, Table

ASKED = (
    "one column too many",
    "one column too few",
    "cropped, size given",
    "cropped, size not given",
    "two boards, size given",
    "two boards, size not given",
)


@table("ext_without_clicks", needs=("ext_without_clicks_zoo",), evidence="rendered")
def ext_without_clicks(results):
    """Detectors side by side on boards before the cameras of the zoo."""
    result = results["ext_without_clicks_zoo"]
    rows = [found_row(result, *row) for row in ROWS]
    wrong = rows[0]["Wrong"] + rows[1]["Wrong"]
    return Table(
        in_columns(rows),
        f"Boards before {len(result.conditions)} cameras of the zoo. Right: every "
        f"corner within {RIGHT_PX:g} px. Wrong: returned, and not right. Worst: of a "
        "board's corners, over the boards that are right.",
        Check(wrong == 0, f"raxel returned {wrong} wrong boards; the aim is none"),
    )


@table(
    "ext_click_free_refusals", needs=("ext_without_clicks_zoo",), evidence="rendered"
)
def ext_click_free_refusals(results):
    """What must be refused, and what is handed over all the same."""
    result = results["ext_without_clicks_zoo"]
    rows = [_refusal_row(result, name) for name in ASKED]
    returned = sum(row["Pictures"] - row["Refused"] for row in rows)
    return Table(
        in_columns(rows),
        "Pictures that do not show the board asked for, given to raxel. In order: "
        "share of the visible corners that the refusal holds, in order.",
        Check(returned == 0, f"{returned} boards were returned; the aim is none"),
    )


def _refusal_row(result, name):
    refused = known(result, f"refusals.{name}.refused")
    share = known(result, f"refusals.{name}.share") if "two" not in name else []
    return {
        "Asked for": name,
        "Pictures": len(refused),
        "Refused": int(refused.sum()),
        "In order, median (%)": 100 * float(np.median(share)) if len(share) else None,
        "In order, least (%)": 100 * float(share.min()) if len(share) else None,
    }
