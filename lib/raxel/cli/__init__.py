"""The program `raxel`.

Its commands are `new`, `check`, `corners`, `decode`, `calibrate`, `evaluate`,
`undistort`, `show`, `export`, `import`, `board`, `patterns` and `render`.
`raxel COMMAND --help` explains each.

Results are files. A short summary goes to standard output, with one line `warning: ...`
per problem; progress goes to standard error. The exit status is

- 0: success;
- 1: a result cannot be written;
- 2: invalid input, an invalid command line, or no board in any image; one line
  `raxel: file: field: problem; what to do` states the reason;
- 3: with `--strict`, a misfit or an undetermined focal length; results are written;
- 130: interrupted.

No file is left half-written: of several results of one command, all are written or
none. A closed pipe (`raxel check SET | head -1`) does not stop a command. Colours and
the progress bar are for terminals only; the variable `NO_COLOR` turns colours off.
"""

import _thread
import contextlib
import errno
import os
import sys
from collections.abc import Sequence

import click

from raxel.cli.commands import PROGRAM
from raxel.cli.terminal import Progress, Terminal, on_one_line
from raxel.errors import InputError

# The matrices are small, and threads of BLAS only wait for each other: a calibration of
# 15 images takes 36 s instead of 42 s. The variable counts when numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return the exit status.

    Parameters
    ----------
    argv : sequence of str or None
        Words of the command line without the program's name. None stands for those of
        the process.

    Returns
    -------
    int
        Exit status: 0, 1, 2, 3 or 130.
    """
    out, err = Terminal(sys.stdout), Terminal(sys.stderr)
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        with contextlib.closing(Progress(err)) as progress:
            status, problem = _run(sys.argv[1:] if argv is None else argv, progress)
        out.flush()
        if not status and out.fault and out.fault.errno != errno.EPIPE:
            status = 1
            problem = f"raxel: standard output: {out.fault.strerror}; results are saved"
        if problem:
            print(on_one_line(problem), file=err)
        err.flush()
    return status


def _run(argv: Sequence[str], progress: Progress) -> tuple[int, str]:
    """Return the exit status and what to print in case of a problem."""
    # With several threads, OpenCV's fits differ in the last digits from run to run.
    os.environ.setdefault("OPENCV_FOR_THREADS_NUM", "1")
    sys.unraisablehook = _interrupt_again
    try:
        with PROGRAM.make_context("raxel", list(argv), obj=progress.say) as context:
            PROGRAM.invoke(context)
    except click.exceptions.Exit as stop:
        return stop.exit_code, ""
    except click.UsageError as fault:
        return 2, _usage(argv, fault)
    except InputError as fault:
        return 2, f"raxel: {fault}"
    except OSError as fault:
        name = fault.filename2 or fault.filename or "output"
        return 1, f"raxel: {name}: {fault.strerror or fault}; not written"
    except KeyboardInterrupt:
        return 130, "raxel: interrupted"
    progress.release()
    return 0, ""


def _interrupt_again(fault):
    """Repeat a Ctrl-C that a callback of compiled code, as of numba, would discard."""
    if isinstance(fault.exc_value, KeyboardInterrupt):
        _thread.interrupt_main()
    else:
        sys.__unraisablehook__(fault)


def _usage(argv: Sequence[str], fault: click.UsageError) -> str:
    known = [word for word in argv[:1] if word in PROGRAM.commands]
    command = " ".join(["raxel", *known])
    message = fault.format_message().rstrip(".")
    if possible := getattr(fault, "possibilities", None):
        message = f"{fault.message.rstrip('.')} (did you mean {possible[0]}?)"
    return f"{command}: {message[0].lower()}{message[1:]}; see {command} --help"
