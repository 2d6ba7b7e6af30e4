"""Trials of this page, their conditions and constants."""

import numpy as np
from scipy.integrate import solve_ivp

from chapters.shared.mirror import (
    CLAMP_PICKS,
    PUBLISHED,
    STAGES_MM,
    lattice,
    load_height,
    mirror_rig,
    outline,
)
from raxel.calibration import (
    Clamp,
    HeightCurve,
    RayPoints,
    clamp_line,
    clamp_of_camera,
    clamped,
    normalised,
    orthogonality_rows,
    refine_shape,
    reflected,
    reflection_normals,
    shape_up_to_scale,
    shape_with_clamp,
    update_mirror,
    viewing_rays,
)
from raxel.cameras import BeamProfile, ElasticaProfile, SplineMirrorCamera
from raxel.errors import CalibrationError
from raxel.geometry import spline_grid

# Fixed points picked in the image, unchanged and refined to a line.


# Standard deviations, px: of a pick, of one that was moved onto the edge, of a corner.
PICK_SD_PX, ON_EDGE_SD_PX, CORNER_SD_PX = 1.0, 0.1, 0.2
# px between the pixels that the first shape is fitted to.
FITTED_PX = 48
# Origin of the fixed value: the registry's options of clamp_value.
VALUES = {"at the pick": "pick", "of the fixed point": "point"}


def edge_trial(condition, rng):
    """Error of the estimated deflection, mm, after 5 mm, with picks and with a line;
    NaN where the stage is rejected.

    The first shape is the spline nearest to the true one, so that only corners and
    fixed points have errors.
    """
    rig = mirror_rig("A")
    first, second = (rig.camera(mm) for mm in STAGES_MM[:2])
    fixed = rig.clamp_pixels(first, CLAMP_PICKS)
    picks = fixed + PICK_SD_PX * rng.standard_normal(fixed.shape)
    onto_edge = fixed + ON_EDGE_SD_PX * rng.standard_normal(fixed.shape)
    before = nearest_spline(rig, first, np.concatenate([fixed, picks, onto_edge]))
    line = clamp_line(rig.viewer, onto_edge).points(CLAMP_PICKS)
    places = {"picked": normalised(rig.viewer, picks), "refined": line}
    T = rig.board_pose(rng, deflections=STAGES_MM[:2])
    images = [corners(rig, camera, T, rng) for camera in (first, second)]
    start = load_height(rig, before, first)
    out = {}
    for known in VALUES.values():
        for name, at in places.items():
            pixels = rig.viewer.project(np.column_stack([at, np.ones(len(at))])).pixels
            held = clamp_of_camera(before, pixels, slope=False)
            if known == "point":
                true = clamp_of_camera(before, fixed, slope=False)
                held = Clamp(held.points, true.values)
            out[f"{known}.{name}_mm"] = abs(
                travelled(rig, before, second, images, held) - start - STAGES_MM[1]
            )
    return out


def travelled(rig, before, true, images, held):
    """Estimated height at the load, mm; NaN where the stage is rejected."""
    try:
        found = update_mirror(
            before,
            *images,
            rig.board.points(),
            held,
            PUBLISHED.settings,
            outline=outline(true),
        )
    except CalibrationError:
        return np.nan
    return load_height(rig, found.camera, true)


def nearest_spline(rig, true, picks):
    """The published spline nearest to a true mirror, over its whole image and the
    pixels (N, 2) picked along its clamp."""
    edges = np.concatenate([outline(true), picks])
    grid = spline_grid(normalised(rig.viewer, edges), PUBLISHED.shape)
    points = true.rays(lattice(true, FITTED_PX)).origins
    return SplineMirrorCamera.fitted(rig.viewer, grid, points, PUBLISHED.quantity)


def corners(rig, camera, T_camera_board, rng):
    """Pixels of the board's corners with noise, NaN where not seen."""
    pixels, seen = rig.corners(camera, T_camera_board)
    noise = CORNER_SD_PX * rng.standard_normal(pixels.shape)
    return np.where(seen[:, None], pixels + noise, np.nan)


# Section 5.1: a bent mirror in the plane of its bending.


LENGTH_MM, ANGLE_DEG = 420.0, 67.5
FOOT = np.array([-160.0, 400.0])
SPAN = (-0.38, 0.38)
TIP_MM, SCENE_MM = 16.7, 800.0
ANCHORS = (0.9, 1.0, 1.1)
SLOPES2 = (0.001, 0.0036, 0.01, 0.02, 0.036, 0.06, 0.1, 0.2, 0.4)
FAR_DEPTHS = tuple(float(z) for z in np.geomspace(10, 100, 7))
"""Depths of distant scenes, in camera distances."""
DEFECT_RAD = 1e-3
DEFECT_DEPTHS_MM = (250.0, 500.0, 1000.0, 2500.0, 5000.0, 10000.0)
ALONG = np.array([np.sin(np.radians(ANGLE_DEG)), np.cos(np.radians(ANGLE_DEG))])
STEP = 1e-5


def curve(tip):
    """The mirror, bent by a force at its free edge (5.1)."""
    heights = tip / 2 * np.array([0.0, 0.0, 3.0, -1.0])
    return HeightCurve(heights, FOOT, ALONG, LENGTH_MM)


def beam_trial(condition, rng):
    """Largest difference of elastica and cubic, over the deflection of the cubic's tip.

    slope2: largest squared slope of the cubic, 3/2 of tip over length. By the same
    force, and bent to the same deflection where the force acts.
    """
    tip = np.sqrt(condition["slope2"]) * LENGTH_MM / 1.5
    beam = BeamProfile.deflected(LENGTH_MM, tip)
    bent = {
        "same_force": ElasticaProfile(LENGTH_MM, beam.forces),
        "same_deflection": ElasticaProfile.deflected(LENGTH_MM, tip),
    }
    out = {"tip_mm": float(tip)}
    for name, elastica in bent.items():
        x = np.linspace(0, float(elastica.places[0]), 401)
        apart = elastica.at(x)[0] - beam.at(x)[0]
        out[name] = float(np.abs(apart).max() / tip)
    return out


def anchored(u, points_at, start):
    """Distances (N,) along viewing rays u of the curve that reflects them to points.

    points_at: u -> scene point (2,); start: distance at u[0]. The normal halves the
    angle between viewing ray and the way to the point, and the curve is at right angles
    to it: a differential equation of first order, with one curve for every start.
    """

    def slope(at, D):
        V, V_u = viewing_rays([at])
        to = points_at(at) - D[0] * V[0]
        N = V[0] - to / np.linalg.norm(to)
        return [-D[0] * (V_u[0] @ N) / (V[0] @ N)]

    ends = (u[0], u[-1])
    return solve_ivp(slope, ends, [start], t_eval=u, rtol=1e-12, atol=1e-11).y[0]


def shapes_trial(condition, rng):
    """Mirrors anchored at several distances that show the same points on the same rays.

    offset_mm: farthest that a point lies from its scene ray, with tangents taken by
    differences of the curve. beyond_scale_mm: RMS distance from the true curve along
    the rays, after the best common factor.
    """
    true = curve(TIP_MM)

    def points_at(u):
        return true.points([u])[0] + SCENE_MM * true.scene_rays([u])[0]

    u = np.linspace(*SPAN, 41)
    inner = np.linspace(SPAN[0] + 0.01, SPAN[1] - 0.01, 41)
    around = np.concatenate([[SPAN[0]], *[[v - STEP, v, v + STEP] for v in inner]])
    points = np.array([points_at(v) for v in inner])
    D_true = true.distances(inner)
    out = {"points": points, "true": true.points(u)}
    for number, factor in enumerate(ANCHORS):
        start = factor * true.distances([SPAN[0]])[0]
        D = anchored(around, points_at, start)[1:].reshape(-1, 3)
        V = [viewing_rays(inner + step)[0] for step in (-STEP, 0.0, STEP)]
        before, S, after = (D[:, [k]] * V[k] for k in range(3))
        V_r = reflected(V[1], after - before)
        to = points - S
        scale = (D[:, 1] @ D_true) / (D_true @ D_true)
        out[f"anchor_{number}"] = {
            "factor": factor,
            "offset_mm": float(
                np.abs(V_r[:, 0] * to[:, 1] - V_r[:, 1] * to[:, 0]).max()
            ),
            "beyond_scale_mm": float(np.sqrt(np.mean((D[:, 1] - scale * D_true) ** 2))),
            "curve": S,
        }
    return out


def far_trial(condition, rng):
    """Mean angle between the scene rays of the same points before and after bending.

    depth: of the points, from the mirror, in distances of the camera from its middle.
    Before bending the mirror is flat, and each point has an image behind it.
    """
    bent, flat = curve(TIP_MM), curve(0.0)
    distance = float(np.linalg.norm(FOOT + LENGTH_MM / 2 * ALONG))
    u = np.linspace(SPAN[0] + 0.05, SPAN[1] - 0.05, 15)
    after = bent.scene_rays(u)
    points = bent.points(u) + condition["depth"] * distance * after
    away = np.array([-ALONG[1], ALONG[0]])
    image = points + 2 * ((FOOT - points) @ away)[:, None] * away
    before = flat.scene_rays(image[:, 0] / image[:, 1])
    sine = after[:, 0] * before[:, 1] - after[:, 1] * before[:, 0]
    return {"angle_deg": float(np.degrees(np.mean(np.abs(np.arcsin(sine)))))}


def defect_trial(condition, rng):
    """Displacement, mm, of the visible point by a defect of 1 mrad of the mirror.

    On a plane orthogonal to the scene ray, ``depth`` mm from the mirror.
    """
    bent = curve(TIP_MM)
    u = np.linspace(*SPAN, 15)
    V, tangents = viewing_rays(u)[0], bent.tangents(u)
    c, s = np.cos(DEFECT_RAD), np.sin(DEFECT_RAD)
    turned = tangents @ np.array([[c, s], [-s, c]])
    good, bad = reflected(V, tangents), reflected(V, turned)
    cosine = np.einsum("ij,ij->i", good, bad)
    moved = condition["depth"] * np.sqrt(1 / cosine**2 - 1)
    return {"moved_mm": float(np.mean(moved))}


# Section 5.1: mirrors that are exact splines, and what directions determine.


QUANTITY, SHAPE = "distance", (7, 3)
CORNERS = np.array([[-0.2, -0.15], [0.2, 0.15]])
DEPTH_MM, TILT_DEG, SPLINES_TIP_MM = 400.0, (50.0, 70.0), (5.0, 20.0)
MANY, SPLINES_SCENE_MM = 80, (300.0, 600.0)
START_OFF = 0.01
PAIRS = (8, 9, 10, 11, 14, 21, 60)
RANK = 1e-9
"""Of the largest singular value: what lies below is rounding."""
ENDS = {"u": 0, "v": 1}


def draw_mirror(rng, shape=SHAPE):
    """A SplineGrid over the image and coefficients (K,): a bent and twisted plane.

    The plane is rotated about the clamped edge, along y, and bent by a beam's cubic
    with a tip that differs along the edge. The nearest spline is the mirror.
    """
    grid = spline_grid(CORNERS, shape)
    tilt = np.radians(rng.uniform(*TILT_DEG))
    tip, twist = rng.uniform(*SPLINES_TIP_MM), rng.uniform(-0.3, 0.3)
    p = draw_pixels(rng, 20 * grid.size)
    along = (p[:, 0] - CORNERS[0, 0]) / np.ptp(CORNERS[:, 0])
    bend = tip * (1 + twist * p[:, 1] / CORNERS[1, 1])
    depth = DEPTH_MM / (1 - p[:, 0] / np.tan(tilt)) + bend * (3 - along) * along**2 / 2
    distance = depth * np.sqrt(1 + np.sum(p**2, axis=1))
    return grid, np.linalg.lstsq(grid.rows(p)[0], distance, rcond=None)[0]


def draw_pixels(rng, count):
    """Normalised image coordinates (count, 2), uniform over the mirror's image."""
    return rng.uniform(*CORNERS, (count, 2))


def spread_pixels(rng, count, grid):
    """Coordinates (count, 2) that use all knot intervals along u in turn.

    Both halves along v as well; within these cells at random.
    """
    low, high = grid.breaks[0][:-1], grid.breaks[0][1:]
    cell = np.arange(count)
    u = rng.uniform(low[cell % len(low)], high[cell % len(low)])
    half = (cell // len(low)) % 2
    share = (half + rng.uniform(0, 1, count)) / 2
    return np.column_stack([u, CORNERS[0, 1] + share * np.ptp(CORNERS[:, 1])])


def equations(p, grid, c):
    """The rows of (5.15, 5.16), with normals of the true viewing and scene rays."""
    rays = RayPoints(p, grid, QUANTITY)
    normals = reflection_normals(rays.viewing, rays.surface(c)[1])
    return orthogonality_rows(p, normals, grid, QUANTITY), normals


def singular(A):
    """Singular values of a matrix whose columns are brought to one length first."""
    length = np.linalg.norm(A, axis=0)
    return np.linalg.svd(A / np.where(length > 0, length, 1.0), compute_uv=False)


def rank_of(A):
    """Numerical rank, with columns of one length."""
    size = singular(A)
    return int(np.count_nonzero(size > RANK * size[0]))


def depth_trial(condition, rng):
    """Rank of the equations, and how far their null vector is from the true mirror."""
    grid, c = draw_mirror(rng)
    p = draw_pixels(rng, MANY)
    A, normals = equations(p, grid, c)
    size = singular(A)
    found = shape_up_to_scale(p, normals, grid, QUANTITY)
    return {
        "open": grid.size - rank_of(A),
        "off": float(np.linalg.norm(found - c / np.linalg.norm(c))),
        "last": float(size[-1] / size[0]),
        "last_but_one": float(size[-2] / size[0]),
    }


def fixed_trial(condition, rng):
    """One fixed point of the mirror: rank, and errors of both stages, without noise."""
    grid, c = draw_mirror(rng)
    p = draw_pixels(rng, MANY)
    A, normals = equations(p, grid, c)
    at = np.array([[CORNERS[0, 0], rng.uniform(*CORNERS[:, 1])]])
    clamp = Clamp(at, grid.rows(at)[0] @ c)
    space = clamped(grid, clamp)
    linear = shape_with_clamp(p, normals, grid, QUANTITY, clamp)
    S, V_r = RayPoints(p, grid, QUANTITY).surface(c)
    points = S + rng.uniform(*SPLINES_SCENE_MM, (MANY, 1)) * V_r
    start = c * (1 + START_OFF * rng.standard_normal(len(c)) / 10)
    refined = refine_shape(
        p, points, grid, QUANTITY, start, noise=1e-4, clamp=clamp
    ).coefficients
    return {
        "open": space.directions.shape[1] - rank_of(A @ space.directions),
        "linear_mm": float(np.abs(linear - c).max()),
        "refined_mm": float(np.abs(refined - c).max()),
        "start_mm": float(np.abs(start - c).max()),
    }


def pairs_trial(condition, rng):
    """Rank of the equations of so many pairs of rays, well spread or at random."""
    grid, c = draw_mirror(rng)
    count = condition["pairs"]
    sets = {
        "spread": spread_pixels(rng, count, grid),
        "random": draw_pixels(rng, count),
    }
    ranks = {name: rank_of(equations(p, grid, c)[0]) for name, p in sets.items()}
    return ranks | {"size": grid.size}


def ends_trial(condition, rng):
    """Rank with all features, and without those of an end interval.

    reciprocal: last singular value but one over the first, one over the condition.
    """
    grid, c = draw_mirror(rng, tuple(condition["shape"]))
    p = draw_pixels(rng, 8 * MANY)
    axis = ENDS[condition["axis"]]
    intervals = grid.intervals(p)[:, axis]
    end = intervals.max() if condition["end"] == "last" else 0
    out = {"size": grid.size}
    for name, kept in (("all", p), ("without", p[intervals != end])):
        A, _ = equations(kept, grid, c)
        size = singular(A)
        out[name] = {"rank": rank_of(A), "reciprocal": float(size[-2] / size[0])}
    return out
