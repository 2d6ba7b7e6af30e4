"""Detectors side by side on the same images, in one run: counts, times and ratios."""

import statistics
import time
from typing import NamedTuple

from raxel.errors import InputError
from raxel.evaluation.reference_corners import corner_errors, is_right
from raxel.features import DETECTORS
from raxel.features.boards import check_chessboard
from raxel.sets.image_files import read_image
from raxel.sets.model import Charuco
from raxel.sets.reference import load_reference

REPEATS = 5
# A detector that takes this long on one image is not asked again.
ENOUGH_SECONDS = 2.0
PEER = "opencv"
GIVEN, NOT_GIVEN = "given", "not given"


class DetectorScore(NamedTuple):
    """One detector on one set.

    `size` says whether it was told how many corners the board has. `right` and `wrong`
    are boards within and beyond the tolerance of their reference corners, `unjudged`
    boards without a reference, `refused` images in which it returns none. `median_ms`
    is the median over images of the best time, `ratio` that time over the peer's.
    """

    detector: str
    size: str
    images: int
    right: int
    wrong: int
    unjudged: int
    refused: int
    median_ms: float
    ratio: float


def bench_detectors(image_set, say=None):
    """Scores of all detectors on the views of an ImageSet.

    Each image is given to one detector after the other, at most `REPEATS` times, of
    which the best counts. raxel also runs without the size.
    `say` is told one line per image. Raises InputError as `check_bench`.
    """
    check_bench(image_set)
    reference = load_reference(image_set)
    runs = {run: [] for run in _runs()}
    for number, view in enumerate(image_set.views, 1):
        image = read_image(image_set, view)
        for run in runs:
            runs[run].append(_one(run, image, image_set.target, reference, view))
        if say:
            say(f"{number}/{len(image_set.views)} {view.label}")
    times = {run: statistics.median(ms for _, ms in done) for run, done in runs.items()}
    peer = times[PEER, GIVEN]
    return [
        DetectorScore(*run, *_counts(done), times[run], times[run] / peer)
        for run, done in runs.items()
    ]


def check_bench(image_set):
    """Raise InputError unless every detector can be run on the whole set.

    It needs a chessboard of known size, and images and reference that can be read.
    """
    check_chessboard(image_set)
    if isinstance(image_set.target, Charuco):
        raise InputError(
            f"{image_set.description}: target.kind: found charuco, but detectors are "
            "compared on plain chessboards; give such a set"
        )
    if image_set.target.columns is None:
        raise InputError(
            f"{image_set.description}: target.columns: found null, but detectors are "
            "compared on a board of known size; give columns and rows"
        )
    load_reference(image_set)
    for view in image_set.views:
        read_image(image_set, view)


def _runs():
    """(detector, size) of every run; of those that can count, raxel runs untold.

    OpenCV's sector-based detector can count as well, but takes seconds to do so.
    """
    told = [(name, GIVEN) for name in DETECTORS]
    return [*told, ("raxel", NOT_GIVEN)]


def _one(run, image, board, reference, view):
    """(outcome, best ms) of one detector on one image."""
    name, size = run
    counts = (board.columns, board.rows) if size == GIVEN else (None, None)
    best, spent = float("inf"), 0.0
    for _ in range(REPEATS):
        started = time.perf_counter()
        detection = DETECTORS[name](image, *counts)
        seconds = time.perf_counter() - started
        best, spent = min(best, seconds), spent + seconds
        if spent > ENOUGH_SECONDS:
            break
    return _outcome(detection, reference.get(view.image)), 1000 * best


def _outcome(detection, reference):
    if not detection.found:
        return "refused"
    if reference is None:
        return "unjudged"
    right = is_right(corner_errors(detection, reference), reference)
    return "right" if right else "wrong"


def _counts(done):
    outcomes = [outcome for outcome, _ in done]
    names = "right", "wrong", "unjudged", "refused"
    return len(outcomes), *(outcomes.count(name) for name in names)
