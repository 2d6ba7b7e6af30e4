"""`raxel bench SET [SET ...] --json F`"""

from raxel.cli.outputs import check_written
from raxel.errors import InputError
from raxel.evaluation.detector_bench import bench_detectors, check_bench
from raxel.io.documents import shown
from raxel.io.files import check_can_be_written, write_json
from raxel.sets import load_set

HEAD = (
    f"{'detector':<11}{'size':<11}{'images':>7}{'right':>7}{'wrong':>7}"
    f"{'unjudged':>10}{'refused':>9}{'median ms':>11}{'ratio':>8}"
)


def bench(options, say):
    """Every detector on every image of the sets: counts, and times as ratios."""
    if options.json:
        check_can_be_written(options.json)
    image_sets = [load_set(folder) for folder in options.set]
    check_written([options.json], image_sets)
    for image_set in image_sets:
        check_bench(image_set)
    _check_names(image_sets)
    results = {}
    for image_set in image_sets:
        say(f"{image_set.name}: {len(image_set.views)} images")
        scores = bench_detectors(image_set, say)
        results[image_set.name] = [score._asdict() for score in scores]
        print(f"{image_set.name}\n{HEAD}")
        for score in scores:
            print(_row(score))
    if options.json:
        write_json(options.json, results)


def _check_names(image_sets):
    """Raise InputError where two sets have one name, by which results are told."""
    first = {}
    for image_set in image_sets:
        other = first.setdefault(image_set.name, image_set)
        if other is image_set:
            continue
        where = f"{image_set.description}: name: found {shown(image_set.name)}"
        if other.folder.samefile(image_set.folder):
            raise InputError(f"{where}, a set that is given twice; name it once")
        raise InputError(
            f"{where}, which {other.description} has, too; results are told by it: "
            "give each its own"
        )


def _row(score):
    return (
        f"{score.detector:<11}{score.size:<11}{score.images:>7}{score.right:>7}"
        f"{score.wrong:>7}{score.unjudged:>10}{score.refused:>9}"
        f"{score.median_ms:>11.1f}{score.ratio:>8.2f}"
    )
