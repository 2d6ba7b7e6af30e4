"""What runs a command: each imports its own, so that help and mistakes cost no time."""


def run_corners(options, say):
    """Find the boards of a set."""
    from raxel.cli.corners import corners

    corners(options, say)


def run_calibrate(options, say):
    """Calibrate a camera by a set, or a mirror that bends by a mirror set."""
    from raxel.sets import is_mirror_set

    if is_mirror_set(options.set):
        from raxel.cli.mirror import calibrate_mirror_set as calibrate
    else:
        from raxel.cli.calibrate import calibrate

    calibrate(options, say)


def run_evaluate(options, say):
    """Score a camera by a set, or one stage of a mirror by its mirror set."""
    from raxel.sets import is_mirror_set

    if is_mirror_set(options.set):
        from raxel.cli.mirror_evaluate import evaluate_mirror_set as evaluate
    else:
        from raxel.cli.evaluate import evaluate

    evaluate(options, say)


def run_undistort(options, say):
    """Straighten the photographs of a set."""
    from raxel.cli.undistort import undistort

    undistort(options, say)


def run_check(options, say):
    """Say whether a set is in order, and what is in it."""
    from raxel.cli.check import check

    check(options, say)


def run_render(options, say):
    """Render a set that a scene file describes."""
    from raxel.cli.render import render

    render(options, say)


def run_patterns(options, say):
    """Write an active grid's patterns."""
    from raxel.cli.patterns import patterns

    patterns(options, say)


def run_decode(options, say):
    """Decode the active grids of a set."""
    from raxel.cli.decode import decode

    decode(options, say)


def run_show(options, say):
    """Draw a camera, a set or a scene as a page."""
    from raxel.cli.show import show

    show(options, say)
