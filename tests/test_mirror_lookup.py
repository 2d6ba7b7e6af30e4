"""A mirror's shape by its boundary: exact on entries, near between, told beyond."""

from itertools import pairwise

import numpy as np
import pytest

from raxel.calibration.mirror.lookup import (
    SAME_DEG,
    BoundaryTable,
    _sees_alike,
    described,
)
from raxel.calibration.mirror.sightings import normalised
from raxel.cameras import PerspectiveCamera, SplineMirrorCamera
from raxel.errors import InputError
from raxel.geometry.poses import transform
from raxel.geometry.spline_grid import spline_grid
from tests.bent_mirror_scenes import (
    T_VIEWER_MIRROR,
    VIEWER,
    bent,
    force_pixel,
    heights_at,
    spline_like,
    visible_pixels,
)

ENTRIES = (0.0, 2.0, 4.0, 6.0)
SHARES = np.linspace(-1, 1, 40)


def edges(deflection, lifted=0.0):
    """Edges (4, 40, 2) px of the sheet; lifted: mm by which a corner is raised."""
    sheet, found = bent(deflection).mirror, []
    x, y, ones = 79.9 * SHARES, 49.9 * SHARES, np.ones(40)
    for across, along in ((x, -49.9 * ones), (x, 49.9 * ones), (-79.9 * ones, y),
                          (79.9 * ones, y)):  # fmt: skip
        places = np.column_stack([across, along]) / sheet.radius
        points = sheet.point(places)[0]
        points[:, 2] += lifted * np.clip(across / 80, 0, 1) * along / 50
        found.append(VIEWER.project(transform(T_VIEWER_MIRROR, points)).pixels)
    return np.stack(found)


@pytest.fixture(scope="module")
def cameras():
    """Splines of the entries on the same knots, over all that the sheet covers."""
    box = np.concatenate([visible_pixels(d, 60, 40) for d in ENTRIES])
    grid = spline_grid(normalised(VIEWER, box), (7, 3))
    found = []
    for deflection in ENTRIES:
        points = bent(deflection).rays(visible_pixels(deflection, 60, 40)).origins
        points = points[np.isfinite(points[:, 0])]
        found.append(SplineMirrorCamera.fitted(VIEWER, grid, points, "inverse depth"))
    return found


@pytest.fixture(scope="module")
def table(cameras):
    return BoundaryTable([edges(d) for d in ENTRIES], cameras)


def found_height(found, deflection):
    return heights_at(found.camera, force_pixel(deflection))[0]


def test_an_entry_is_found_again_exactly(table, cameras):
    for number, deflection in enumerate(ENTRIES):
        found = table.look_up(edges(deflection))
        assert found.place == pytest.approx(number, abs=1e-9)
        assert found.off_px < 1e-9
        assert found.flags == ()
        np.testing.assert_allclose(
            found.camera.coefficients, cameras[number].coefficients, rtol=1e-12
        )


def test_between_entries_a_shape_is_near_and_with_noise_nearly_so(table):
    rng = np.random.default_rng(0)
    for deflection in (1.0, 2.7, 5.0):
        exact = table.look_up(edges(deflection))
        assert exact.off_px < 0.2
        assert found_height(exact, deflection) == pytest.approx(deflection, abs=0.02)
        traced = edges(deflection)
        traced = table.look_up(traced + rng.normal(0, 0.5, traced.shape))
        assert traced.flags == ()
        assert found_height(traced, deflection) == pytest.approx(deflection, abs=0.08)


@pytest.mark.parametrize(("deflection", "lifted"), [(8.0, 0.0), (4.0, 3.0)])
def test_what_the_table_lacks_is_told(table, deflection, lifted):
    found = table.look_up(edges(deflection, lifted))
    assert found.off_px > 1.5
    assert "shape that the table lacks" in found.flags[0]
    assert 0 <= found.place <= len(ENTRIES) - 1


def test_points_along_an_edge_do_not_matter_and_bad_boundaries_are_refused(table):
    few, many = described(edges(3.0)[:, ::3]), described(edges(3.0)[:, :40])
    assert np.abs(few[:17] - many[:17])[0].max() < 1e-9
    for wrong in (edges(3.0)[:3], np.full((4, 5, 2), np.nan), np.zeros((4, 1, 2))):
        with pytest.raises(InputError, match="give four edges"):
            table.look_up(wrong)


def test_entries_need_the_same_knots_and_a_neighbour(cameras):
    other = spline_like(bent(2.0), 2.0)
    with pytest.raises(InputError, match="camera 1 has other knots"):
        BoundaryTable([edges(0.0), edges(2.0)], [cameras[0], other])
    with pytest.raises(InputError, match="found 1 boundaries and 1 cameras"):
        BoundaryTable([edges(0.0)], cameras[:1])


def test_shapes_of_another_viewer_are_refused(cameras):
    K = VIEWER.K * [[1.001, 1, 1], [1, 1, 1], [1, 1, 1]]
    other = PerspectiveCamera(K, VIEWER.radial, VIEWER.width, VIEWER.height)
    first, second = cameras[:2]
    moved = SplineMirrorCamera.on_grid(
        other, second.grid, second.coefficients.ravel("F"), second.quantity
    )
    with pytest.raises(InputError, match="camera 1 has another viewer"):
        BoundaryTable([edges(0.0), edges(2.0)], [first, moved])


@pytest.mark.parametrize(("times", "alike"), [(0.5, True), (2.0, False)])
def test_viewers_are_alike_to_a_millionth_of_a_degree(times, alike):
    moved = VIEWER.K.copy()
    moved[0, 2] += VIEWER.K[0, 0] * np.radians(times * SAME_DEG)
    other = PerspectiveCamera(moved, VIEWER.radial, VIEWER.width, VIEWER.height)
    assert _sees_alike(VIEWER, other) == alike


def test_a_boundary_is_as_far_off_as_its_points_are(cameras):
    """The table's ones differ along u; off them it is 3 px along v."""
    first = edges(0.0)
    table = BoundaryTable([first, first + [2.0, 0.0]], cameras[:2])
    found = table.look_up(first + [1.0, 3.0], noise_px=1.0)
    assert found.off_px == pytest.approx(3.0)
    assert found.place == pytest.approx(0.5)
    assert not found.flags
    assert len(table.look_up(first + [1.0, 3.2], noise_px=1.0).flags) == 1


@pytest.mark.parametrize(
    ("told", "noise_px"), [({}, 0.5), ({"noise_px": 0.1}, 0.1), ({"noise_px": 2}, 2.0)]
)
def test_a_boundary_is_lacking_from_three_times_the_noise_of_its_points(
    cameras, told, noise_px
):
    first = edges(0.0)
    table = BoundaryTable([first, first + [2.0, 0.0]], cameras[:2])
    for off, count in ((2.9 * noise_px, 0), (3.1 * noise_px, 1)):
        assert len(table.look_up(first + [1.0, off], **told).flags) == count


def test_a_boundary_is_described_alike_however_densely_it_is_traced():
    even = np.linspace(0, 1, 30)
    corners = np.array([[10.0, 20], [200, 30], [190, 140], [15, 150], [10, 20]])

    def traced(places):
        return [a + places[:, None] * (b - a) for a, b in pairwise(corners)]

    np.testing.assert_allclose(described(traced(even**3)), described(traced(even)))
