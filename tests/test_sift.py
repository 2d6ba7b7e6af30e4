"""Features matched between two pictures: right places, and one-line refusals."""

import cv2
import numpy as np
import pytest

from raxel.errors import InputError
from raxel.features.sift import match_features


def textured(seed=0):
    """A picture (240, 320) with texture of several sizes."""
    rng = np.random.default_rng(seed)
    image = sum(
        size * cv2.GaussianBlur(rng.normal(size=(240, 320)), (0, 0), size)
        for size in (2, 4, 8)
    )
    return np.clip(128 + 60 * image / image.std(), 0, 255).astype(np.uint8)


def test_features_of_a_moved_picture_are_found_where_it_went():
    A = np.array([[1.05, 0.08, 6.3], [-0.08, 1.05, 9.7]])
    first = textured()
    second = cv2.warpAffine(first, A, (320, 240), flags=cv2.INTER_CUBIC)
    found = match_features(first, second)
    moved = found.pixels[0] @ A[:, :2].T + A[:, 2]
    off = np.linalg.norm(moved - found.pixels[1], axis=1)
    assert len(off) > 60
    assert np.median(off) < 0.2
    assert np.mean(off < 2) > 0.95
    assert np.all(np.diff(found.ratio) >= 0)


@pytest.mark.parametrize(
    ("second", "said"),
    [
        (np.zeros((50, 50), np.uint8), "matches of"),
        (textured().astype(float), "float64"),
        (np.zeros((5, 5, 3), np.uint8), r"\(5, 5, 3\)"),
    ],
)
def test_pictures_without_matches_are_refused(second, said):
    with pytest.raises(InputError, match=said):
        match_features(textured(), second)
