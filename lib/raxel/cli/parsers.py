"""What can be typed after `raxel`: the commands and their options.

What runs a command stands in `running`.
"""

import argparse

from raxel.cli import numbers, running
from raxel.cli.names import read_name, written_name
from raxel.cli.terminal import on_one_line

DETECTOR_NAMES = ("raxel", "opencv", "opencv-sb", "celect")
MODELS = (
    *("auto", "zhang", "kannala-brandt", "unified"),
    *("spline", "cgsp", "generic"),
)

A_SET = "the folder of an image set"
ALSO_A_MIRROR = "the folder of an image set, or of a mirror set"


class _OneLineParser(argparse.ArgumentParser):
    """A parser whose complaint is one line, as every other of this program."""

    def error(self, message):
        line = on_one_line(f"{self.prog}: {message}; see {self.prog} --help")
        self.exit(2, f"{line}\n")


def parser():
    """The parser of all commands; options.command(options, say) runs one."""
    parser = _OneLineParser(
        prog="raxel",
        description="Calibrate general cameras: images of known targets in, rays out.",
    )
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    _add_corners(commands)
    _add_calibrate(commands)
    _add_evaluate(commands)
    _add_undistort(commands)
    _add_check(commands)
    _add_render(commands)
    _add_patterns(commands)
    _add_decode(commands)
    _add_show(commands)
    return parser


def _add_corners(commands):
    parser = _command(
        commands, "corners", "find the chessboard's corners", running.run_corners
    )
    parser.add_argument(
        "--json", type=written_name, metavar="FILE", help="write the corners here"
    )
    _add_detector(parser)


def _add_calibrate(commands):
    parser = _command(
        commands,
        "calibrate",
        "fit a camera to a set",
        running.run_calibrate,
        folder=ALSO_A_MIRROR,
    )
    parser.add_argument(
        "--model",
        choices=MODELS,
        default="auto",
        help="zhang: pinhole with two radial terms; kannala-brandt, unified: formulas "
        "of fisheyes and mirrors, decentred, whose pupil moves if the views say so; "
        "spline: smooth rays on such a formula; cgsp, generic: a ray for each pixel, "
        "by the method of chapter 4 or the standard one; auto: the one with the "
        "smallest error on views kept out "
        "(default). A mirror set has one model: leave it out",
    )
    parser.add_argument(
        "--out",
        type=written_name,
        metavar="CAMERA",
        required=True,
        help="the .npz file; of a mirror set that of the last stage, and beside it, as "
        "mirror-0.npz, mirror-1.npz, ..., those of all",
    )
    parser.add_argument(
        "--json",
        type=written_name,
        metavar="FILE",
        help="write what was found here: camera, residuals, misfit, stability (which "
        "halves of the photographs disagree by how much), beyond_boards (how far rays "
        "may be off where no board was), board_corners (where each lies beside where "
        "it is said to), warnings",
    )
    parser.add_argument(
        "--report",
        type=written_name,
        metavar="FOLDER",
        help="write pictures of corners, residuals, coverage and of how far halves of "
        "the photographs disagree here, and a page; of a mirror set, its shapes and "
        "residuals",
    )
    _add_corners_file(parser)
    _add_points_folder(parser)
    _add_detector(parser)


def _add_evaluate(commands):
    parser = _command(
        commands,
        "evaluate",
        "score a camera; only poses are fitted",
        running.run_evaluate,
        camera="an .npz camera file",
        folder=ALSO_A_MIRROR,
    )
    parser.add_argument(
        "--json", type=written_name, metavar="FILE", help="write the scores here"
    )
    parser.add_argument(
        "--stage",
        metavar="N",
        type=numbers.seed,
        help="of a mirror set: whose camera it is, the number of deflections before; "
        "default: as the name of CAMERA ends, such as mirror-2.npz, else the last",
    )
    parser.add_argument(
        "--board",
        type=read_name,
        metavar="FILE",
        help="take the board's shape from what raxel calibrate --json wrote: the same "
        "board; default: as stated in set.yaml",
    )
    _add_corners_file(parser)
    _add_points_folder(parser)
    _add_detector(parser)


def _add_undistort(commands):
    parser = _command(
        commands,
        "undistort",
        "images as a pinhole would see them, or on the plane of an active grid",
        running.run_undistort,
        camera="an .npz camera file, or an .npz file of points from raxel decode",
    )
    parser.add_argument(
        "--out",
        type=written_name,
        metavar="FOLDER",
        required=True,
        help="where the PNG images go, beside whatever else is there",
    )


def _add_check(commands):
    summary = "read all of a set and say what is in it"
    _command(commands, "check", summary, running.run_check, folder=ALSO_A_MIRROR)


def _add_render(commands):
    summary = "photograph a rig's target in the virtual laboratory"
    parser = commands.add_parser("render", help=summary, description=summary)
    parser.add_argument(
        "rig",
        type=read_name,
        metavar="RIG",
        help="a rig file, such as data/rigs/*.yaml",
    )
    parser.add_argument(
        "--out",
        type=written_name,
        metavar="SET",
        required=True,
        help="the new folder of the image set",
    )
    parser.add_argument(
        "--seed",
        type=numbers.seed,
        default=0,
        help="of poses and noise; the same seed gives the same bytes (default 0)",
    )
    parser.add_argument(
        "--noise",
        metavar="LEVEL",
        help="of a mirror set: one of its levels, such as low, middle or high; "
        "default: the first",
    )
    parser.set_defaults(command=running.run_render)


def _add_patterns(commands):
    summary = "draw the patterns that the monitor of an active grid shows"
    parser = commands.add_parser("patterns", help=summary, description=summary)
    for side in ("width", "height"):
        parser.add_argument(
            f"--{side}", type=numbers.count, required=True, help="of the monitor, px"
        )
    parser.add_argument(
        "--cells", type=numbers.count, default=8, help="along either axis (default 8)"
    )
    parser.add_argument(
        "--steps",
        type=numbers.count,
        default=6,
        help="of the sines: 6 (default) or more are disturbed by no order of a "
        "monitor's response below the fifth, 4 by the third",
    )
    parser.add_argument(
        "--offset",
        type=numbers.part,
        metavar="PART",
        default=0.0,
        help="of a period by which sines are ahead: 0.25 for cosines (default 0)",
    )
    parser.add_argument(
        "--size-mm",
        metavar=("W", "H"),
        nargs=2,
        type=numbers.length,
        help="of the lit area, for set.yaml",
    )
    parser.add_argument(
        "--chessboard",
        metavar=("COLUMNS", "ROWS"),
        nargs=2,
        type=numbers.count,
        help="of inner corners: one more picture, to be shown in the same pose",
    )
    parser.add_argument(
        "--poses", type=numbers.count, default=1, help="that set.yaml lists (default 1)"
    )
    parser.add_argument(
        "--out", type=written_name, metavar="FOLDER", required=True, help="a new folder"
    )
    parser.set_defaults(command=running.run_patterns)


def _add_decode(commands):
    summary = "find the point of an active grid that each pixel sees"
    parser = _command(commands, "decode", summary, running.run_decode)
    parser.add_argument(
        "--out",
        type=written_name,
        metavar="FOLDER",
        required=True,
        help="a new folder: for each view points, sigma and mask (.npz), a picture",
    )
    parser.add_argument(
        "--raw", action="store_true", help="do not average over 7 x 7 pixels"
    )
    parser.add_argument(
        "--neighbours", action="store_true", help="average locations over 3 x 3 pixels"
    )
    parser.add_argument(
        "--fill", action="store_true", help="fill single holes from their neighbours"
    )
    parser.add_argument(
        "--linear",
        action="store_true",
        help="monitor and camera answer in proportion: measure and correct nothing",
    )
    parser.add_argument(
        "--margin",
        metavar="PX",
        type=numbers.seed,
        help="leave out so much at the rim of the lit area and at jumps (default: as "
        "far as windows and the blur reach, 6 at least)",
    )


def _add_show(commands):
    summary = "draw a rig, a camera, or the targets of a set, in three dimensions"
    parser = commands.add_parser("show", help=summary, description=summary)
    parser.add_argument(
        "what",
        type=read_name,
        metavar="WHAT",
        help="a rig file (.yaml), a camera file (.npz), or the folder of an image set",
    )
    parser.add_argument(
        "--camera",
        type=read_name,
        metavar="CAMERA",
        help="pose the boards of a set to fit this camera; without it, to the truth of "
        "a rendered set, or to a quick calibration by Zhang's method",
    )
    _add_corners_file(parser)
    parser.add_argument(
        "--seed", type=numbers.seed, default=0, help="of a rig's poses (default 0)"
    )
    parser.add_argument(
        "--out",
        type=written_name,
        metavar="FILE",
        help="write a .png or .html file and open nothing",
    )
    parser.set_defaults(command=running.run_show)


def _command(commands, name, summary, run, camera=None, folder=A_SET):
    parser = commands.add_parser(name, help=summary, description=summary)
    if camera:
        parser.add_argument("camera", type=read_name, metavar="CAMERA", help=camera)
    parser.add_argument("set", type=read_name, metavar="SET", help=folder)
    parser.set_defaults(command=run)
    return parser


def _add_detector(parser):
    parser.add_argument(
        "--detector",
        choices=DETECTOR_NAMES,
        help="default: raxel, which also counts where the board's size is not given, "
        "as opencv-sb; opencv and celect need it, and celect outer_corners in set.yaml",
    )


def _add_corners_file(parser):
    parser.add_argument(
        "--corners",
        type=read_name,
        metavar="FILE",
        help="take corners that raxel corners wrote",
    )


def _add_points_folder(parser):
    parser.add_argument(
        "--points",
        type=read_name,
        metavar="FOLDER",
        help="take points that raxel decode wrote",
    )
