"""`python -m tests.mutants [WORD ...]`: is every mutant caught by the tests it names?

Each is made in a copy of the checkout, never in place, and only its own tests run. With
words, only the mutants whose names hold one of them.
"""

import os
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tests.mutants import trial
from tests.mutants.mutant import ROOT, load_mutants


def main(words, root=ROOT, mutants=None, cores=None):
    """Print a line for each mutant; return 0 where all are caught, else 1."""
    mutants = load_mutants() if mutants is None else mutants
    chosen = [m for m in mutants if not words or any(w in m.name for w in words)]
    if not chosen:
        print(f"no mutant has {' or '.join(words)} in its name", file=sys.stderr)
        return 1
    cores = cores or len(os.sched_getaffinity(0))
    with tempfile.TemporaryDirectory(prefix="mutants-") as room:
        copies = trial.Copies(Path(root), Path(room), cores)
        fault = trial.fault_without(copies, chosen)
        if fault:
            print(f"the tests fail without any mutant:\n{fault}", file=sys.stderr)
            return 1
        caught = 0
        with ThreadPoolExecutor(cores) as pool:
            found = pool.map(lambda m: trial.outcome(copies, m), chosen)
            for mutant, (said, why) in zip(chosen, found, strict=True):
                remark = f": {why}" if why else ""
                print(f"{said:<12} {mutant.name}{remark}", flush=True)
                caught += said == trial.CAUGHT
    print(f"{caught} of {len(chosen)} mutants caught")
    return 0 if caught == len(chosen) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
