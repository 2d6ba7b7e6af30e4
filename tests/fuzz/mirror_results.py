"""Results of a mirror set for `tests.fuzz.readers`: read, and scored."""

import tempfile
from pathlib import Path

from raxel.evaluation.mirror_benchmark import score_mirror_file
from raxel.evaluation.mirror_result import SampledRays, StageAnswer, write_mirror_result
from raxel.sets import load_mirror_set
from tests.scored_mirrors import true_result, write_scored_set

FEWER = 4  # one pixel in so many is enough here


def scored_set(folder):
    """The set with its truth."""
    write_scored_set(folder)


def mirror_results():
    """Result files: all that there can be, rays alone, and points alone."""
    with tempfile.TemporaryDirectory() as room:
        result = true_result(write_scored_set(Path(room) / "set"))
        stages = [
            (SampledRays(*(part[::FEWER] for part in rays)), points[::FEWER])
            for rays, points in result.stages
        ]
        forms = (
            result._replace(stages=tuple(StageAnswer(*one) for one in stages)),
            result._replace(
                viewer=None, stages=tuple(StageAnswer(r, None) for r, _ in stages)
            ),
            result._replace(
                seconds=None, stages=tuple(StageAnswer(None, p) for _, p in stages)
            ),
        )
        found = []
        for form in forms:
            path = Path(room) / "result.npz"
            write_mirror_result(path, form)
            found.append((path.read_bytes(), None))
        return found


def use_mirror_result(folder, number):
    """Read the result and score it."""
    scores = score_mirror_file(load_mirror_set(folder), folder / "result.npz")
    assert len(scores["stages"]) == 3
