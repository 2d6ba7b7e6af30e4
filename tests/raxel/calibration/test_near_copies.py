"""Photographs that show the board where another one does."""

import numpy as np

from raxel.calibration.views.correspondence import near_copies
from tests.board_scenes import board_poses, views_of


def test_near_copy_refers_to_first_similar_image():
    views = views_of(board_poses(1, 4))
    radius = np.sqrt(np.mean(np.var(views[1].pixels, axis=0)))

    def moved(times):
        shift = times * radius * np.array([0.6, -0.8])
        return views[1]._replace(pixels=views[1].pixels + shift)

    near, far = moved(0.013), moved(0.015)
    assert list(near_copies([*views, near, far])) == [0, 1, 2, 3, 1, 5]
    # Of a board of which another part was found nothing is known.
    part, rest = views[1].pixels.copy(), views[1].pixels.copy()
    part[70:], rest[:60] = np.nan, np.nan
    halves = [views[1]._replace(pixels=pixels) for pixels in (part, rest)]
    assert list(near_copies(halves)) == [0, 1]
    few = views[1]._replace(pixels=part[:60], rows=5, columns=12)
    assert list(near_copies([views[1], few])) == [0, 1]
