"""Chapter 3, what 3.3.2 depends on: light after rendering, orders, merging, parts."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from chapters.ch03_planar_grids.s3_2_conditions import experiment, page
from chapters.ch03_planar_grids.s3_2_conditions.claims import (
    judge_trace_direction,
    partial_predicates,
)
from chapters.ch03_planar_grids.s3_2_conditions.experiment import (
    Part,
    candidate_parts,
    detected,
    largest_part,
    merge_failed,
    ordered,
    painted,
    size_variation,
)
from chapters.ch03_planar_grids.s3_2_conditions.report import (
    logistic_curve,
    logistic_fit,
)
from chapters.shared.grids.rigs import HARD, WHOLE
from chapters.shared.grids.synthetic_board import outer
from raxel.lab.lighting import Blemishes, Shadow
from raxel.lab.scenes import board_scene
from raxel.lab.set_rendering import window_of
from tests.judged_claims import readings_of
from tests.made_results import OfLaw, of_columns


def drawn_lattice(rows=6, columns=8, growth=1.0):
    """A lattice (rows, columns, 2) whose steps along u grow by a ratio."""
    u = np.concatenate([[0], np.cumsum(20 * growth ** np.arange(columns - 1))])
    v = 30.0 * np.arange(rows)
    return np.stack(np.meshgrid(50 + u, 40 + v), axis=-1)


def even(places):
    """Light of one level."""
    return np.ones(len(places))


@pytest.fixture(scope="module")
def fisheye_sheet():
    return experiment.sheet_of("fisheye", np.random.default_rng(1))


def test_relighting_equals_rendering_with_the_light(fisheye_sheet):
    sheet = fisheye_sheet
    rig = sheet.rig
    corner, size = rig.extent
    light = rig.light.draw(np.random.default_rng(2), rig.extent)
    light = replace(light, level=0.5, shadow=Shadow(corner + 0.4 * size, 0.3, 60, 15))
    scene = board_scene(
        rig.target, sheet.T_camera_board, rig.border_mm, light=light, **rig.radiances
    )
    true = rig.laboratory().irradiance(
        scene, np.eye(4), window=window_of(rig, sheet.T_camera_board)
    )
    off = np.abs(experiment._lit(sheet, light) - true)
    assert np.median(off) < 1e-4
    # Most at the sheet's edge, where paper and room share a pixel.
    assert off.max() < 0.03 * true.max()


def test_cropped_image_keeps_the_corners_in_place(fisheye_sheet):
    image, lattice = experiment.cropped_image(fisheye_sheet, even)
    assert lattice.min() > 0
    assert np.all(lattice.reshape(-1, 2).max(axis=0) < image.shape[::-1])
    middles = (lattice[:-1, :-1] + lattice[1:, 1:]) / 2
    u, v = np.rint(middles).astype(int).transpose(2, 0, 1)
    signs = (-1.0) ** np.add.outer(*map(np.arange, u.shape))
    alternating = signs * (image[v, u].astype(float) - image[v, u].mean())
    assert np.all(alternating > 0) or np.all(alternating < 0)


def test_sheet_flaws_and_noise_follow_their_seeds(fisheye_sheet):
    spotted = Blemishes(200, (2, 4), (0.9, 0.9), (0.0, 0.0))
    sheet = fisheye_sheet._replace(rig=replace(fisheye_sheet.rig, blemishes=spotted))
    one, again, exposed, marked = (
        experiment.cropped_image(s, even)[0].astype(int)
        for s in (sheet, sheet, sheet._replace(exposure=1), sheet._replace(specimen=1))
    )
    np.testing.assert_array_equal(one, again)
    noise, flaws = np.abs(exposed - one), np.abs(marked - one)
    assert np.mean(noise > 0) > 0.2
    assert noise.max() < 30 < flaws.max()


def test_eight_orders_are_distinct_and_start_correctly():
    lattice = drawn_lattice()
    seen = set()
    for first in range(4):
        for reverse in (False, True):
            found = ordered(lattice, first, reverse)
            assert np.array_equal(found[0, 0], outer(lattice)[first])
            (ax, ay), (bx, by) = found[0, 1] - found[0, 0], found[1, 0] - found[0, 0]
            assert (ax * by > ay * bx) != reverse
            seen.add(found.tobytes())
    assert len(seen) == 8


def test_detection_requires_the_true_board(fisheye_sheet):
    image, lattice = experiment.cropped_image(fisheye_sheet, even)
    assert detected("raxel", image, lattice)
    assert detected("raxel", image, lattice[::-1, ::-1])
    assert not detected("raxel", image, lattice + 20)
    assert not detected("raxel", np.full_like(image, 90), lattice)


def contour_result(inliers, merged):
    contour = SimpleNamespace(name="side 1", inliers=inliers, merged=merged)
    return SimpleNamespace(contours=(contour,))


def test_merge_failure_is_a_lost_or_doubled_corner():
    lattice = drawn_lattice()
    side = lattice[0]
    assert not merge_failed(contour_result(side, side), lattice)
    assert not merge_failed(contour_result(side[1:], side[1:]), lattice)
    assert merge_failed(contour_result(side, side[1:]), lattice)
    split = np.vstack([side, side[2] + (2, 0)])
    assert merge_failed(contour_result(split, split), lattice)
    assert not merge_failed(None, lattice)


def test_size_variation_is_that_of_one_contour():
    assert size_variation(drawn_lattice(growth=1.2)) == pytest.approx(1.2**6)
    assert size_variation(drawn_lattice()) == pytest.approx(1)


def test_logistic_fit_recovers_slope_and_reports_no_fit():
    rng = np.random.default_rng(3)
    x = rng.uniform(1, 6, 20000)
    y = rng.random(len(x)) < 1 / (1 + np.exp(-(-3 + 0.8 * x)))
    slope, error, _ = logistic_fit(x, y)
    assert abs(slope - 0.8) < 4 * error
    assert error < 0.03
    assert logistic_curve(x, y, np.array([3.75]))[0] == pytest.approx(0.5, abs=0.02)
    few = np.arange(8.0)
    for without_fit in (np.zeros(8), few > 3):
        assert np.isnan(logistic_fit(few, without_fit)[0])


def test_candidate_parts_exclude_the_smallest_steps():
    lattice = drawn_lattice(growth=1.3)
    parts = candidate_parts(lattice, 0.95)
    assert parts[0] == Part(0, 5, 0, 7)
    counts = [part.count for part in parts]
    assert counts == sorted(counts, reverse=True)
    shortest = [np.diff(p.of(lattice)[0, :, 0]).min() for p in parts]
    assert shortest == sorted(shortest)
    assert parts[1].right == 7


def test_border_distance_counts_for_the_fisheye_only():
    def parts(celect, opencv):
        """The same part for both cameras, and its px to the frame in two images."""
        made = {}
        for who, (count, *frames) in (("celect", celect), ("opencv", opencv)):
            for camera, px in zip(("hyperboloidal", "fisheye"), frames, strict=True):
                found = {f"{who}.count": count, f"{who}.border_px": px}
                made[camera] = made.get(camera, {}) | found
        return of_columns(*(({"camera": camera}, of) for camera, of in made.items()))

    result = parts(celect=(20, [90, 90], [50, 70]), opencv=(10, [80, 80], [60, 60]))
    holds, ratios = partial_predicates(result, result, "opencv")
    assert holds.tolist() == [True, False]
    assert ratios.tolist() == [2, 2]
    small = parts(celect=(12, [9, 9], [5, 5]), opencv=(10, [80, 80], [60, 60]))
    assert not partial_predicates(small, small, "opencv")[0].any()


def test_trace_direction_without_differences_is_undecided():
    alike = OfLaw("exp_c3_trace_direction", lambda name, condition: np.ones(40), 40)
    readings = readings_of(judge_trace_direction, {"exp_c3_trace_direction": alike})
    assert [r.verdict for r in readings] == ["undecided"] * 2
    assert [r.reading["pose_range"] for r in readings] == [WHOLE, HARD]


def test_largest_part_search_ends_at_the_maximum():
    lattice = drawn_lattice(growth=1.1)

    def returns(part):
        return part.left >= 2

    # The coarse candidates pass by the largest part; added lines reach it.
    part, tries = largest_part(returns, lattice, 0.6)
    assert part == Part(0, 5, 2, 7)
    assert tries < 12
    assert largest_part(lambda part: False, lattice, 0.95)[0] is None


def test_paint_covers_all_but_the_squares_of_the_part(fisheye_sheet):
    sheet = fisheye_sheet
    camera = sheet.rig.camera
    grey = np.full((camera.height, camera.width), 100, np.uint8)
    part = Part(1, 3, 2, 5)
    image, corners = painted(sheet, grey, part)
    assert corners.shape == (3, 4, 2)
    u, v = np.rint(corners).astype(int).transpose(2, 0, 1)
    assert np.all(image[v, u] == 100)
    # Two squares beyond the part's corners all is white.
    assert np.all(image[[0, -1]] == 255)
    assert np.all(image[:, [0, -1]] == 255)
    area = (image == 100).sum()
    ring = sheet.lattice[0:5, 1:7]
    from cv2 import contourArea

    around = np.vstack([ring[0], ring[1:, -1], ring[-1, -2::-1], ring[-2:0:-1, 0]])
    assert area == pytest.approx(contourArea(around.astype(np.float32)), rel=0.06)


def test_surround_of_a_mirror_is_not_black():
    sheet = experiment.sheet_of("spherical", np.random.default_rng(3))
    light = replace(sheet.rig.light, surround=0.0)
    black = sheet._replace(rig=replace(sheet.rig, light=light))

    def corner_of(of):
        image = experiment.whole_image(of, lambda uv: np.ones(len(uv), np.float32))
        return image[:20, :20].mean()

    assert sheet.rig.light.surround > 0
    assert corner_of(sheet) > corner_of(black) + 10


def test_merging_studies_share_no_image():
    conditions = [plan("full").conditions for plan in (page.shadow, page.merge_images)]
    assert not [c for c in conditions[0] if c in conditions[1]]
    images = sum(len(c) * page.FISHEYE_IMAGES["full"] for c in conditions)
    assert images == 400
