"""Formulas fitted to drawn corners: stated deviations, boards, faults that are told."""

import numpy as np

from raxel.calibration.parametric.lens_formula import calibrate_lens
from raxel.calibration.parametric.lens_laws import imaged_points
from raxel.calibration.parametric.pinhole import calibrate_pinhole
from raxel.calibration.views.board_shape import BoardShape
from raxel.calibration.views.correspondence import BoardView
from raxel.cameras import KannalaBrandtCamera, PerspectiveCamera
from raxel.evaluation.board_corners import board_corners
from raxel.evaluation.cross_validation import evaluate_camera
from raxel.evaluation.stability import stability
from raxel.evaluation.wrong_corners import without_wrong_corners
from raxel.geometry.poses import cross_matrix, pose, rotation_from_vector, transform

WHAT = (
    "corners drawn with 0.1 px of noise on 14 boards of 10 x 7 squares of 24 mm, seen "
    "by a pinhole (fitted as `zhang`) and by a fisheye (as `kannala-brandt`); counted "
    "are both focal lengths of each set"
)
TITLES = {
    "sets": "Sets",
    "rms": "RMS of errors over stated",
    "rays_px": "Rays off (px, median)",
    "rays_over_stated": "Rays off over stated (median)",
    "shape": "Sets whose board's shape is used",
    "corners": "Sets whose board's corners lie elsewhere",
    "halves": "Sets whose halves disagree",
    "focal": "Sets whose focal lengths alone differ",
    "erratic": "Sets whose photographs differ",
    "odd": "Sets with one odd photograph",
}
SIZE, COUNT, NOISE_PX = (1280, 960), 14, 0.1
SETS = {"pinhole": 40, "fisheye": 20}
MORE = 3  # times as many sets where standard deviations are to be those of the errors
BOARD = 24.0 * np.stack(np.meshgrid(np.arange(10), np.arange(7)), -1).reshape(-1, 2)
MIDDLE, HALF = BOARD.mean(axis=0), np.ptp(BOARD, axis=0) / 2
DENT, DENT_MM, ROW = np.array([72.0, 96.0]), 40.0, 4  # middle, radius; which row is off
TOGETHER_MM = 80.0  # over which corners of a photograph err alike
COPIED = 0.3  # of the noise: what near copies of a photograph differ by
STEP_PX = 64  # between pixels whose rays are compared
SEED = 25_301


def camera_of(kind, longer=1.0):
    """The camera that is looked through, its focal length times `longer`."""
    if kind == "pinhole":
        K = [[1040 * longer, 0, 655.0], [0, 1037 * longer, 468.0], [0, 0, 1]]
        return PerspectiveCamera(K, [-0.22, 0.07], *SIZE)
    focal = 405.0 * longer, 406.0 * longer
    return KannalaBrandtCamera([1, -0.025, 0.003, -6e-4], focal, (628.0, 489.0), *SIZE)


def poses(rng, kind):
    """Poses of boards all over the image, tilted and turned, without end."""
    camera = camera_of(kind)
    near, far = (380, 700) if kind == "pinhole" else (190, 380)
    while True:
        pixel = rng.uniform(0.12, 0.88, 2) * SIZE
        sight = camera.rays(pixel[None]).directions[0]
        across = np.cross([0.0, 0.0, 1.0], sight)
        angle = np.arctan2(np.linalg.norm(across), sight[2])
        facing = rotation_from_vector(across / np.linalg.norm(across) * angle)
        around, tilt = rng.uniform(0, 2 * np.pi), rng.uniform(0.2, 0.7)
        tilted = rotation_from_vector(
            tilt * np.array([np.cos(around), np.sin(around), 0])
        )
        R = facing @ tilted @ rotation_from_vector([0, 0, rng.uniform(-np.pi, np.pi)])
        yield pose(R, rng.uniform(near, far) * sight - R @ [*MIDDLE, 0.0])


def drawn(rng, kind, *, shape=(0, 0, 0, 0), together_px=0.0, other=1.0, in_order=True,
          moves_mm=0.0, wrong=0.0, dent_mm=0.0, row_mm=0.0, cropped_px=0.0,
          copies=1):  # fmt: skip
    """BoardViews of one set; shape: values of a BoardShape; together_px: SD of what
    neighbouring corners share; other: focal length of the second half's camera over the
    first's; in_order: whether that half comes after the first, or mixed with it;
    moves_mm: motion from the first row to the last, each board's own way;
    wrong: share of corners that are several px off; dent_mm: depth of a dent; row_mm:
    how far one row is printed along x from where it should be; cropped_px: of the first
    photograph, at its left; copies: how often each photograph is there."""
    solid = BoardShape(MIDDLE, HALF, np.array(shape, float)).points(BOARD)
    far = np.linalg.norm(BOARD - DENT, axis=1) / DENT_MM
    solid[:, 2] += dent_mm * np.exp(-(far**2) / 2)
    solid[10 * ROW : 10 * (ROW + 1), 0] += row_mm
    gaps = np.linalg.norm(BOARD[:, None] - BOARD, axis=2) / TOGETHER_MM
    alike = np.linalg.cholesky(np.exp(-(gaps**2) / 2) + 1e-8 * np.eye(len(BOARD)))
    views, placed = [], poses(rng, kind)
    place = np.arange(COUNT) if in_order else rng.permutation(COUNT)
    while len(views) < COUNT:
        camera = camera_of(kind, other if place[len(views)] >= COUNT // 2 else 1.0)
        points, way = transform(next(placed), solid), rng.normal(size=3)
        way *= moves_mm / np.linalg.norm(way)
        pixels = camera.project(points).pixels
        for _ in range(5 * bool(moves_mm)):
            time = pixels[:, 1:] / SIZE[1] - 0.5
            pixels = camera.project(points + time * way).pixels
        if not camera.in_image(np.nan_to_num(pixels, nan=-1.0)).all():
            continue
        pixels = pixels + NOISE_PX * rng.normal(size=pixels.shape)
        pixels += together_px * alike @ rng.normal(size=pixels.shape)
        off = rng.random(len(pixels)) < wrong
        pixels[off] += 5 * rng.normal(size=(np.count_nonzero(off), 2))
        pixels[:, 0] -= cropped_px * (not views)
        views.append(BoardView(pixels, BOARD, 10, 7, f"{len(views)}.png"))
    if copies == 1:
        return views
    own = COPIED * NOISE_PX * rng.normal(size=(copies, COUNT, *pixels.shape))
    return [
        view._replace(pixels=view.pixels + own[k, n], name=f"{n}-{k}.png")
        for n, view in enumerate(views)
        for k in range(copies)
    ]


def fitted(views, kind):
    """The calibration of one set."""
    if kind == "pinhole":
        found = calibrate_pinhole(views, *SIZE)
        right = without_wrong_corners(found.camera, views, taken(found))
        return calibrate_pinhole(right.views, *SIZE) if right.wrong else found
    return calibrate_lens(views, *SIZE, "kannala-brandt")


def taken(found):
    """The BoardShape that the fit took, None for a board that is as stated."""
    return found.board.taken if found.board.used else None


def rays_off(found, true):
    """(RMS distance in px between where both see rays, over the image after the best
    rotation; the same as the covariance states it)."""
    u, v = (np.arange(STEP_PX / 2, size, STEP_PX) for size in SIZE)
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    rays = true.rays(pixels).directions
    # Beyond the boards' reach a formula is no measurement.
    seen = imaged_points(found.formula, found.values, rays)
    turns = -seen.by_points @ cross_matrix(rays)
    basis, _ = np.linalg.qr(turns.reshape(-1, 3))
    off, by_values = (
        (seen.pixels - pixels).ravel(),
        seen.by_values.reshape(len(basis), -1),
    )
    off = off - basis @ (basis.T @ off)
    by_values = by_values - basis @ (basis.T @ by_values)
    stated = np.einsum("ni,ij,nj->n", by_values, found.covariance, by_values)
    return np.sqrt(2 * np.mean(off**2)), np.sqrt(2 * np.mean(stated))


def one_set(seed, kind, **how):
    """What is counted of one set."""
    views, true = drawn(np.random.default_rng(seed), kind, **how), camera_of(kind)
    found = fitted(views, kind)
    shape = taken(found)
    scores = evaluate_camera(found.camera, views, shape)
    halves = stability(found.camera, scores.images, views, shape)
    focal = true.K[[0, 1], [0, 1]] if kind == "pinhole" else true.pixels_per_unit
    sd = np.sqrt(np.diag(found.covariance)[:2])
    return {
        "errors": (found.values[:2] - focal) / sd,
        "rays": rays_off(found, true),
        "shape": bool(found.board.used),
        "corners": not board_corners(
            found.camera, scores.images, views, shape
        ).as_stated,
        "halves": not halves.same_camera,
        "focal": halves.same_camera and not halves.one_focal,
        "erratic": not halves.steady,
        "odd": halves.odd is not None,
    }


CASES = {
    "sound": {},
    "corners err together by 0.1 px": {"together_px": 0.1},
    "board bent by 1 mm along x": {"shape": (1, 0, 0, 0)},
    "board bent by 0.6, -0.4 mm, twisted by 0.5": {"shape": (0.6, -0.4, 0.5, 0)},
    "board 0.5 % longer along x": {"shape": (0, 0, 0, 0.005)},
    "two cameras, 2 % apart": {"other": 1.02},
    "shutter, 2 mm of motion a frame": {"moves_mm": 2.0},
    "5 % of corners wrong": {"wrong": 0.05},
    "two cameras, 2 % apart, mixed at random": {"other": 1.02, "in_order": False},
    "two cameras, 1 % apart, mixed at random": {"other": 1.01, "in_order": False},
    "board with a dent of 0.5 mm": {"dent_mm": 0.5},
    "one row of the board off by 0.5 mm": {"row_mm": 0.5},
    "one photograph cropped by 20 px": {"cropped_px": 20.0},
    "each photograph three times": {"copies": 3},
}
SOUND = "sound", "corners err together by 0.1 px"


def measured():
    """A row for each case and camera."""
    for number, (case, how) in enumerate(CASES.items()):
        for kind, sets in SETS.items():
            first = SEED + 1000 * number
            sets *= MORE if case in SOUND else 1
            found = [one_set(first + k, kind, **how) for k in range(sets)]
            errors = np.abs(np.concatenate([each["errors"] for each in found]))
            rays, stated = np.array([each["rays"] for each in found]).T
            row = {"case": f"{case}, {kind}", "sets": sets, "count": len(errors)}
            for k in (1, 2, 3):
                row[f"within{k}"] = 100 * np.mean(errors <= k)
            row |= {
                "ratio": 1.4826 * np.median(errors),
                "rms": np.sqrt(np.mean(errors**2)),
                "rays_px": np.median(rays),
                "rays_over_stated": np.median(rays / stated),
            }
            for name in ("shape", "corners", "halves", "focal", "erratic", "odd"):
                row[name] = sum(each[name] for each in found)
            yield row
