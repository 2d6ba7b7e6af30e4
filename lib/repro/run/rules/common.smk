from pathlib import Path

from repro.run.sets_of_report import sets_of_report
from repro.run.workflow import Work

WORK = Work(
    Path.cwd(),
    effort=config["effort"],
    trials=int(config["trials"]) if config.get("trials") else None,
    sets=sets_of_report(Path.cwd(), config.get("recorded", "")),
)

# One thread per job: the cores are shared out by the workflow, and sums stay the same.
shell.prefix(
    "set -euo pipefail; export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 "
    "MKL_NUM_THREADS=1 OPENCV_FOR_THREADS_NUM=1 PYTHONHASHSEED=0 "
    f"RAXEL_EFFORT={config['effort']}; "
    'export MPLCONFIGDIR="$PWD/.cache/matplotlib" MPLBACKEND=Agg; '
)


wildcard_constraints:
    experiment="[A-Za-z0-9_]+(@[^/]+)?",
    artefact="[a-z]+_[a-z0-9_]+(@[^/]+)?",
    page="[a-z0-9_]+/[^/]+",
    shard=r"\d+",
    of=r"\d+",
