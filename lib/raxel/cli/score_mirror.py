"""`raxel score-mirror RESULT.npz SET --json F`"""

from raxel.cli.mirror import check_mirror_written
from raxel.cli.scores import percent
from raxel.evaluation.mirror_benchmark import score_mirror_file
from raxel.io.files import check_can_be_written, write_json
from raxel.sets import load_mirror_set


def score_mirror_set(options, say):
    """Score a result file against the truth of a rendered mirror set."""
    if options.json:
        check_can_be_written(options.json)
    mirror_set = load_mirror_set(options.set)
    check_mirror_written([options.json], mirror_set, [options.result])
    say(f"result {options.result}")
    scores = score_mirror_file(mirror_set, options.result)
    if options.json:
        write_json(options.json, scores)
    for line in _lines(scores):
        print(line)


def _lines(scores):
    """The scores, for people."""
    name = scores["set"]
    if scores["viewer_rms_deg"] is not None:
        yield (
            f"{name}: viewer: axes turned by {scores['turned_deg']:.3f} deg, which is "
            f"taken out; its rays rms {scores['viewer_rms_deg']:.4f} deg"
        )
    for stage in scores["stages"]:
        yield f"{name}: stage {stage['stage']}: {_line(stage)}"
        for load in stage["deflections"] if stage["stage"] else ():
            found = load["found_mm"]
            told = "none" if found is None else f"{found:.3f}"
            place, true = load["read_at_mm"], load["true_mm"]
            yield (
                f"{name}: stage {stage['stage']}: deflected at {place:g} mm by "
                f"{true:.3f} mm, found {told}"
            )
    whole = scores["all"]
    seconds = scores["seconds"]
    took = "" if seconds is None else f"; {seconds:.3g} s as stated"
    yield f"{name}: all stages: {_line(whole)}{took}"


def _line(scored):
    rays, height = scored["rays"], scored["height"]
    return (
        f"rays {percent(rays['share_with_ray'])}, {percent(rays['share_right'])} "
        f"right, {_told(rays, 'deg')}, aside {_told(rays, 'mm')}; height "
        f"{percent(height['share_covered'])}, {_told(height, 'mm')}"
    )


def _told(scored, unit):
    rms, median = scored[f"rms_{unit}"], scored[f"median_{unit}"]
    if rms is None:
        return "none"
    return f"rms {rms:.4g}, median {median:.4g} {unit}"
