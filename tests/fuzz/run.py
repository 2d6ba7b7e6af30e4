"""Damage whatever can be read, by the thousand: `make fuzz`, with a table of counts.

A mutant is determined by seed, reader and number, so that one can be looked at again:
`python -m tests.fuzz.run --readers rig --first 17 --mutants 1 --show`. Each reader has
a process of its own, which is ended where a mutant takes more than SECONDS of processor
time, and begun anew behind it. Inputs that make a fault stay in tests/fuzz/failures.
"""

import argparse
import faulthandler
import multiprocessing
import os
import shutil
import signal
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

from tests.fuzz.outcome import READ, REFUSED, outcome
from tests.fuzz.readers import READERS, write_mutant

SECONDS, WAITING = 20, 9
FAILURES = Path(__file__).with_name("failures")
# A process is exchanged after so many, as memory's high water never falls.
BATCH = 500


def main(arguments=None):
    """Run; the exit status is 1 where there are faults."""
    counts = counted(arguments)
    print(_table(counts))
    return int(any(set(count) - {READ, REFUSED} for count in counts.values()))


def counted(arguments=None):
    """{reader: Counter of outcomes}, by the command line's arguments."""
    options = _options(arguments)
    with ThreadPoolExecutor(options.cores) as pool:
        return dict(
            zip(
                options.readers,
                pool.map(lambda name: _counts(name, options), options.readers),
                strict=True,
            )
        )


def _counts(name, options):
    """Counter of the outcomes of a reader's mutants."""
    count, number = Counter(), options.first
    end = options.first + options.mutants
    while number < end:
        last = min(number + BATCH, end)
        with tempfile.TemporaryDirectory(prefix="fuzz-") as folder:
            number = _batch(name, options, range(number, last), folder, count)
    return count


def _batch(name, options, numbers, folder, count):
    """Count a batch in a process of its own; the number of the first one not done."""
    ours, theirs = multiprocessing.Pipe(duplex=False)
    process = multiprocessing.get_context("spawn").Process(
        target=_work, args=(name, options, numbers, folder, theirs)
    )
    process.start()
    theirs.close()
    number = _collect(name, ours, count, numbers.start, options)
    process.join()
    if process.exitcode:
        if not _place(name, number).exists():
            raise RuntimeError(
                f"{name}: the harness itself failed at {number}: {process.exitcode}"
            )
        # It ended in the midst of a mutant: too slow, or the process died.
        died = "hang" if (_place(name, number) / "told").stat().st_size else "crash"
        _tell(name, number, died, f"exit status {process.exitcode}", options)
        count[died] += 1
        number += 1
    return number


def _collect(name, pipe, count, number, options):
    """Count what a process reports; the number of the first mutant it did not."""
    while True:
        try:
            kind, told = pipe.recv()
        except EOFError:
            return number
        count[kind] += 1
        if kind not in (READ, REFUSED) or options.show:
            _tell(name, number, kind, told, options)
        number += 1


def _work(name, options, numbers, folder, pipe):
    """Read mutants and report each."""
    reader = READERS[name]
    samples = reader.samples()
    reader.prepare(Path(folder))
    for number in numbers:
        content = write_mutant(reader, folder, options.seed, number, samples)
        _keep(name, number, content)
        with (_place(name, number) / "told").open("w") as file, _limited(file):
            kind, told = outcome(reader, folder, number)
        if kind in (READ, REFUSED):
            shutil.rmtree(_place(name, number))
        pipe.send((kind, told))
        if kind == "memory":
            # High water never falls.
            break


@contextmanager
def _limited(file):
    """End the process, its traceback in `file`, after SECONDS of its own time.

    One that waits for something is ended too, later: on a busy machine others run.
    """
    faulthandler.register(signal.SIGPROF, file=file, chain=True)
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    faulthandler.dump_traceback_later(WAITING * SECONDS, exit=True, file=file)
    yield
    faulthandler.cancel_dump_traceback_later()
    signal.setitimer(signal.ITIMER_PROF, 0)
    faulthandler.unregister(signal.SIGPROF)


def _place(name, number):
    return FAILURES / f"{name}-{number}"


def _keep(name, number, content):
    _place(name, number).mkdir(parents=True, exist_ok=True)
    (_place(name, number) / "content").write_bytes(content)


def _tell(name, number, kind, told, options):
    if kind not in (READ, REFUSED):
        (_place(name, number) / "outcome").write_text(f"{kind}\n{told}\n")
    last = told.strip().splitlines()[-1] if told.strip() else ""
    print(f"{name} {number}: {kind}: {last[:300]}", flush=True)


def _table(counts):
    faults = sorted(set().union(*counts.values()) - {READ, REFUSED})
    heads = ["reader", "mutants", READ, REFUSED, *faults]
    rows = [heads]
    for name, count in counts.items():
        numbers = [sum(count.values()), *(count[head] for head in heads[2:])]
        rows.append([name, *map(str, numbers)])
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join(
        "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True))
        for row in rows
    )


def _options(arguments):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--readers", nargs="+", default=list(READERS), choices=READERS)
    parser.add_argument("--mutants", type=int, default=2000, help="of each reader")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--cores", type=int, default=os.cpu_count())
    parser.add_argument("--show", action="store_true", help="say what became of each")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    raise SystemExit(main())
