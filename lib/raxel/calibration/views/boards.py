"""Correspondences for a calibration from the boards detected in an image set."""

from __future__ import annotations

from collections.abc import Iterable

from raxel.calibration.views.correspondence import BoardView
from raxel.features.boards import Board
from raxel.sets.model import ImageSet


def board_views(image_set: ImageSet, boards: Iterable[Board]) -> list[BoardView]:
    """Return one BoardView per board that was found, named by its image.

    Points are in mm, or in units of the pitch where it is unknown. The standard
    deviations of the corners are those of the detector, None where it gives none.

    Parameters
    ----------
    image_set : ImageSet
        A set of a chessboard.
    boards : iterable of Board
        From `detect_boards` or `read_boards`.

    Returns
    -------
    list of BoardView
        The views.
    """
    return [
        BoardView(  # type: ignore[call-arg]
            detection.corners,
            image_set.target.points(detection.columns, detection.rows),  # type: ignore[union-attr]
            detection.columns,  # type: ignore[arg-type]
            detection.rows,  # type: ignore[arg-type]
            view.label,
            detection.sd,
        )
        for view, detection, _ in boards
        if detection.found
    ]
