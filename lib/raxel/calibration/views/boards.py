"""From the boards found in an image set to the correspondences a calibration takes."""

from raxel.calibration.views.correspondence import BoardView


def board_views(image_set, boards):
    """One BoardView per board that was found, named by its image.

    Points are in mm, or in units of the pitch where the set does not know it. The
    corners' standard deviations are the detector's, None where it gives none.
    """
    return [
        BoardView(
            detection.corners,
            image_set.target.points(detection.columns, detection.rows),
            detection.columns,
            detection.rows,
            view.label,
            detection.sd,
        )
        for view, detection, _ in boards
        if detection.found
    ]
