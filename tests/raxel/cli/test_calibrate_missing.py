"""All commands accept boards with missing corners."""

import json

import numpy as np

from raxel.cli import main
from raxel.features.boards import read_boards
from tests.made_sets import (
    CENTRE,
    COLUMNS,
    PINHOLE,
    ROWS,
    boards_of,
    of_more_than_the_rim,
    write_made_set,
)


def test_models_and_evaluation_accept_missing_corners(tmp_path, monkeypatch):
    def without_some(image_set, views, options, say):
        boards = read_boards(options.corners, image_set, views)
        for number, board in enumerate(boards):
            board.detection.corners[[number, 30 + number]] = np.nan
        return boards, None

    monkeypatch.setattr("raxel.cli.views.boards_for", without_some)
    small = [(b - CENTRE) * 0.3 + CENTRE for b in boards_of(PINHOLE)]
    folder, corners = write_made_set(tmp_path / "set", small)
    camera, result = tmp_path / "camera.npz", tmp_path / "result.json"
    asked = [str(folder), "--corners", str(corners), "--json", str(result)]
    calibrated = ["calibrate", *asked, "--out", str(camera)]
    for command in (
        [*calibrated, "--model", "zhang", "--report", str(tmp_path / "report")],
        ["evaluate", str(camera), *asked],
        [*calibrated, "--model", "generic"],
    ):
        assert main(command) == 0
        found = json.loads(result.read_text())
        assert {image["n_corners"] for image in found["images"]} == {COLUMNS * ROWS - 2}
        assert found["rms_px"] < 0.1
        warnings = of_more_than_the_rim(found["warnings"])
        assert all(text.startswith("the table") for text in warnings)
