"""What can be typed of the benchmark of mirrors that bend: a command and two options.

A command is imported when it runs, so that help and mistakes cost no time.
"""

from raxel.cli.names import read_name, written_name
from raxel.errors import InputError


def add_score_mirror(commands):
    """`raxel score-mirror RESULT.npz SET`"""
    summary = "compare what is found of a mirror that bends with a rendered set's truth"
    parser = commands.add_parser("score-mirror", help=summary, description=summary)
    parser.add_argument(
        "result",
        type=read_name,
        metavar="RESULT",
        help="an .npz file with each stage's rays, points of the mirror, or both, as "
        "raxel calibrate --rays writes it",
    )
    parser.add_argument(
        "set", type=read_name, metavar="SET", help="the folder of a mirror set"
    )
    parser.add_argument(
        "--json", type=written_name, metavar="FILE", help="write the scores here"
    )
    parser.set_defaults(command=_score_mirror)


def add_rays(parser):
    """`--rays` of `raxel calibrate`"""
    parser.add_argument(
        "--rays",
        type=written_name,
        metavar="RESULT",
        help="of a mirror set: write each stage's rays here, for raxel score-mirror",
    )


def add_noise(parser):
    """`--noise` of `raxel render`"""
    parser.add_argument(
        "--noise",
        metavar="LEVEL",
        help="of a mirror set: one of its levels, such as low, middle or high; "
        "default: the first",
    )


def check_no_rays(options):
    """Raise InputError where `--rays` is asked for of an image set."""
    if options.rays:
        raise InputError(
            f"--rays: found with {options.set}, which is no mirror set; leave it out"
        )


def _score_mirror(options, say):
    from raxel.cli.score_mirror import score_mirror_set

    score_mirror_set(options, say)
