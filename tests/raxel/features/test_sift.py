"""SIFT matches of two images: positions, and one-line rejections."""

import cv2
import numpy as np
import pytest

from raxel.errors import InputError
from raxel.features.sift import match_features


def textured(seed=0):
    """An image (240, 320) with texture of several sizes."""
    rng = np.random.default_rng(seed)
    image = sum(
        size * cv2.GaussianBlur(rng.normal(size=(240, 320)), (0, 0), size)
        for size in (2, 4, 8)
    )
    return np.clip(128 + 60 * image / image.std(), 0, 255).astype(np.uint8)


def test_sift_matches_follow_shifted_image():
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


def test_sift_prefers_more_similar_copy():
    """Matches are mutual nearest neighbours, so that no position has two."""
    second = textured()[:, :160]
    noise = np.random.default_rng(2).normal(0, 4, second.shape)
    again = np.clip(second + noise, 0, 255).astype(np.uint8)
    found = match_features(np.hstack([second, again]), second)
    assert len(found.ratio) > 60
    assert np.mean(found.pixels[0, :, 0] < 160) > 0.8


def test_sift_pixel_centres_are_at_integers():
    """A 180-degree rotation of an image rotates the positions about its centre.

    Those of an image of blobs are at the blobs.
    """
    first = textured(3)
    found = match_features(first, np.ascontiguousarray(first[::-1, ::-1]))
    middle = found.pixels.mean(axis=0)
    np.testing.assert_allclose(np.median(middle, axis=0), [159.5, 119.5], atol=0.02)
    v, u = np.mgrid[:240, :320]
    rng = np.random.default_rng(4)
    centres = np.stack(np.meshgrid(np.arange(30, 300, 40), np.arange(30, 220, 40)), -1)
    centres = centres.reshape(-1, 2) + rng.uniform(-5, 5, (35, 2))
    sizes = rng.uniform(3, 5, (35, 2))
    image = 60 + sum(
        rng.uniform(60, 150) * np.exp(-((u - x) ** 2 / a**2 + (v - y) ** 2 / b**2) / 2)
        for (x, y), (a, b) in zip(centres, sizes, strict=True)
    )
    image = np.clip(image, 0, 255).astype(np.uint8)
    places = match_features(image, image).pixels[0]
    apart = places[:, None] - centres
    nearest = np.argmin(np.linalg.norm(apart, axis=2), axis=1)
    off = apart[np.arange(len(places)), nearest]
    off = off[np.linalg.norm(off, axis=1) < 1]
    assert len(off) > 20
    np.testing.assert_allclose(np.median(off, axis=0), 0, atol=0.05)


@pytest.mark.parametrize(
    "options", [{"ratio": 0}, {"ratio": 1.0}, {"ratio": np.nan}, {"min_matches": 0}]
)
def test_sift_rejects_invalid_options(options):
    with pytest.raises(InputError, match="ratio"):
        match_features(textured(), textured(), **options)


@pytest.mark.parametrize(
    ("second", "message"),
    [
        (np.zeros((50, 50), np.uint8), " 0 matches"),
        (textured().astype(float), "float64"),
        (np.zeros((5, 5, 3), np.uint8), r"\(5, 5, 3\)"),
    ],
)
def test_sift_rejects_images_without_matches(second, message):
    with pytest.raises(InputError, match=message):
        match_features(textured(), second)
