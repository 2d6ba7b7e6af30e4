"""Whether a camera calibrated as central is one, by the views it was fitted to.

The same targets, the same poses to begin with, and a line of its own for each pixel of
a sample (`raxel.calibration.generic.central_test`). Pixels close together err together:
the decoder of an active grid averages over a window, and what is between the corners of
a board comes from those about it: a cell further on, errors have a correlation of a
quarter. So the sample takes pixels a window or a cell apart.
"""

import numpy as np

from raxel.calibration.generic.central_test import centrality_test
from raxel.calibration.views.interpolation import interpolated_view
from raxel.calibration.views.samples import sample_boards
from raxel.errors import CalibrationError
from raxel.geometry.poses import inverse_pose

OBSERVATIONS = 30_000  # pixel-view pairs, at most about
DECODER_PX = 7  # side of the square that the decoder averages over


def centrality_of_views(views, width, height, T_camera_grid):
    """CentralTest of a camera by the views that it was fitted to, or None.

    views: BoardViews or DenseViews; width, height: the image in px; T_camera_grid
    (n, 4, 4): their poses, in the frame of the camera's centre, where adjustments
    begin. Active grids are tested with the standard deviations that they state. None
    where too few pixels see three views for a test, or too many are far off.
    """
    if all(view.every_pixel for view in views):
        alike_px = DECODER_PX
    else:
        alike_px = np.sqrt(np.median([_cell_area(view) for view in views]))
        views = [interpolated_view(view, "by need")[0] for view in views]
    area = sum(view.area() for view in views)
    apart = min(OBSERVATIONS, area / alike_px**2)
    samples = sample_boards(views, width, height, apart)
    sigma = None
    if all(view.every_pixel and view.sd is not None for view in views):
        u, v = samples.pixels.T
        sigma = np.stack([view.sigma[v, u] for view in views])
    T_base_camera = inverse_pose(T_camera_grid[0])
    start = T_base_camera[:3, 3], T_base_camera @ T_camera_grid
    try:
        return centrality_test(samples.points, samples.seen, *start, sigma=sigma)
    except CalibrationError:
        return None


def _cell_area(view):
    """Mean area of the cells of a view, px^2."""
    return view.area() / ((view.columns - 1) * (view.rows - 1))
