"""Measured blur, and valid pixels next to borders that it crosses."""

from dataclasses import replace
from functools import cache

import cv2
import numpy as np
import pytest
from scipy.special import ndtri

from raxel.features.active_grid import decode
from raxel.features.active_grid.coding import ImageStack
from raxel.features.active_grid.errors import Noise, measured_blur
from raxel.sets import PatternPlan
from tests.active_grids import drawn

BLURS, NOISES = (0.5, 1.0, 2.0, 3.0, 4.0), (1.0, 3.0, 8.0)
BEYOND = 20  # px around the image, so that its border is blurred correctly
TILTED = {"tilt": 0.3, "vignetting": 1.0, "seed": 1}


def rendered(size=(320, 240), share=0.75, **options):
    """Return a Scene as `drawn`, with blur across the image's border."""
    wide, high = (side + 2 * BEYOND for side in size)
    scene = drawn(size=(wide, high), share=share * size[0] / wide, **TILTED, **options)
    inner = np.s_[BEYOND:-BEYOND, BEYOND:-BEYOND]
    return replace(
        scene,
        images=np.ascontiguousarray(scene.images[:, *inner]),
        true=scene.true[inner],
        white=scene.white[inner],
        black=scene.black[inner],
    )


@cache
def decoded(blur, noise, share):
    scene = rendered(blur=blur, noise=noise, share=share)
    return scene, decode(scene.images, scene.patterns, scene.grid)


def outermost(mask, width=3):
    """Return pixels of the mask near its end or the image's border."""
    inside = cv2.erode(
        np.pad(mask.astype(np.uint8), 1), np.ones((2 * width + 1,) * 2, np.uint8)
    )
    return mask & ~inside[1:-1, 1:-1].astype(bool)


@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("blur", BLURS)
def test_blur_is_measured(blur, noise):
    """Noise hides a blur below one pixel."""
    found = decoded(blur, noise, 0.75)[1].blur_px
    assert found == pytest.approx(blur, abs=0.15 if blur < 1 else 0.08)


@pytest.mark.parametrize("share", [0.75, 1.05])
@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("blur", BLURS)
def test_border_pixels_have_correct_sigma(blur, noise, share):
    """With the monitor's border in the image, and partly just outside."""
    scene, found = decoded(blur, noise, share)
    ratio = np.abs(found.location - scene.true) / found.sigma
    assert not found.mask[np.isnan(scene.true[..., 0])].any()
    border = ratio[outermost(found.mask)]
    assert len(border) > 1500
    assert np.mean(border.max(axis=1) > 6) < 0.001
    # The bias of blur is known for ten by seven blocks. Where that is many
    # standard deviations, no factor of it lets two thirds be within one (`bias`).
    assert 0.58 < np.mean(ratio[found.mask] < 1) < 0.82
    # No more is excluded than windows, blur and its light can affect.
    assert found.margin_px <= max(6, 4 + 5 * found.blur_px)


@pytest.mark.parametrize("power", [0.45, 2.2])
def test_blur_is_measured_behind_tone_curve(power):
    scene = rendered(blur=2.0, noise=1.0)
    images = np.rint(255 * (scene.images / 255) ** power).astype(np.uint8)
    assert 1.9 < decode(images, scene.patterns, scene.grid).blur_px < 3.0


def test_blur_of_worst_area_is_returned():
    """One corner out of focus."""
    sharp, soft = (rendered(blur=blur, noise=1.0) for blur in (0.7, 3.0))
    images = sharp.images.copy()
    images[:, 160:, 214:] = soft.images[:, 160:, 214:]
    found = decode(images, sharp.patterns, sharp.grid)
    assert found.blur_px == pytest.approx(3.0, abs=0.3)


@pytest.mark.parametrize("smooth", [True, False])
def test_given_blur_and_margin_are_used(smooth):
    scene = rendered(blur=1.0, noise=1.0)
    found = decode(scene.images, scene.patterns, scene.grid, blur_px=3, smooth=smooth)
    assert (found.blur_px, found.margin_px) == (3, 15 + 3 * smooth)
    found = decode(scene.images, scene.patterns, scene.grid, margin_px=2, smooth=smooth)
    assert found.margin_px == 2


@pytest.mark.parametrize(
    "plan", [PatternPlan((4, 4), True), PatternPlan((3, 3), False, 4, (8.0, 8.0))]
)
def test_blur_is_measured_without_phases_or_inverses(plan):
    scene = rendered(blur=2.0, noise=2.0, plan=plan)
    found = decode(
        scene.images, scene.patterns, scene.grid, white=scene.white, black=scene.black
    )
    assert found.blur_px == pytest.approx(2.0, abs=0.1)


def test_blur_is_unknown_without_gray_code():
    scene = rendered(blur=2.0, noise=1.0, plan=PatternPlan((0, 0), True, 4, (1, 1)))
    found = decode(scene.images, scene.patterns, scene.grid)
    assert (found.blur_px, found.margin_px) == (None, 6)
    assert found.mask.mean() > 0.3


def test_spill_width_depends_on_dark_noise():
    """Photons make more of it where it is bright; what is read there is dark."""
    scene = rendered(blur=2.0, noise=1.0)
    stack = ImageStack(scene.images, scene.patterns, scene.grid.monitor_px, None, None)
    found = measured_blur(stack, Noise(0.0, 1.0, 0.1))
    on = np.isfinite(scene.true[..., 0])
    dark = np.median(scene.black[on])
    contrast = np.median(scene.white[on].astype(float) - scene.black[on])
    share = 7 * np.sqrt(dark) / contrast
    assert found.spill_px == pytest.approx(-found.px * ndtri(share), rel=0.08)
