"""Commands of the program `raxel`: arguments, options and help."""

import contextlib
import os
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import click

from raxel import __version__
from raxel.cli.terminal import Say, print_help

SECTIONS = {
    **dict.fromkeys(["new", "check", "corners", "decode"], "Image sets"),
    **dict.fromkeys(["calibrate", "evaluate", "undistort", "show"], "Cameras"),
    **dict.fromkeys(["board", "patterns", "render"], "Targets and simulation"),
    **dict.fromkeys(["export", "import"], "Exchange"),
}
OPTION_SECTIONS = {
    **dict.fromkeys(["--out", "--json", "--report", "--force"], "Output"),
    **dict.fromkeys(["--corners", "--points", "--camera"], "Input"),
    **dict.fromkeys(["--board", "--pitch", "--marker", "--images"], "Input"),
    **dict.fromkeys(["--video", "--every"], "Input"),
}
EXPORT_FORMATS = (
    *("opencv", "opencv-fisheye", "opencv-omnidir", "ros", "kalibr", "basalt"),
    *("colmap", "nerfstudio", "mrcal", "ocamcalib", "maps", "table"),
)
NOT_IMPORTED = "basalt", "nerfstudio", "maps", "table"
IMPORT_FORMATS = [name for name in EXPORT_FORMATS if name not in NOT_IMPORTED]


def run(name: str, options: SimpleNamespace, say: Say) -> None:
    """Import the code of a command, now that it is needed, and run it."""
    from raxel.sets import is_mirror_set

    options.command, options.folder = name, None
    camera = getattr(options, "camera", None) or ""
    if os.path.isfile(result := os.path.join(camera, "camera.npz")):
        options.camera = result
    if options.quiet:
        say = _no_progress
    match name:
        case "new":
            from raxel.cli.sets import new as command
        case "check":
            from raxel.cli.image_sets import check as command
        case "corners":
            from raxel.cli.image_sets import corners as command
        case "decode":
            from raxel.cli.active_grids import decode as command
        case "calibrate" if options.set and is_mirror_set(options.set):
            from raxel.cli.mirror import calibrate_mirror_set as command
        case "calibrate":
            from raxel.cli.calibrate import calibrate as command
        case "evaluate" if is_mirror_set(options.set):
            from raxel.cli.mirror import evaluate_mirror_set as command
        case "evaluate":
            from raxel.cli.evaluate import evaluate as command
        case "undistort":
            from raxel.cli.images import undistort as command
        case "show":
            from raxel.cli.images import show as command
        case "board":
            from raxel.cli.board import board as command
        case "export":
            from raxel.cli.exchange import export as command
        case "import":
            from raxel.cli.exchange import import_ as command
        case "patterns":
            from raxel.cli.active_grids import patterns as command
        case "render":
            from raxel.cli.images import render as command
    if name != "calibrate":
        command(options, say)
        return
    from raxel.cli.sets import result_folder

    with result_folder(options, say):
        command(options, say)


def _no_progress(line: str) -> None:
    """Discard a line of progress."""


class Sections(click.Command):
    """Command whose help lists its commands and options in sections."""

    def format_options(self, ctx: click.Context, formatter: Any) -> None:
        """Write the sections."""
        sections: dict[str, list] = {}
        for name, command in getattr(self, "commands", {}).items():
            sections.setdefault(SECTIONS[name], []).append((name, command.help))
        for one in self.params:
            if isinstance(one, click.Option):
                section = OPTION_SECTIONS.get(one.opts[0], "Options")
                sections.setdefault(section, []).append(one.get_help_record(ctx))
        for title, rows in sections.items():
            with formatter.section(title):
                formatter.write_dl(rows)


class Program(Sections, click.Group):
    """Group of all commands."""


def file_name(text: str) -> str:
    """Return the name of a file or folder."""
    if not text or "\0" in text:
        raise click.BadParameter(f"found {text!r}, expected a name")
    return text


def number(kind: Callable, low: float, high: float, expected: str) -> Callable:
    """Return a function that reads a number from `low` to `high`."""

    def read(text: str) -> Any:
        with contextlib.suppress(ValueError):
            if low <= (value := kind(text)) <= high:
                return value
        raise click.BadParameter(f"found {text!r}, expected {expected}")

    return read


def pair(kind: Callable, low: float, expected: str, **names: Any) -> Callable:
    """Return a function that reads two numbers from `low` on, such as 9x6, or a name of
    two."""

    def read(text: str) -> Any:
        if text.lower() in names:
            return names[text.lower()]
        with contextlib.suppress(ValueError):
            first, second = map(kind, text.lower().split("x"))
            if low <= first <= MAX_LENGTH and low <= second <= MAX_LENGTH:
                return first, second
        raise click.BadParameter(f"found {text!r}, expected {expected}")

    return read


def _print(ctx: click.Context, param: click.Parameter, given: bool) -> None:
    if given:
        print_help(ctx.get_help() if param.name == "help" else f"raxel {__version__}")
        ctx.exit()


def _command(name: str, help: str, example: str, *params: click.Parameter) -> Sections:
    def callback(**options: Any) -> None:
        run(name, SimpleNamespace(**options), click.get_current_context().obj)

    return Sections(
        name,
        callback=callback,
        help=help,
        epilog=f"Example: {example}",
        params=[*params, QUIET, HELP],
    )


def _argument(name: str, help: str, required: bool = True) -> click.Argument:
    more: dict[str, Any] = {"metavar": name.upper(), "required": required}
    return click.Argument([name], type=file_name, help=help, **more)


def _option(name: str, type: Any, metavar: str, help: str, **more: Any) -> click.Option:
    return click.Option([name], type=type, metavar=metavar, help=help, **more)


def _flag(*names: str, help: str, **more: Any) -> click.Option:
    return click.Option(names, is_flag=True, help=help, **more)


def worded(read: Callable) -> Callable:
    """Return a function that reads an option by a function that raises ValueError."""

    def checked(text: str) -> Any:
        try:
            return read(text)
        except ValueError as fault:
            raise click.BadParameter(f"found {text!r}, {fault}") from fault

    return checked


def _board(text: str) -> Any:
    from raxel.cli.sets import board

    return board(text)


def _length(text: str) -> float:
    from raxel.cli.sets import length_mm

    return length_mm(text)


def _board_or_shape(text: str) -> Any:
    return text if text.endswith(".json") else worded(_board)(text)


SEED = number(int, 0, 10**18 - 1, "a whole number from 0")
COUNT = number(int, 1, 32000, "a whole number from 1 to 32000")
FRACTION = number(float, -1, 1, "a number from -1 to 1")
LENGTH = number(float, 5e-324, 1e6, "a length in mm, up to 1e6")
MAX_LENGTH = 1e4  # of a printed board, squares or mm
SQUARES = pair(int, 4, "two whole numbers from 4, such as 9x6")
PAPER = pair(
    float,
    50,
    "a4, a3, letter, or two lengths in mm from 50, such as 600x400",
    a4=(210.0, 297.0),
    a3=(297.0, 420.0),
    letter=(215.9, 279.4),
)
HELP = _flag(
    "-h",
    "--help",
    help="Show this help and exit.",
    callback=_print,
    is_eager=True,
    expose_value=False,
)
QUIET = _flag("-q", "--quiet", help="Show no progress.")
SET = _argument("set", "Folder of images, or of an image set with set.yaml.")
SET_OR_MIRROR_SET = _argument(
    "set", "Folder of images, of an image set, or of a mirror set."
)
FOLDER = (
    _option(
        "--board",
        worded(_board),
        "BOARD",
        "Board in a folder without set.yaml: a chessboard by its interior corners, as "
        "9x6; charuco:9x6:4X4_50, with the dictionary of its markers (charuco-legacy: "
        "drawn by OpenCV before 4.6); aprilgrid:6x6, "
        "by tags; circles:9x7 or staggered:4x11, by circles; or a target file of "
        "Kalibr (.yaml).  [default: chessboard, the images determine the size]",
    ),
    _option(
        "--pitch",
        worded(_length),
        "LENGTH",
        "Side of a square, or distance of neighbouring tags or circles, such as 25mm, "
        "2.5cm or 1in.  [default: unknown; lengths are then in this unit]",
    ),
    _option(
        "--marker",
        worded(_length),
        "LENGTH",
        "Side of a marker of a ChArUco board, or of a tag.",
    ),
    _option(
        "--images",
        file_name,
        "PATTERN",
        "Images of the folder that are used, such as 'IMG_*.jpg'.  [default: all; of "
        "subfolders if the folder itself has none]",
    ),
)
MODEL = _option(
    "--model",
    click.Choice(
        ["auto", "zhang", "kannala-brandt", "unified", "spline", "cgsp", "generic"]
    ),
    "NAME",
    "Camera model: zhang (pinhole with two radial terms), kannala-brandt or unified "
    "(parametric models of fisheyes and mirrors, with an entrance-pupil shift if the "
    "data support one), spline (B-spline ray field on a parametric model), cgsp or "
    "generic (per-pixel rays by the method of chapter 4 or the standard method), or "
    "auto (the model with the smallest error on held-out views). Not for mirror sets.",
    default="auto",
)
CENTRAL = _flag(
    "--central",
    help="Let all rays meet in one point: no entrance-pupil shift. Without it, the "
    "models kannala-brandt, unified and spline have one if a test supports it at "
    "p < 0.001 and the error on held-out views falls by 5 %. Not for mirror sets.",
)
DETECTOR = _option(
    "--detector",
    click.Choice(["raxel", "opencv", "opencv-sb", "celect"]),
    "NAME",
    "Corner detector: raxel or opencv-sb, which also determine an unknown board size, "
    "opencv, or celect, which requires outer_corners in set.yaml.  [default: raxel]",
)
CORNERS = _option(
    "--corners",
    file_name,
    "FILE",
    "Corners written by 'raxel corners --json', mrgingham or mrcal (.vnl), or "
    "cv2.FileStorage (.xml, .yml); detected if not given.",
)
POINTS = _option(
    "--points",
    file_name,
    "FOLDER",
    "Points of an active grid written by 'raxel decode'; decoded if not given.",
)
STRICT = _flag(
    "--strict",
    help="Exit with status 3 if the model does not fit or the focal length is not "
    "determined; results are written. Without it, warnings leave the status 0.",
)
PROGRAM = Program(
    "raxel",
    help="Calibrate general cameras from images of known targets.",
    epilog="Example: raxel calibrate my-images --board 9x6 --pitch 25mm\n\nSee raxel "
    "COMMAND --help for the options of a command.",
    context_settings={"show_default": True},
    no_args_is_help=False,
    params=[
        _flag(
            "--version",
            help="Show the version and exit.",
            callback=_print,
            is_eager=True,
            expose_value=False,
        ),
        HELP,
    ],
    commands=[
        _command(
            "new",
            "Write the set.yaml of a folder of images, to be edited.",
            "raxel new my-images --board 9x6 --pitch 25mm",
            _argument("set", "Folder of images."),
            *FOLDER,
        ),
        _command(
            "check",
            "Read all files of an image set and summarise them.",
            "raxel check my-camera",
            SET_OR_MIRROR_SET,
            *FOLDER,
        ),
        _command(
            "corners",
            "Detect the chessboard corners in the images of a set.",
            "raxel corners my-camera --json corners.json",
            SET,
            _option(
                "--json",
                file_name,
                "FILE",
                "Detected corners. An existing file is kept if no board is found.",
            ),
            *FOLDER,
            DETECTOR,
        ),
        _command(
            "decode",
            "Decode the screen position that each pixel of an active grid sees.",
            "raxel decode my-monitor --out points",
            SET,
            _option(
                "--out",
                file_name,
                "FOLDER",
                "New folder: points, sigma, mask (.npz) and a plot of each view.",
                required=True,
            ),
            _flag("--raw", help="Do not average over 7 x 7 pixels."),
            _flag("--neighbours", help="Average positions over 3 x 3 pixels."),
            _flag("--fill", help="Fill single holes from their neighbours."),
            _flag(
                "--linear",
                help="Assume a linear response of monitor and camera; do not measure "
                "and correct it.",
            ),
            _option(
                "--margin",
                SEED,
                "PX",
                "Width in px excluded along the edge of the lit area and along "
                "discontinuities.  [default: reach of windows and blur, at least "
                "6]",
            ),
        ),
        _command(
            "calibrate",
            "Calibrate a camera from the images of a set.",
            "raxel calibrate my-images --board 9x6 --pitch 25mm",
            _argument(
                "set",
                "Folder of images, of an image set, or of a mirror set.",
                required=False,
            ),
            *FOLDER,
            _option(
                "--video",
                file_name,
                "FILE",
                "Video in place of SET; frames that are sharp and differ are used.",
            ),
            _option(
                "--every",
                COUNT,
                "N",
                "Take at most one of N consecutive frames of the video.  [default: 10]",
            ),
            _option(
                "--out",
                file_name,
                "OUT",
                "Folder for camera.npz, camera.json, corners.json (used again by the "
                "next run), report/index.html and set.yaml; or, with the ending .npz, "
                "the camera file alone. For a mirror set that holds the last stage; "
                "mirror-0.npz, mirror-1.npz, ... in the same folder hold all stages.  "
                "[default: SET-calibration]",
            ),
            _flag("--force", help="Replace the results in OUT."),
            _option(
                "--json",
                file_name,
                "FILE",
                "Result: camera, residuals, misfit, split-half stability, "
                "beyond_boards (predicted error outside the covered area), "
                "board_corners (deviations from the nominal positions and whether the "
                "fit uses them), warnings.",
            ),
            _option(
                "--report",
                file_name,
                "FOLDER",
                "HTML report with plots of corners, residuals, coverage and "
                "split-half stability; for a mirror set, of shapes and residuals.",
            ),
            CORNERS,
            POINTS,
            MODEL,
            CENTRAL,
            DETECTOR,
            STRICT,
            _flag("-v", "--verbose", help="Print all results and all warnings."),
        ),
        _command(
            "evaluate",
            "Evaluate a camera on an image set; only board poses are fitted.",
            "raxel evaluate camera.npz my-camera --json evaluation.json",
            _argument("camera", "Camera file (.npz), or the folder of a calibration."),
            SET_OR_MIRROR_SET,
            _option("--json", file_name, "FILE", "Errors per view and in total."),
            CORNERS,
            POINTS,
            _option(
                "--board",
                _board_or_shape,
                "BOARD",
                "Board as of calibrate, such as 9x6; or a file (.json) with the shape "
                "of the same board, of 'raxel calibrate --json'.  [default: that in "
                "CAMERA, or as stated in set.yaml]",
            ),
            *FOLDER[1:],
            _option(
                "--stage",
                SEED,
                "N",
                "Stage of a mirror set, the number of deflections before CAMERA.  "
                "[default: from the name of CAMERA, such as mirror-2.npz, or the "
                "last stage]",
            ),
            DETECTOR,
            STRICT,
        ),
        _command(
            "undistort",
            "Undistort the images of a set: as a pinhole camera sees them, or as "
            "panoramas. undistorted.json contains the geometry of the images.",
            "raxel undistort camera.npz my-camera --out undistorted --fov 100",
            _argument(
                "camera",
                "Camera file (.npz), or points of one view (.npz) written by "
                "'raxel decode'. With points, no camera is needed: the images are "
                "mapped onto the plane of the active grid.",
            ),
            SET,
            _option(
                "--out",
                file_name,
                "FOLDER",
                "Folder for the PNG images and undistorted.json. Only files of an "
                "earlier run are replaced.",
                required=True,
            ),
            _option(
                "--projection",
                click.Choice(["perspective", "cylinder", "equirectangular"]),
                "NAME",
                "perspective (straight lines remain straight), cylinder (upright "
                "lines do) or equirectangular (columns and rows are azimuths and "
                "elevations).",
                default="perspective",
            ),
            _option(
                "--fov",
                number(float, 1, 360, "an angle from 1 to 360 degrees"),
                "DEG",
                "Horizontal field of view.  [default: that of the camera; in "
                "perspective up to 60 degrees from the axis]",
            ),
            _option(
                "--size",
                COUNT,
                "W H",
                "Width and height in px.  [default: that of the camera; in a panorama "
                "its scale in mid-image]",
                nargs=2,
            ),
            _option(
                "--down",
                number(float, -1e6, 1e6, "a number"),
                "X Y Z",
                "Vertical of a panorama in the camera frame, such as 0 0 1 for a "
                "camera that looks down along z.  [default: down in the image]",
                nargs=3,
            ),
            _option(
                "--range",
                LENGTH,
                "MM",
                "Distance at which images of a camera whose rays do not meet in one "
                "point are exact; in pitches of the target if its size is unknown.  "
                "[default: far away]",
            ),
            _flag(
                "--maps",
                help="Write maps.npz: the pixel (u, v) of the camera that each pixel "
                "shows.",
            ),
        ),
        _command(
            "show",
            "Draw a rig, a camera or an image set in three dimensions.",
            "raxel show my-camera --camera camera.npz --out boards.html",
            _argument(
                "what",
                "Rig file (.yaml), camera file (.npz), or folder of an image set or of "
                "results, whose camera and corners are used.",
            ),
            _option(
                "--out",
                file_name,
                "FILE",
                "Image (.png) or interactive page (.html).  [default: a page in "
                "the browser]",
            ),
            _option(
                "--camera",
                file_name,
                "CAMERA",
                "Camera to which the board poses of a set are fitted.  [default: "
                "true poses of a rendered set, or a calibration by Zhang's method]",
            ),
            CORNERS,
            _option("--seed", SEED, "N", "Seed of the poses of a rig.", default=0),
        ),
        _command(
            "board",
            "Draw a chessboard or ChArUco board to print, with a ruler on it.",
            "raxel board --squares 9x6 --pitch 25 --paper a4 --out board.pdf",
            _option(
                "--out", file_name, "FILE", "Vector drawing (.pdf).", required=True
            ),
            _option(
                "--squares",
                SQUARES,
                "WxH",
                "Squares along a row and along a column. Interior corners, which "
                "set.yaml counts, are one fewer along each: 9x6 has 8 x 5.",
                required=True,
            ),
            _option(
                "--pitch",
                worded(_length),
                "LENGTH",
                "Side of a square, such as 25mm, 2.5cm or 1in.",
                required=True,
            ),
            _option(
                "--paper",
                PAPER,
                "NAME",
                "a4, a3, letter, or width and height in mm, such as 600x400. The "
                "longer side is along the longer side of the board.",
                default="a4",
            ),
            _option(
                "--kind",
                click.Choice(["chessboard", "charuco"]),
                "NAME",
                "chessboard, or charuco, whose corners are identified also where "
                "part of the board is outside the image.",
                default="chessboard",
            ),
        ),
        _command(
            "export",
            "Write a camera in the format of another program.",
            "raxel export camera.npz --format colmap --out cameras.txt",
            _argument("camera", "Camera file (.npz)."),
            _option(
                "--format",
                click.Choice(EXPORT_FORMATS),
                "NAME",
                f"One of {', '.join(EXPORT_FORMATS)}. A model that the format does not "
                "have is refitted to the rays. maps: float32 maps for cv2.remap; "
                "table: ray of each pixel.",
                required=True,
            ),
            _option("--out", file_name, "FILE", "File to write.", required=True),
            _flag(
                "--allow-residual",
                help="Write also a model with an RMS residual above 0.5 px.",
            ),
            _flag("--force", help="Replace OUT."),
        ),
        _command(
            "import",
            "Read a camera from the file of another program.",
            "raxel import camchain.yaml --format kalibr --out camera.npz",
            _argument("file", "File with one camera."),
            _option(
                "--format",
                click.Choice(IMPORT_FORMATS),
                "NAME",
                f"One of {', '.join(IMPORT_FORMATS)}.",
                required=True,
            ),
            _option("--out", file_name, "CAMERA", "Camera file (.npz).", required=True),
            _flag("--force", help="Replace OUT."),
        ),
        _command(
            "patterns",
            "Draw the phase-shift patterns of an active grid for a monitor.",
            "raxel patterns --width 1920 --height 1080 --out patterns",
            _option(
                "--out",
                file_name,
                "FOLDER",
                "New folder: patterns and a set.yaml to fill in.",
                required=True,
            ),
            _option(
                "--width", COUNT, "PX", "Width of the monitor in px.", required=True
            ),
            _option(
                "--height", COUNT, "PX", "Height of the monitor in px.", required=True
            ),
            _option(
                "--cells", COUNT, "N", "Gray code cells along each axis.", default=8
            ),
            _option(
                "--steps",
                COUNT,
                "N",
                "Phase steps of the sinusoids. The harmonics of the monitor's "
                "response below the 5th cancel with 6 steps or more, below the "
                "3rd with 4.",
                default=6,
            ),
            _option(
                "--offset",
                FRACTION,
                "FRACTION",
                "Phase offset of the sinusoids as a fraction of a period (0.25: "
                "cosines).",
                default=0.0,
            ),
            _option(
                "--size-mm",
                LENGTH,
                "W H",
                "Width and height of the lit area in mm, for set.yaml.",
                nargs=2,
            ),
            _option(
                "--chessboard",
                COUNT,
                "COLUMNS ROWS",
                "Interior corners of an additional chessboard pattern, to be shown "
                "in the same pose.",
                nargs=2,
            ),
            _option("--poses", COUNT, "N", "Poses in set.yaml.", default=1),
        ),
        _command(
            "render",
            "Render an image set of a simulated camera rig.",
            "raxel render data/rigs/ordinary-lens.yaml --out rendered",
            _argument("rig", "Rig file, such as data/rigs/ordinary-lens.yaml."),
            _option(
                "--out", file_name, "SET", "New folder of the image set.", required=True
            ),
            _option(
                "--seed",
                SEED,
                "N",
                "Seed of poses and noise. The same seed gives the same bytes.",
                default=0,
            ),
            _option(
                "--noise",
                None,
                "LEVEL",
                "Noise level of a mirror set, such as low, middle or high.  "
                "[default: first level of the rig]",
            ),
        ),
    ],
)
