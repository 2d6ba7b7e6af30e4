"""The command line. SET is the folder of an image set, CAMERA an .npz camera file.

- `raxel check SET` reads all of a set and says what is in it.
- `raxel corners SET [--json FILE] [--detector NAME]` finds the chessboard's corners;
  where it finds none at all, a FILE that is there is kept.
- `raxel calibrate SET --out CAMERA [--model auto|zhang|generic] [--json FILE]
  [--report FOLDER] [--corners FILE] [--detector NAME]` fits a camera to a set.
- `raxel evaluate CAMERA SET [--json FILE] [--corners FILE] [--detector NAME]` scores a
  camera; only the boards' poses are fitted.
- `raxel undistort CAMERA SET --out FOLDER` writes the images as a pinhole would see
  them: new files, or in place of those of an earlier undistort, never of others.
- `raxel render RIG --out SET [--seed N]` photographs a rig's target in the virtual
  laboratory.
- `raxel patterns --width W --height H --out FOLDER [--cells N] [--steps N]` draws what
  an active grid's monitor shows, with a set.yaml for the photographs.
- `raxel decode SET --out FOLDER [--raw] [--neighbours] [--fill] [--margin PX]` finds
  the point of the monitor that each pixel sees; `raxel score --points` takes FOLDER.
- `raxel show WHAT [--camera CAMERA] [--corners FILE] [--seed N] [--out FILE]` draws a
  rig, a camera, or the targets of a set before their camera: FILE is a picture (.png)
  or a page to turn (.html); without it the page opens in the browser.
- `raxel score SET [--corners FILE] [--points FOLDER] [--camera CAMERA] [--json FILE]`
  compares results with the truth of a rendered set.
- `raxel bench SET [SET ...] [--json FILE]` runs the detectors that need no clicks side
  by side: counts of right and wrong boards, times as ratios.

`--corners` takes corners that `raxel corners --json` wrote; without it they are found
by the detector, `raxel`, `opencv` or `opencv-sb`, or by `celect`, which needs each
view's `outer_corners` in set.yaml. Every command explains its options with `--help`.

Results are files, a short summary goes to standard output, progress to standard
error. A line of the summary that begins with `warning:` says what went into no result,
or what no camera fits. Exit status: 0 done; 2 bad input, with one line that says what
and where, or no board in any image; 1 a file that cannot be written; 130 interrupted.
Nothing half-written is left, and of several results of one command all are written or
none. A pipe whose reader has gone (`| head -1`) stops nothing: files are written,
status 0.
"""

import argparse
import contextlib
import os
import sys

from raxel.cli.progress import Progress
from raxel.cli.terminal import Terminal, on_one_line
from raxel.errors import InputError
from raxel.files import recording

DETECTOR_NAMES = ("raxel", "opencv", "opencv-sb", "celect")
MODELS = ("auto", "zhang", "generic")


class _OneLineParser(argparse.ArgumentParser):
    """A parser whose complaint is one line, as every other of this program."""

    def error(self, message):
        line = on_one_line(f"{self.prog}: {message}; see {self.prog} --help")
        self.exit(2, f"{line}\n")


def main(argv=None):
    """Run one command; returns the exit status."""
    out, err = Terminal(sys.stdout), Terminal(sys.stderr)
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = _run(argv)
        out.flush()
        if status == 0 and out.fault is not None and not out.reader_has_gone:
            _complain(f"standard output: {out.fault.strerror}; all files are written")
            status = 1
        err.flush()
    return status


def _run(argv):
    # With several threads OpenCV's fits differ in the last digits from run to run.
    os.environ.setdefault("OPENCV_FOR_THREADS_NUM", "1")
    progress = Progress(sys.stderr)
    with recording() as written:
        try:
            options = _parser().parse_args(argv)
            options.command(options, progress.say)
        except SystemExit as stop:
            return stop.code or 0
        except InputError as fault:
            _complain(fault)
            return 2
        except OSError as fault:
            name = fault.filename2 or fault.filename or "output"
            problem = fault.strerror or fault
            _complain(f"{name}: {problem}; {_told(written)}")
            return 1
        except KeyboardInterrupt:
            _complain(f"interrupted; {_told(written)}")
            return 130
    progress.release()
    return 0


def _complain(fault):
    print(f"raxel: {on_one_line(fault)}", file=sys.stderr)


def _told(written):
    """What a command that failed has written all the same."""
    if not written:
        return "nothing written"
    more = f" and {len(written) - 1} more" if len(written) > 1 else ""
    return f"written before that: {written[0]}{more}"


def _parser():
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
    _add_score(commands)
    _add_bench(commands)
    return parser


def _add_corners(commands):
    parser = _command(commands, "corners", "find the chessboard's corners", _corners)
    parser.add_argument("--json", metavar="FILE", help="write the corners here")
    _add_detector(parser)


def _add_calibrate(commands):
    parser = _command(commands, "calibrate", "fit a camera to a set", _calibrate)
    parser.add_argument(
        "--model",
        choices=MODELS,
        default="auto",
        help="zhang: pinhole with two radial terms; generic: a ray for each pixel; "
        "auto: the one with the smaller cross-validated angular error",
    )
    parser.add_argument("--out", metavar="CAMERA", required=True, help="the .npz file")
    parser.add_argument("--json", metavar="FILE", help="write what was found here")
    parser.add_argument(
        "--report",
        metavar="FOLDER",
        help="write pictures of corners, residuals and coverage here, and a page",
    )
    _add_corners_file(parser)
    _add_detector(parser)


def _add_evaluate(commands):
    parser = _command(
        commands, "evaluate", "score a camera; only poses are fitted", _evaluate, True
    )
    parser.add_argument("--json", metavar="FILE", help="write the scores here")
    _add_corners_file(parser)
    _add_detector(parser)


def _add_undistort(commands):
    parser = _command(
        commands, "undistort", "images as a pinhole would see them", _undistort, True
    )
    parser.add_argument(
        "--out",
        metavar="FOLDER",
        required=True,
        help="where the PNG images go, beside whatever else is there",
    )


def _add_check(commands):
    _command(commands, "check", "read all of a set and say what is in it", _check)


def _add_render(commands):
    summary = "photograph a rig's target in the virtual laboratory"
    parser = commands.add_parser("render", help=summary, description=summary)
    parser.add_argument(
        "rig", metavar="RIG", help="a rig file, such as data/rigs/*.yaml"
    )
    parser.add_argument(
        "--out", metavar="SET", required=True, help="the new folder of the image set"
    )
    parser.add_argument(
        "--seed",
        type=_seed,
        default=0,
        help="of poses and noise; the same seed gives the same bytes (default 0)",
    )
    parser.set_defaults(command=_render)


def _add_patterns(commands):
    summary = "draw the patterns that the monitor of an active grid shows"
    parser = commands.add_parser("patterns", help=summary, description=summary)
    for side in ("width", "height"):
        parser.add_argument(
            f"--{side}", type=_count, required=True, help="of the monitor, px"
        )
    parser.add_argument(
        "--cells", type=_count, default=8, help="along either axis (default 8)"
    )
    parser.add_argument(
        "--steps",
        type=_count,
        default=4,
        help="of the sines: 4 (default) leave out even orders of a monitor's response, "
        "6 or more the third as well",
    )
    parser.add_argument("--out", metavar="FOLDER", required=True, help="a new folder")
    parser.set_defaults(command=_patterns)


def _add_decode(commands):
    summary = "find the point of an active grid that each pixel sees"
    parser = _command(commands, "decode", summary, _decode)
    parser.add_argument(
        "--out",
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
        "--margin",
        metavar="PX",
        type=_seed,
        default=6,
        help="leave out so much at the rim of the lit area (default 6)",
    )


def _add_show(commands):
    summary = "draw a rig, a camera, or the targets of a set, in three dimensions"
    parser = commands.add_parser("show", help=summary, description=summary)
    parser.add_argument(
        "what",
        metavar="WHAT",
        help="a rig file (.yaml), a camera file (.npz), or the folder of an image set",
    )
    parser.add_argument(
        "--camera",
        metavar="CAMERA",
        help="pose the boards of a set to fit this camera; without it, to the truth of "
        "a rendered set, or to a quick calibration by Zhang's method",
    )
    _add_corners_file(parser)
    parser.add_argument(
        "--seed", type=_seed, default=0, help="of a rig's poses (default 0)"
    )
    parser.add_argument(
        "--out", metavar="FILE", help="write a .png or .html file and open nothing"
    )
    parser.set_defaults(command=_show)


def _add_score(commands):
    summary = "compare results with the truth of a rendered set"
    parser = _command(commands, "score", summary, _score)
    parser.add_argument(
        "--corners", metavar="FILE", help="corners, in the form of raxel corners"
    )
    parser.add_argument(
        "--points",
        metavar="FOLDER",
        help="decoded points: an .npz file per view with points_mm (height, width, 2)",
    )
    parser.add_argument("--camera", metavar="CAMERA", help="a central camera, .npz")
    parser.add_argument("--json", metavar="FILE", help="write the scores here")


def _add_bench(commands):
    summary = "the detectors that need no clicks side by side: counts, times as ratios"
    parser = commands.add_parser("bench", help=summary, description=summary)
    parser.add_argument(
        "set", metavar="SET", nargs="+", help="folders of image sets of chessboards"
    )
    parser.add_argument("--json", metavar="FILE", help="write the scores here")
    parser.set_defaults(command=_bench)


def _seed(text):
    if not text.isascii() or not text.isdigit() or len(text) > 18:
        raise argparse.ArgumentTypeError(f"found {text!r}; give a whole number from 0")
    return int(text)


def _count(text):
    number = _seed(text)
    if not 1 <= number <= 32000:
        raise argparse.ArgumentTypeError(f"found {text}; give 1 to 32000")
    return number


def _command(commands, name, summary, run, takes_camera=False):
    parser = commands.add_parser(name, help=summary, description=summary)
    if takes_camera:
        parser.add_argument("camera", metavar="CAMERA", help="an .npz camera file")
    parser.add_argument("set", metavar="SET", help="the folder of an image set")
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
        "--corners", metavar="FILE", help="take corners that raxel corners wrote"
    )


def _corners(options, say):
    from raxel.cli.corners import corners

    corners(options, say)


def _calibrate(options, say):
    from raxel.cli.calibrate import calibrate

    calibrate(options, say)


def _evaluate(options, say):
    from raxel.cli.evaluate import evaluate

    evaluate(options, say)


def _undistort(options, say):
    from raxel.cli.undistort import undistort

    undistort(options, say)


def _check(options, say):
    from raxel.cli.check import check

    check(options, say)


def _render(options, say):
    from raxel.cli.render import render

    render(options, say)


def _patterns(options, say):
    from raxel.cli.patterns import patterns

    patterns(options, say)


def _decode(options, say):
    from raxel.cli.decode import decode

    decode(options, say)


def _show(options, say):
    from raxel.cli.show import show

    show(options, say)


def _score(options, say):
    from raxel.cli.score import score

    score(options, say)


def _bench(options, say):
    from raxel.cli.bench import bench

    bench(options, say)
