"""One stage of dynamic calibration: accuracy, support, wrong matches, refusals."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from raxel.calibration.mirror import refine as edges
from raxel.calibration.mirror.clamp import bending_prior, clamp_of_camera, plane_through
from raxel.calibration.mirror.observations import (
    RayPoints,
    need_support,
    normalised,
    support_of,
    supported_grid,
)
from raxel.calibration.mirror.refine import (
    MAX_SWING_DEG,
    PRIOR_MM,
    ray_sd,
    turns_under_prior,
)
from raxel.calibration.mirror.update import (
    MISFIT_CORRELATION,
    MirrorSettings,
    _beyond_noise,
    linear_stage,
    update_from_scene,
    update_mirror,
)
from raxel.geometry import on_plane, spline_grid, transform
from tests.bent_mirror_scenes import (
    GRID,
    VIEWER,
    bent,
    edge_pixels,
    force_pixel,
    grid_pose,
    heights_at,
    seen,
    spline_like,
    visible_pixels,
)
from tests.raised import raises_code

T_GRID = grid_pose()
FLAT = spline_like(bent(0.0), 0.0)
CLAMP = clamp_of_camera(FLAT, edge_pixels())
BEFORE = seen(bent(0.0), T_GRID)
AFTER = seen(bent(5.0), T_GRID)
OUTLINE = visible_pixels(5.0, 2, 2)
PRIOR = MirrorSettings(prior_sd=0.1)
COMMON = np.isfinite(BEFORE + AFTER).all(axis=1)


def shaken(pixels, rng):
    return pixels + 0.2 * rng.standard_normal(pixels.shape)


def angles_deg(found, deflection):
    """Angles (N,) between found and true rays all over the mirror, degrees."""
    pixels = visible_pixels(deflection)
    ours, true = found.rays(pixels), bent(deflection).rays(pixels)
    both = ours.valid & true.valid
    assert both.mean() > 0.95
    gap = np.linalg.norm(ours.directions - true.directions, axis=1)[both]
    return np.degrees(2 * np.arcsin(gap / 2))


def deflection_error(camera, deflection=5.0):
    return abs(heights_at(camera, force_pixel(deflection))[0] / deflection - 1)


@pytest.mark.parametrize(
    ("quantity", "share", "degrees"),
    [("distance", 0.01, 0.08), ("inverse depth", 0.005, 0.04)],
)
def test_update_from_noisy_corners_is_accurate(quantity, share, degrees):
    rng = np.random.default_rng(0)
    flat = spline_like(bent(0.0), 0.0, quantity=quantity)
    clamp = clamp_of_camera(flat, edge_pixels())
    found = update_mirror(
        flat, shaken(BEFORE, rng), shaken(AFTER, rng), GRID, clamp, PRIOR,
        outline=OUTLINE,
    )  # fmt: skip
    assert deflection_error(found.camera) < share
    assert angles_deg(found.camera, 5.0).mean() < degrees
    # Near scene points make the linear stage take the deflection for less (5.2.2).
    assert 0.3 < heights_at(found.linear, force_pixel(5.0))[0] / 5 < 0.7
    assert np.nanmean(found.residuals) < 0.2
    assert found.fit.converged
    assert not found.wrong.any()
    assert np.count_nonzero(found.used) > 100
    assert np.abs(found.pose.T_camera_grid - T_GRID).max() < 0.5


def test_update_recovers_spline_mirror_without_noise():
    """Both stages are splines on knots over their own image."""
    after = seen(spline_like(bent(5.0), 5.0), T_GRID)
    found = update_mirror(FLAT, BEFORE, after, GRID, CLAMP, outline=OUTLINE)
    # The spline nearest to the bent sheet keeps its clamp to some micrometres.
    assert angles_deg(found.camera, 5.0).mean() < 0.03
    assert np.nanmax(found.residuals) < 0.15


@pytest.mark.parametrize("share", [0.1, 0.2])
def test_update_rejects_and_flags_wrong_matches(share):
    rng = np.random.default_rng(1)
    before, after = shaken(BEFORE, rng), shaken(AFTER, rng)
    rows = np.flatnonzero(COMMON)
    wrong = rng.permutation(rows)[: int(share * len(rows))]
    # A corner of another place, and for some the neighbour.
    after[wrong] = after[rng.permutation(rows)[: len(wrong)]]
    after[wrong[::3]] = after[np.minimum(wrong[::3] + 1, 181)]
    moved = wrong[np.linalg.norm(after - AFTER, axis=1)[wrong] > 10]
    found = update_mirror(FLAT, before, after, GRID, CLAMP, PRIOR, outline=OUTLINE)
    assert found.wrong[moved].all()
    assert np.count_nonzero(found.wrong) <= len(wrong) + 3
    assert any("wrong matches" in flag for flag in found.flags)
    assert deflection_error(found.camera) < 0.01
    assert angles_deg(found.camera, 5.0).mean() < 0.06


def test_known_scene_gives_shape_without_pose():
    rng = np.random.default_rng(2)
    scene = transform(T_GRID, on_plane(GRID))
    found = update_from_scene(
        FLAT, shaken(AFTER, rng), scene, CLAMP, PRIOR, outline=OUTLINE
    )
    assert deflection_error(found.camera) < 0.005
    assert found.pose is None


def test_missing_edge_features_are_rejected_or_flagged():
    u = FLAT.grid.turned(np.nan_to_num(BEFORE / 7600 - [0.203, 0.153]))[:, 0]
    near = np.where((u < 0.04)[:, None], AFTER, np.nan)
    with raises_code("no-feature-at-end"):
        update_mirror(FLAT, BEFORE, near, GRID, CLAMP, outline=OUTLINE)
    found = update_mirror(FLAT, BEFORE, near, GRID, CLAMP, PRIOR, outline=OUTLINE)
    assert any("last knot interval along u: determined" in flag for flag in found.flags)
    inner, outer = found.ray_sd(visible_pixels(5.0, 5, 3)[[6, 8]])
    assert outer > 3 * inner
    fewer = PRIOR._replace(fixed_shape=False)
    found = update_mirror(FLAT, BEFORE, near, GRID, CLAMP, fewer, outline=OUTLINE)
    assert found.camera.grid.shape[0] < 7
    assert not found.support.missing()


def test_support_counts_features_per_interval():
    grid = spline_grid([[0, 0], [1, 1]], (4, 3))
    p = np.array([[0.1, 0.5], [0.2, 0.9], [0.55, 0.2], [2, 2]])
    support = support_of(grid, p)
    np.testing.assert_array_equal(support.along_u, [2, 1])
    np.testing.assert_array_equal(support.cells, [[2], [1]])
    np.testing.assert_allclose(support.reach, [0.8, 0.1, 0.8, 0.9])
    assert support.missing() == []
    assert need_support(support) == ["the last knot interval along u (10 % of it): "
                                     "few features"]  # fmt: skip
    empty = support_of(grid, p[:2])
    with raises_code("no-feature-at-end"):
        need_support(empty)
    assert need_support(empty, clamp_at=("u", -1))[0].endswith("by the clamp")
    assert supported_grid([[0, 0], [1, 1]], p[:3], (7, 3)).shape == (3, 3)


def test_exchanged_images_and_few_corners_are_rejected():
    rng = np.random.default_rng(4)
    exchanged = shaken(AFTER, rng), shaken(BEFORE, rng)
    none = np.where(np.arange(182)[:, None] < 2, AFTER, np.nan)
    mixed = AFTER.copy()
    rows = np.flatnonzero(COMMON)[::2]
    mixed[rows] = AFTER[rng.permutation(rows)]
    for code, images, more in (
        ("exchanged-images", exchanged, {}),
        ("too-few-features", (BEFORE, none), {}),
        ("wrong-matches", (BEFORE, mixed), {"outline": OUTLINE}),
    ):
        with raises_code(code):
            update_mirror(FLAT, *images, GRID, CLAMP, PRIOR, **more)


@pytest.mark.parametrize("misfit", [0.0, 3e-4])
def test_misfit_is_ray_error_beyond_noise(misfit):
    """Noise of 0.1 mm and misfit, radians, at each of two components of a ray."""
    rng, reach = np.random.default_rng(13), reaches(4000)
    noise = 0.1 * rng.standard_normal((4000, 2))
    bends = misfit * np.linalg.norm(reach, axis=1)[:, None]
    off = np.pad(noise + bends * rng.standard_normal((4000, 2)), ((0, 0), (0, 1)))
    found, widening = _beyond_noise(SimpleNamespace(residuals=off, sd_mm=0.1), reach)
    assert found == pytest.approx(misfit, rel=0.05)
    beyond = np.mean(bends**2) / 0.1**2
    assert widening == pytest.approx(1 + MISFIT_CORRELATION * beyond, rel=0.05)


def reaches(count):
    """(count, 3) mm, from a mirror to points 250 to 350 mm away."""
    rng = np.random.default_rng(12)
    away = rng.normal(size=(count, 3))
    return (
        away / np.linalg.norm(away, axis=1)[:, None] * rng.uniform(250, 350, (count, 1))
    )


def test_undetermined_shape_is_rejected():
    """One feature in the last interval: rank, but no knowledge of the edge."""
    u = FLAT.grid.turned(np.nan_to_num(AFTER / 7600 - [0.203, 0.153]))[:, 0]
    order = np.argsort(np.where(COMMON, u, -1))
    kept = np.where((u < 0.02) | (np.arange(182) == order[-1]), 1.0, np.nan)
    with raises_code("open-coefficients"):
        update_mirror(FLAT, BEFORE, AFTER * kept[:, None], GRID, CLAMP, outline=OUTLINE)


def to_the_edge(reach, rng, swinging_deg=MAX_SWING_DEG, stage=update_mirror):
    """A stage as the thesis has it: distances, and the clamp's position alone.

    Corners reach into a share of the last knot interval, and lie aside by 0.5 px,
    neighbours alike.
    """
    flat = spline_like(bent(0.0), 0.0, quantity="distance")
    clamp = clamp_of_camera(flat, edge_pixels(), slope=False)
    aside = 0.5 * np.sin(GRID @ [[0.03, -0.03], [0.02, -0.02]])
    u = flat.grid.turned(np.nan_to_num(normalised(VIEWER, AFTER), nan=9.0))[:, 0]
    breaks = spline_like(bent(5.0), 5.0).grid.breaks[0]
    kept = u <= breaks[-2] + reach * (breaks[-1] - breaks[-2])
    after = np.where(kept[:, None], shaken(AFTER, rng), np.nan)
    before = shaken(BEFORE, rng) + aside
    settings = MirrorSettings(swinging_deg=swinging_deg)
    return stage(flat, before, after, GRID, clamp, settings, outline=OUTLINE)


def test_swinging_end_with_small_residuals_is_rejected():
    whole = to_the_edge(1.0, np.random.default_rng(7))
    assert not any("even bending" in flag for flag in whole.flags)
    assert angles_deg(whole.camera, 5.0).mean() < 0.1
    with raises_code("swinging-end"):
        to_the_edge(0.3, np.random.default_rng(7))
    wrong = to_the_edge(0.3, np.random.default_rng(7), np.inf)
    assert whole.swing_deg < 3 < MAX_SWING_DEG < wrong.swing_deg
    assert any("last knot interval along u: rays" in flag for flag in wrong.flags)
    # What it would have been: no residual tells, and the end is degrees off.
    assert np.nanmean(wrong.residuals) < 1.1 * np.nanmean(whole.residuals)
    assert angles_deg(wrong.camera, 5.0).max() > 4


def test_linear_stage_equals_that_of_update():
    shaken_by = partial(np.random.default_rng, 7)
    whole = to_the_edge(0.3, shaken_by(), np.inf).linear
    found = to_the_edge(0.3, shaken_by(), stage=linear_stage)
    np.testing.assert_array_equal(found.coefficients, whole.coefficients)
    assert (found.grid.shape, found.quantity) == (whole.grid.shape, "distance")
    pixels = visible_pixels(5.0)
    np.testing.assert_array_equal(*(c.rays(pixels).origins for c in (found, whole)))


def test_end_rotation_under_prior_measures_error():
    """A spline that swings at its free end by 0.002 of its inverse depth."""
    camera = spline_like(bent(5.0), 5.0)
    grid, even = camera.grid, camera.rays(visible_pixels(5.0)).origins
    even = even[np.isfinite(even[:, 0])]
    c = camera.coefficients.copy()
    c[-1] *= 1.002
    v = np.linspace(*grid.breaks[1][[0, -1]], 5)
    ends = grid.unturned(np.column_stack([np.full(5, grid.breaks[0][-1]), v]))
    rays = RayPoints(ends, grid, "inverse depth")
    swung, true = (rays.surface(C.ravel("F"))[1] for C in (c, camera.coefficients))
    off = np.degrees(np.linalg.norm(swung - true, axis=1)).mean()
    assert off > 3
    evenly = bending_prior(grid, "inverse depth", plane_through(even), PRIOR_MM)
    free = np.zeros(grid.shape)
    free[-1] = 1.0
    for known, share in ((1.0, 1.0), (1e-8, 0.0)):
        covariance = known * np.diag((0.1 * free * c).ravel("F") ** 2)
        turns = turns_under_prior(
            grid, "inverse depth", c.ravel("F"), covariance, evenly
        )  # fmt: skip
        # In micrometres, the prior says the same.
        small = evenly._replace(
            rows=1e3 * evenly.rows, values=1e3 * evenly.values, sd=1e3 * evenly.sd
        )
        same = turns_under_prior(grid, "inverse depth", c.ravel("F"), covariance, small)
        assert list(same.values()) == pytest.approx(list(turns.values()), rel=1e-6)
        assert turns[("u", -1, "last")] == pytest.approx(share * off, rel=0.2, abs=0.1)
        assert turns[("u", 0, "first")] < 0.1
        assert len(turns) == 2


def test_covariance_includes_grid_pose():
    """The same corners after: with the grid's place known, less is uncertain."""
    rng = np.random.default_rng(6)
    before, after = shaken(BEFORE, rng), shaken(AFTER, rng)
    found = update_mirror(FLAT, before, after, GRID, CLAMP, PRIOR, outline=OUTLINE)
    placed = transform(found.pose.T_camera_grid, on_plane(GRID))
    known = np.where(found.used[:, None], after, np.nan)
    sure = update_from_scene(FLAT, known, placed, CLAMP, PRIOR, outline=OUTLINE)
    np.testing.assert_allclose(sure.camera.coefficients, found.camera.coefficients,
                               rtol=1e-6)  # fmt: skip
    middle = normalised(VIEWER, visible_pixels(5.0, 5, 3)[7:8])
    spread, known = (
        ray_sd(middle, each.camera.grid, "inverse depth", each.fit.coefficients,
               each.fit.covariance)[0]
        for each in (found, sure)
    )  # fmt: skip
    assert spread > 1.1 * known


def test_ray_sd_predicts_errors():
    """The sheet is not a spline: misfit adds to noise; 1 would be exact."""
    squares, pixels, true = [], visible_pixels(5.0), bent(5.0)
    for seed in range(4):
        rng = np.random.default_rng(seed)
        found = update_mirror(
            FLAT, shaken(BEFORE, rng), shaken(AFTER, rng), GRID, CLAMP, PRIOR,
            outline=OUTLINE,
        )  # fmt: skip
        ours, theirs = found.camera.rays(pixels), true.rays(pixels)
        both = ours.valid & theirs.valid
        off = np.sum((ours.directions - theirs.directions)[both] ** 2, axis=1)
        squares.append(np.mean(off / (2 * found.ray_sd(pixels)[both] ** 2)))
        assert found.misfit > 0
        assert found.widening > 1
    assert 0.4 < np.mean(squares) < 2.5


@pytest.mark.parametrize(
    ("degrees", "verdict"), [(0.29, "none"), (0.31, "flagged"), (5.1, "rejected")]
)
def test_knot_uncertainty_thresholds(degrees, verdict, monkeypatch):
    grid = FLAT.grid

    def one_of_them(places, *_):
        return np.radians(np.where(np.arange(len(places)) == 3, degrees, 0.1))

    monkeypatch.setattr(edges, "ray_sd", one_of_them)
    if verdict == "rejected":
        with raises_code("uncertain-shape"):
            edges.uncertain_knots(grid, FLAT.quantity, None, None)
    else:
        flags = edges.uncertain_knots(grid, FLAT.quantity, None, None)
        assert len(flags) == (verdict == "flagged")
        assert all("deviation of 0.31 degrees" in flag for flag in flags)
