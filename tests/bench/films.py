"""Processor time of a film of a bending mirror, pictures of 1280 x 960 in, shapes out.

Two rendered pictures of geometry A's small rig, to and fro. Beside the library's
corners, in the same run, stand OpenCV's alone: pyramidal flow from the corners before,
then cornerSubPix. That tells no corner that was lost or is another's, nor how sure one
is.
"""

import cv2
import numpy as np

from raxel.calibration import FilmTracker, MirrorSettings, MirrorTracker
from raxel.features.film import next_corners
from raxel.features.localise.subpix import opencv_subpix
from tests.bench.least import least_ms
from tests.film_scenes import film_scene

WIDTH, STEP_MM = 1280, 0.6
WANTED_PER_S = 10.0
# Half windows of OpenCV's flow and of cornerSubPix, px, for squares of 84 px.
FLOW_PX, SUBPIX_PX, LEVELS = 30, 12, 3


def bench_films(repeats=5):
    """{what: (ms of one core, error px)}: best of the runs; median distance from the
    true corners, None for what has none."""
    cv2.setNumThreads(1)
    scene = film_scene(WIDTH)
    frames = [scene.frame(0.0), scene.frame(STEP_MM)]
    camera = scene.spline()
    tracker = MirrorTracker(
        camera, scene.scene_points, scene.clamp(camera), MirrorSettings(prior_sd=0.1)
    )
    film = FilmTracker(tracker, frames[0].picture, frames[0].true, *scene.size)
    first, second = frames

    def corners():
        return next_corners(first.picture, second.picture, first.true, *scene.size)

    def whole():
        frames.reverse()
        film.follow(frames[0].picture)

    ours, theirs = corners().corners, by_opencv(first, second)
    # Both of the same corners, those that the library kept.
    off = [np.linalg.norm(found - second.true, axis=1) for found in (ours, theirs)]
    both = np.isfinite(off[0]) & np.isfinite(off[1])
    return {
        "corners": (least_ms(corners, repeats), np.median(off[0][both])),
        "corners and shape": (least_ms(whole, repeats), None),
        "OpenCV's corners": (
            least_ms(lambda: by_opencv(first, second), repeats),
            np.median(off[1][both]),
        ),
    }


def by_opencv(before, after):
    """Corners (N, 2) of the Frame after, from the true ones of that before."""
    seen = np.isfinite(before.true[:, 0])
    start = before.true[seen].astype(np.float32)
    went, known, _ = cv2.calcOpticalFlowPyrLK(
        before.picture,
        after.picture,
        start,
        None,
        winSize=(2 * FLOW_PX + 1,) * 2,
        maxLevel=LEVELS,
    )
    found = np.full(before.true.shape, np.nan)
    found[seen] = np.where(
        known == 1, opencv_subpix(after.picture, went, SUBPIX_PX), np.nan
    )
    return found


def films_table(taken):
    """Lines of text."""
    per_s = 1000 / taken["corners and shape"][0]
    lines = [
        f"film of {WIDTH} x {3 * WIDTH // 4}: {per_s:.0f} updates/s of one core, "
        f"{WANTED_PER_S:.0f} wanted",
        f"{'':<20}{'ms':>8}{'off (px)':>11}",
    ]
    return lines + [
        f"{what:<20}{ms:8.2f}" + ("" if off is None else f"{off:11.4f}")
        for what, (ms, off) in taken.items()
    ]


if __name__ == "__main__":
    print("\n".join(films_table(bench_films())))
