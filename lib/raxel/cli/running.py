"""What runs a command: each imports its own, so that help and mistakes cost no time."""

from raxel.cli import mirror_parsers


def run_corners(options, say):
    from raxel.cli.corners import corners

    corners(options, say)


def run_calibrate(options, say):
    from raxel.sets import is_mirror_set

    if is_mirror_set(options.set):
        from raxel.cli.mirror import calibrate_mirror_set as calibrate
    else:
        from raxel.cli.calibrate import calibrate

        mirror_parsers.check_no_rays(options)
    calibrate(options, say)


def run_evaluate(options, say):
    from raxel.sets import is_mirror_set

    if is_mirror_set(options.set):
        from raxel.cli.mirror_evaluate import evaluate_mirror_set as evaluate
    else:
        from raxel.cli.evaluate import evaluate

    evaluate(options, say)


def run_undistort(options, say):
    from raxel.cli.undistort import undistort

    undistort(options, say)


def run_check(options, say):
    from raxel.cli.check import check

    check(options, say)


def run_render(options, say):
    from raxel.cli.render import render

    render(options, say)


def run_patterns(options, say):
    from raxel.cli.patterns import patterns

    patterns(options, say)


def run_decode(options, say):
    from raxel.cli.decode import decode

    decode(options, say)


def run_show(options, say):
    from raxel.cli.show import show

    show(options, say)


def run_score(options, say):
    from raxel.cli.score import score

    score(options, say)


def run_bench(options, say):
    from raxel.cli.bench import bench

    bench(options, say)
