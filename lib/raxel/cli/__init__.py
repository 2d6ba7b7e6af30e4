"""The command line. SET is the folder of an image set, CAMERA an .npz camera file.

- `raxel check SET` reads all of a set and says what is in it.
- `raxel corners SET [--json FILE] [--detector NAME]` finds the chessboard's corners;
  where it finds none at all, a FILE that is there is kept.
- `raxel calibrate SET --out CAMERA [--model MODEL] [--json FILE]
  [--report FOLDER] [--corners FILE] [--points FOLDER] [--detector NAME]` fits a
  camera to a set of chessboards or of active grids.
- `raxel evaluate CAMERA SET [--json FILE] [--corners FILE] [--points FOLDER]
  [--detector NAME] [--stage N] [--board FILE]` scores a camera; only the targets'
  poses are fitted. FILE is what `raxel calibrate --json` wrote of the same board, whose
  bends and stretch are taken from there.
- `raxel undistort CAMERA SET --out FOLDER` writes the images as a pinhole would see
  them: new files, or in place of those of an earlier undistort, never of others. CAMERA
  may be a view's file of points from `raxel decode`: then no camera is needed, and the
  images are laid out on the plane that the active grid lay in.
- `raxel render RIG --out SET [--seed N] [--noise LEVEL]` photographs a rig's target in
  the virtual laboratory; where RIG describes a mirror set, all of that.
- `raxel patterns --width W --height H --out FOLDER [--cells N] [--steps N]
  [--offset PART] [--size-mm W H] [--chessboard COLUMNS ROWS] [--poses N]` draws what
  an active grid's monitor shows, with a set.yaml for the photographs.
- `raxel decode SET --out FOLDER [--raw] [--neighbours] [--fill] [--linear]
  [--margin PX]` finds the point of the monitor that each pixel sees; `--points` takes
  FOLDER.
- `raxel show WHAT [--camera CAMERA] [--corners FILE] [--seed N] [--out FILE]` draws a
  rig, a camera, or the targets of a set before their camera: FILE is a picture (.png)
  or a page to turn (.html); without it the page opens in the browser.

`check`, `calibrate` and `evaluate` take the folder of a mirror set, too: of a camera
that looks into a mirror which bends. A camera is written for each stage, and scored by
the boards of `--stage N`; `--report` shows the shapes and what they rest on.

`--corners` takes corners that `raxel corners --json` wrote; without it they are found
by the detector, `raxel`, `opencv` or `opencv-sb`, or by `celect`, which needs each
view's `outer_corners` in set.yaml. `--points` takes what `raxel decode` wrote; without
it an active grid is decoded as `raxel decode` does by default. Every command explains
its options with `--help`.

Results are files, a short summary goes to standard output, progress to standard
error. A line of the summary that begins with `warning:` says what went into no result,
or what no camera fits. Exit status: 0 done; 2 bad input, with one line that says what
and where, or no board in any image; 1 a file that cannot be written; 130 interrupted.
Nothing half-written is left, and of several results of one command all are written or
none. A pipe whose reader has gone (`| head -1`) stops nothing: files are written,
status 0.
"""

import contextlib
import os
import sys

from raxel.cli.parsers import parser
from raxel.cli.progress import Progress
from raxel.cli.terminal import Terminal, on_one_line
from raxel.errors import InputError


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
    try:
        options = parser().parse_args(argv)
        options.command(options, progress.say)
    except SystemExit as stop:
        return stop.code or 0
    except InputError as fault:
        _complain(fault)
        return 2
    except OSError as fault:
        name = fault.filename2 or fault.filename or "output"
        _complain(f"{name}: {fault.strerror or fault}; not written")
        return 1
    except KeyboardInterrupt:
        _complain("interrupted")
        return 130
    progress.release()
    return 0


def _complain(fault):
    print(f"raxel: {on_one_line(fault)}", file=sys.stderr)
