"""Does a lens's pupil move, and does a law end on a lens that it contains?

Boards of 10 x 10 corners at random poses before drawn lenses, seen by corners with
noise. Central lenses of four laws say how often a pupil is said to move that rests; the
same lenses with a pupil that moves, how often that is found.
"""

import numpy as np

from raxel.calibration import calibrate_lens
from raxel.cameras import PerspectiveCamera
from raxel.geometry.poses import rotation_from_vector
from tests.lens_scenes import SIZE, boards

WHAT = (
    "14 boards of 100 corners before drawn lenses, whose pupil rests or moves; a "
    "perspective lens with distortion by the unified law"
)
TITLES = {
    "count": "Sets",
    "moves": "Pupil moves",
    "undecided": "Undecided",
    "rests": "Rests",
    "shift_over_sd": "Shift over its SD",
    "off_px": "Off over the image, at most (px)",
}
SEED = 20_261_123
BOARDS = 14
LAWS = "perspective", "equidistant", "unified", "field of view"
FITTED = "kannala-brandt", "unified"
NOISES_PX = 0.0, 0.1
LENSES = 10  # of each law, for either noise
# Of theta^2, mm: of 180 mm boards seen from 220 to 420 mm.
MOVING_MM = 3.0, 6.0
DRAWS = 15  # of parameters, to see how far off they are said to be
NAMES = "moves", "undecided", "rests"


class DrawnLens:
    """A lens seen along its axis: radius(theta), its pupil at a theta^2 mm on it."""

    def __init__(self, radius, focal, centre, reach, shift=0.0):
        self._radius, self._focal, self._centre = radius, focal, np.array(centre)
        self._reach, self._shift = reach, shift

    def project(self, points):
        """Pixels (N, 2) of points (N, 3) in the camera's frame, and which are seen."""
        rho = np.hypot(points[:, 0], points[:, 1])
        theta = np.arctan2(rho, points[:, 2])
        for _ in range(40):
            theta = np.arctan2(rho, points[:, 2] - self._shift * theta**2)
        along = points[:, :2] / np.maximum(rho, 1e-12)[:, None]
        pixels = self._focal * self._radius(theta)[:, None] * along + self._centre
        return pixels, theta < self._reach

    def in_image(self, pixels):
        """Which of the pixels (N, 2) lie in the picture."""
        return np.all((pixels > -0.5) & (pixels < np.array(SIZE) - 0.5), axis=1)


def drawn_lens(law, rng, shift=0.0):
    """(DrawnLens, angles from the axis at which the boards' middles lie)"""
    centre = np.array(SIZE) / 2 + rng.normal(0, 12, 2)
    oblong = np.array([1.0, 1 + rng.normal(0, 0.003)])
    if law == "perspective":
        focal = rng.uniform(600, 1500)
        k = rng.uniform([-0.25, -0.03], [0.1, 0.03])
        wide = min(640 / focal, 1.0)
        k[0] *= (wide * focal / 640) ** 2

        def radius(theta):
            s = np.tan(np.minimum(theta, 1.3))
            return s * (1 + k[0] * s**2 + k[1] * s**4)

        reach, angles = 1.2, (0.0, min(0.35, 0.36 * 640 / focal))
    elif law == "equidistant":
        focal = rng.uniform(270, 330)
        k = rng.uniform([-0.06, -0.006, -0.001], [0.02, 0.008, 0.001])

        def radius(theta):
            return theta * (1 + k[0] * theta**2 + k[1] * theta**4 + k[2] * theta**6)

        reach, angles = 2.5, (0.0, 1.3)
    elif law == "unified":
        focal, xi = rng.uniform(225, 315), rng.uniform(0.6, 1.6)

        def radius(theta):
            return (1 + xi) * np.sin(theta) / (np.cos(theta) + xi)

        rim = np.arccos(-1 / xi) - 0.1 if xi > 1 else np.arccos(-xi) - 0.3
        reach, angles = min(2.0, rim), (0.0, 1.0)
    else:
        focal, wide = rng.uniform(350, 480), rng.uniform(0.8, 1.1)

        def radius(theta):
            rise = 2 * np.tan(np.minimum(theta, 1.5)) * np.tan(wide / 2)
            return np.arctan(rise) / wide

        reach, angles = 1.35, (0.0, 0.8)
    return DrawnLens(radius, focal * oblong, centre, reach, shift), angles


def pupil_tests(law, shift, noise, seed, lenses):
    """A PupilTest of each drawn lens of a law by each fitted law."""
    found = []
    for k in range(lenses):
        rng = np.random.default_rng([seed, LAWS.index(law), k])
        lens, angles = drawn_lens(law, rng, shift)
        views = boards(lens, BOARDS, angles, int(rng.integers(2**31)), noise)
        found += [calibrate_lens(views, *SIZE, fitted).pupil for fitted in FITTED]
    return found


def counted(case, found):
    """A row: how often which was said, and the shifts found in their deviations."""
    said = [test.verdict for test in found]
    times = np.array([test.shift / test.shift_sd for test in found])
    times = times[np.isfinite(times)]
    return {
        "case": case,
        "count": len(found),
        **{name: said.count(name) for name in NAMES},
        "shift_over_sd": float(np.median(times)) if len(times) else None,
        "off_px": None,
        "ratio": None,
    }


def perspective_row(noise, seed, lenses=5):
    """A row: how far the unified law is off over the image of perspective lenses."""
    off, stated = [], []
    for k in range(lenses):
        rng = np.random.default_rng([seed, len(LAWS), k])
        focal = rng.uniform(600, 1500)
        K = [[focal, 0, 640], [0, focal, 480], [0, 0, 1]]
        true = PerspectiveCamera(K, rng.uniform([-0.25, -0.03], [0.1, 0.03]), *SIZE)
        views = boards(true, BOARDS, (0.0, 230 / focal), k, noise)
        found = calibrate_lens(views, *SIZE, "unified", pupil="fixed")
        off.append(apart_px(found.camera, true))
        drawn = rng.multivariate_normal(found.values, found.covariance, DRAWS)
        cameras = [found.formula.camera(values, *SIZE) for values in drawn]
        stated.append(np.median([apart_px(one, found.camera) for one in cameras]))
    ratio = None if noise == 0 else float(np.median(np.divide(off, stated)))
    return {
        "case": f"a perspective lens by the unified law, noise {noise:g} px",
        "count": lenses,
        **dict.fromkeys(NAMES),
        "shift_over_sd": None,
        "off_px": float(np.max(off)),
        "ratio": ratio,
    }


def apart_px(camera, other):
    """RMS distance over the image between where two cameras see the same rays, after
    the best small rotation."""
    u, v = (np.linspace(0, side - 1, 25) for side in SIZE)
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    rays = other.rays(pixels).directions

    def seen(turn):
        return camera.project(rays @ rotation_from_vector(turn).T).pixels

    off = (seen(np.zeros(3)) - pixels).ravel()
    turns = np.stack([(seen(t) - seen(-t)).ravel() for t in 1e-5 * np.eye(3)], axis=1)
    known = np.isfinite(off) & np.isfinite(turns).all(axis=1)
    off, turns = off[known], turns[known]
    left = off - turns @ np.linalg.lstsq(turns, off, rcond=None)[0]
    return float(np.sqrt(2 * np.mean(left**2)))


def measured(seed=SEED, lenses=LENSES):
    """Rows; see the package."""
    for noise in NOISES_PX:
        for law in LAWS:
            case = f"central, {law}, noise {noise:g} px"
            yield counted(case, pupil_tests(law, 0.0, noise, seed, lenses))
    for shift in MOVING_MM:
        for law in LAWS:
            case = f"pupil {shift:g} mm theta^2, {law}, noise {NOISES_PX[1]:g} px"
            yield counted(
                case, pupil_tests(law, shift, NOISES_PX[1], seed, lenses // 2)
            )
    for noise in NOISES_PX:
        yield perspective_row(noise, seed)
