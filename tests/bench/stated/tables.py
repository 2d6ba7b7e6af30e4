"""Do halves of the photographs tell of one table of rays where there is one camera?"""

import numpy as np

from raxel.calibration import calibrate_cgsp, calibrate_generic
from raxel.evaluation.cross_validation import evaluate_camera
from raxel.evaluation.stability import stability
from raxel.geometry.planes import on_plane
from tests import board_scenes
from tests.test_evaluation_stability import BOARD, CAMERA, COUNT, OTHER, SIZE, views_of

WHAT = (
    "tables of rays from 12 or 14 boards: said to hang on the photographs where they "
    "do not, and where two cameras or a stretched board make them"
)
TITLES = {"count": "Sets", "unstable": "Said to be unstable"}
SEED = 311_000
SETS = {"cgsp": 10, "generic": 20}  # of either camera, sound
FAULTY = 6
NOISES_PX = 0.05, 0.1, 0.2, 0.4
STRETCH = np.array([1.005, 1.0])
METHODS = {"cgsp": calibrate_cgsp, "generic": calibrate_generic}


def stable(method, views, size):
    """Whether these views' table is said to be stable; None if nothing is said."""
    rng = np.random.default_rng(0)
    found = METHODS[method](views, *size, rng=rng)
    used = [views[k] for k in found.used]
    told = stability(found.camera, evaluate_camera(found.camera, used).images, used)
    return told and told.stable


def sound(seed, noise):
    """(views, size) of a pinhole and of a fisheye."""
    fisheye, poses = board_scenes.FISHEYE, board_scenes.board_poses(seed, 12)
    round_image = board_scenes.views_of(poses, noise=noise, seed=seed)
    yield views_of(COUNT * [CAMERA], seed, noise), SIZE
    yield round_image, (fisheye.width, fisheye.height)


def faulty(seed):
    """{fault: views}"""
    half = COUNT // 2
    return {
        "two cameras, 2 % apart": views_of(half * [CAMERA] + half * [OTHER], seed),
        "board stretched by 0.5 %": views_of(
            COUNT * [CAMERA], seed, solid=on_plane(STRETCH * BOARD)
        ),
    }


def measured(seed=SEED):
    """Rows; see the package."""
    for method, sets in SETS.items():
        told = [
            stable(method, *each)
            for k in range(sets)
            for each in sound(seed + k, NOISES_PX[k % len(NOISES_PX)])
        ]
        yield counted(f"{method}, sound", told)
        cases = [faulty(seed + k) for k in range(FAULTY)]
        for fault in cases[0]:
            told = [stable(method, case[fault], SIZE) for case in cases]
            yield counted(f"{method}, {fault}", told)


def counted(case, told):
    """A row: how many are said to be unstable, of those of which anything is."""
    told = [one for one in told if one is not None]
    return {"case": case, "count": len(told), "unstable": told.count(False)}
