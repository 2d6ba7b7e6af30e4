from pathlib import Path

from repro.run.rendered import TIMES
from repro.workflow.forks import PINNED
from repro.workflow.keys import CodeKeys
from repro.workflow.work import planned

WORK = planned(
    Path.cwd(),
    config["effort"],
    int(config["trials"]) if config.get("trials") else None,
    config.get("recorded") or "",
)
KEYS = CodeKeys(WORK)

# A job is forked from a warm process where the build keeps one (repro.workflow.forks).
# Ctrl-C reaches every process of a terminal; that one then ends what has to end.
shell.prefix(
    'set -euo pipefail; [ -z "${{RAXEL_JOBS:-}}" ] || trap "" INT TERM; export '
    + " ".join(f"{name}={value}" for name, value in PINNED.items())
    + f" RAXEL_EFFORT={config['effort']} RAXEL_TIMES={WORK.base}/times"
    + ' MPLCONFIGDIR="$PWD/.cache/matplotlib"; '
    + 'job() {{ python -I -S lib/repro/workflow/ask.py "$@"; }}; '
)


wildcard_constraints:
    experiment="[A-Za-z0-9_]+",
    artefact="[a-z]+_[a-z0-9_]+",
    page="[a-z0-9_]+/[^/]+",
    shard=r"\d+",
    of=r"\d+",
