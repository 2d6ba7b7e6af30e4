"""Results of other pages that the directions for further work quote."""

import numpy as np

from repro.page import value

VERDICTS = (
    "c3_big_square_curved",
    "c3_size_variation_merge",
    "c4_centre_ba_unstable",
    "c5_high_order",
    "c5_knot_tradeoff",
    "c5_known_scene",
    "c5_selfcal_impractical",
    "c6_detect_8px",
)
MEASURED = {
    "relief": "c5_high_order",
    "step": "c5_knot_tradeoff",
    "drift": "c5_known_scene",
}
# Errors of the centre in `exp_c4_centre_ba_unstable`: scheme and side.
CENTRES = {
    "linear": ("consistent", "starts_mm"),
    "consistent": ("consistent", "ends_mm"),
    "line_fitting": ("line_fitting", "ends_mm"),
}


def name_values(rows, open_results):
    """Name the verdicts and numbers that the text quotes."""
    board = {row["id"]: row for row in rows}
    for claim in VERDICTS:
        value(claim, board[claim]["verdict"])
    for name, claim in MEASURED.items():
        value(name, board[claim]["regenerated"])
    starts = open_results("exp_c4_centre_ba_unstable")
    for name, path in CENTRES.items():
        value(name, np.median(np.concatenate(starts.arrays(*path))))
    runs = open_results("ext_centrality_runs")
    for field in ("central_miss_mm", "lines_miss_mm"):
        value(field, np.median(runs.column(field, camera="mirror_two", noise_mm=0.1)))
    zoo = open_results("ext_without_clicks_zoo").select()
    worst, right, wrong = zoo.column("raxel", "counted", ("worst_px", "right", "wrong"))
    value("detector.boards", len(right))
    value("detector.right", int(right.sum()))
    value("detector.wrong", int(wrong.sum()))
    value("detector.median_px", np.median(worst[right == 1]))
