"""Rays meet surfaces where the formulas say; scenes keep what is nearest."""

import numpy as np
import pytest

from raxel.geometry import inverse_pose, pose, rotation_from_vector, transform
from raxel.lab import Disc, ImageTexture, Plain, Rectangle, TexturedScene, facade, room
from raxel.lab.scenes import _column
from raxel.lab.surfaces import Cylinder, Relief, box
from raxel.lab.textures import ChessboardTexture, Panels, Tiles
from tests.raised import raises_line

T = pose(rotation_from_vector([0.4, -0.3, 0.8]), [20.0, -35, 50])


def random_rays(seed=0, count=4000, spread=150.0):
    rng = np.random.default_rng(seed)
    origins = rng.normal(0, spread, (count, 3))
    directions = transform(T, rng.normal(0, 25, (count, 3))) - origins
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


def met_points(surface, origins, directions):
    """(hit, which rays hit, where they do in the surface's frame)."""
    hit = surface.hit(origins, directions)
    visible = np.isfinite(hit.distance)
    assert 0.05 < visible.mean() < 0.95
    points = (origins + hit.distance[:, None] * directions)[visible]
    return hit, visible, transform(inverse_pose(T), points)


def test_rectangle_hits_from_both_sides():
    rectangle = Rectangle(T, 40, 30, (-10, -20))
    origins, directions = random_rays()
    hit, visible, points = met_points(rectangle, origins, directions)
    np.testing.assert_allclose(points[:, 2], 0, atol=1e-11)
    np.testing.assert_allclose(points[:, :2], hit.uv[visible], atol=1e-11)
    assert (points[:, :2] >= [-10, -20]).all()
    assert (points[:, :2] <= [30, 10]).all()
    np.testing.assert_allclose(hit.cosine, directions @ T[:3, 2], atol=1e-12)
    sides = rectangle.outline
    np.testing.assert_allclose(
        np.linalg.norm(sides[:, 1] - sides[:, 0], axis=1), [40, 30, 40, 30]
    )


def test_disc_with_hole():
    origins, directions = random_rays(1)
    hit, visible, points = met_points(Disc(T, 30, 12), origins, directions)
    radius = np.hypot(*points[:, :2].T)
    np.testing.assert_allclose(points[:, 2], 0, atol=1e-11)
    assert radius.max() <= 30
    assert radius.min() >= 12
    np.testing.assert_allclose(points[:, :2], hit.uv[visible], atol=1e-11)


def test_cylinder_hits_nearest_first():
    cylinder = Cylinder(T, 17.0, 40.0)
    origins, directions = random_rays(2)
    hit, visible, points = met_points(cylinder, origins, directions)
    np.testing.assert_allclose(np.hypot(*points[:, :2].T), 17, atol=1e-10)
    assert (points[:, 2] >= 0).all()
    assert (points[:, 2] <= 40).all()
    uv = np.column_stack([17 * np.arctan2(points[:, 1], points[:, 0]), points[:, 2]])
    np.testing.assert_allclose(uv, hit.uv[visible], atol=1e-9)
    inside = cylinder.hit(transform(T, np.array([[0, 0, 20.0]])), directions)
    across = np.linalg.norm(np.cross(directions, T[:3, 2]), axis=1)
    steep = across > 0.8
    np.testing.assert_allclose((inside.distance * across)[steep], 17, rtol=1e-12)
    assert (inside.cosine[steep] > 0).all()


def height_at(relief, x, y):
    j, i = np.minimum(y.astype(int), 8), np.minimum(x.astype(int), 10)
    fx, fy, h = x - i, y - j, relief.heights
    low = (1 - fx) * h[j, i] + fx * h[j, i + 1]
    return (1 - fy) * low + fy * ((1 - fx) * h[j + 1, i] + fx * h[j + 1, i + 1])


@pytest.mark.parametrize("steepness", [0.0, 1.0, 12.0])
def test_relief_hit_is_first_intersection(steepness):
    relief = Relief(T, steepness * np.random.default_rng(3).normal(0, 1, (10, 12)), 5.0)
    origins, directions = random_rays(4, 800)
    hit, visible, points = met_points(relief, origins, directions)
    heights = height_at(relief, *(points[:, :2].T / 5))
    np.testing.assert_allclose(points[:, 2], heights, atol=1e-9)
    # Walk along each ray: on which side it is must not change before the hit.
    local_o = transform(inverse_pose(T), origins)
    local_d = directions @ T[:3, :3]
    reach = np.where(visible, hit.distance * (1 - 1e-9), 600.0)
    walk = local_o[:, None] + (
        np.linspace(0, 1, 1500)[:, None] * reach[:, None, None] * local_d[:, None]
    )
    x, y, z = np.moveaxis(walk, -1, 0)
    over = (x >= 0) & (x <= 55) & (y >= 0) & (y <= 45)
    gap = z - height_at(relief, np.clip(x / 5, 0, 11), np.clip(y / 5, 0, 9))
    assert not (over[:, 1:] & over[:, :-1] & (gap[:, 1:] * gap[:, :-1] < -1e-9)).any()


def test_box_is_closed():
    faces = box(T, (30, 20, 10))
    scene = TexturedScene(tuple((face, Plain(0.5)) for face in faces))
    _, directions = random_rays(6)
    part, _, _ = scene.hit(transform(T, np.array([[15.0, 10, 5]])), directions)
    assert (part >= 0).all()
    assert len(np.unique(part)) == 6
    for face in faces:
        inside = transform(inverse_pose(T), face.outline.reshape(-1, 3))
        assert (inside > -1e-9).all()
        assert (inside < np.array([30, 20, 10]) + 1e-9).all()


def test_nearest_surface_is_visible():
    near, far = (Rectangle(pose(np.eye(3), [0, 0, z]), 10, 10) for z in (5, 9))
    for parts in ((near, far), (far, near)):
        scene = TexturedScene(tuple((surface, Plain(1.0)) for surface in parts))
        part, uv, cosine = scene.hit(np.array([[3.0, 4, 0]]), np.array([[0, 0, 1.0]]))
        assert scene.surfaces[part[0]] is near
        np.testing.assert_allclose(uv, [[3, 4]])
        assert cosine[0] == 1
    part, _, _ = scene.hit(np.array([[30.0, 4, 0]]), np.array([[0, 0, 1.0]]))
    assert part[0] == -1


@pytest.mark.parametrize("make", [room, facade])
def test_scenes_are_reproducible(make):
    scene, again = make(), make()
    np.testing.assert_array_equal(scene.straight_edges, again.straight_edges)
    assert scene.straight_edges.shape[1:] == (2, 3)
    # Points along an edge lie on a surface: a ray to it ends there or before.
    eye = np.array([[100.0, -200, -1500]])
    share = np.linspace(0.1, 0.9, 5)[:, None, None]
    a, b = scene.straight_edges[:, 0], scene.straight_edges[:, 1]
    points = ((1 - share) * a + share * b).reshape(-1, 3)
    distance = points - eye
    length = np.linalg.norm(distance, axis=1)
    nearest = np.full(len(points), np.inf)
    for surface in scene.surfaces:
        # A hair wider, as edges lie on borders.
        for jitter in ([0, 0, 0], [1e-6, 1e-6, 1e-6], [-1e-6, -1e-6, -1e-6]):
            aim = (distance + jitter) / length[:, None]
            nearest = np.minimum(nearest, surface.hit(eye, aim).distance)
    assert (nearest <= length + 1e-3).mean() > 0.98
    assert (np.abs(nearest - length) < 1e-3).mean() > 0.6


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (lambda: Rectangle(T, 0, 3), "rectangle: width: "),
        (lambda: Rectangle(np.eye(3), 1, 3), r"\(3, 3\)"),
        (lambda: Disc(T, -1), "disc: radius"),
        (lambda: Cylinder(T, 1, np.nan), "cylinder: height: .*nan"),
        (lambda: Relief(T, np.zeros((1, 4)), 1), r"relief: .*\(1, 4\)"),
        (lambda: Relief(T, np.full((2, 4), np.nan), 1), "relief: heights"),
        (lambda: box(T, (1, 2)), "box"),
        (lambda: ChessboardTexture(0, 3, 1, 1), "0 x 3 corners"),
        (lambda: ChessboardTexture(4, 3, -1, 1), "pitch -1"),
        (lambda: Tiles((1, 2), [0.1], joint=3), "joint 3"),
        (lambda: Panels(0.5, [(0, 0, 0, 1, 0.2)]), "panels"),
        (lambda: Plain((0.1, 0.2)), "colour"),
        (lambda: ImageTexture(np.zeros((3, 4)), 0), "0 mm per px"),
    ],
)
def test_invalid_surfaces_and_textures_are_rejected(function, words):
    with raises_line(words):
        function()


def test_flat_surface_hits_match_plane():
    rng = np.random.default_rng(8)
    T = pose(rotation_from_vector(rng.normal(size=3)), rng.normal(size=3))
    origins, directions = 9 * rng.normal(size=(400, 3)), rng.normal(size=(400, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    directions[7] = np.nan
    surface = Rectangle(T, 30, 20, (-15, -10))
    for some in (origins, origins[:1]):
        o, d = (some - T[:3, 3]) @ T[:3, :3], directions @ T[:3, :3]
        far = -o[:, 2] / d[:, 2]
        positions = o[:, :2] + far[:, None] * d[:, :2]
        on = (far > 0) & (np.abs(positions) <= [15, 10]).all(axis=1)
        hit = surface.hit(some, directions)
        np.testing.assert_array_equal(np.isfinite(hit.distance), on)
        np.testing.assert_allclose(hit.distance[on], far[on], rtol=1e-12)
        np.testing.assert_allclose(hit.uv[on], positions[on], rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(hit.cosine[on], d[on, 2], rtol=1e-12)


def test_image_texture_starts_at_origin():
    image = np.arange(12.0).reshape(3, 4)
    texture = ImageTexture(image, 2.0)
    row, column = np.indices(image.shape).reshape(2, -1)
    centres = 2.0 * (np.column_stack([column, row]) + 0.5)
    np.testing.assert_array_equal(texture.radiance(centres, 1.0), image.ravel())
    corner = texture.radiance(np.array([[2.0, 2.0]]), 1.0)
    assert corner == pytest.approx(image[:2, :2].mean())


@pytest.mark.parametrize(
    ("position", "met"), [((5, 12), True), ((5, 33), False), ((33, 5), False)]
)
def test_vertical_ray_hits_relief_only_inside(position, met):
    relief = Relief(np.eye(4), np.zeros((4, 3)), 10.0)  # 20 mm wide, 30 mm high
    hit = relief.hit(np.array([[*position, 50.0]]), np.array([[0.0, 0, -1]]))
    assert np.isfinite(hit.distance[0]) == met


def test_relief_cosine_matches_normal():
    """The normal is that of the plane through three places close together."""
    relief = Relief(T, np.array([[0.0, 1, 5], [2, 9, 3]]), 10.0)
    positions = np.array([[2.0, 7], [13, 3], [18, 8.5]])
    for position in positions:
        steps = np.array([[0, 0, 100], [1e-4, 0, 100], [0, 1e-4, 100]])
        origins = transform(T, np.append(position, 0) + [3, -5, 0] + steps)
        direction = T[:3, :3] @ [-3, 5, -100.0]
        direction /= np.linalg.norm(direction)
        hit = relief.hit(origins, np.tile(direction, (3, 1)))
        one, two, three = origins + hit.distance[:, None] * direction
        normal = np.cross(two - one, three - one)
        normal *= np.sign(normal @ T[:3, 2]) / np.linalg.norm(normal)
        np.testing.assert_allclose(hit.cosine[0], direction @ normal, atol=1e-5)


def test_column_stripes_are_periodic():
    ((column, texture),) = _column(np.zeros(3), 2700.0)
    u = np.pi * column.radius * np.linspace(-1, 1, 481)[:-1] + 0.1
    visible = texture.radiance(np.column_stack([u, np.full(480, 900.0)]), np.ones(480))
    each = visible.reshape(12, 40, -1)
    assert len(np.unique(each[0], axis=0)) == 2
    np.testing.assert_array_equal(each, np.broadcast_to(each[:1], each.shape))
