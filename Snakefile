# The thesis, regenerated: image sets -> results -> figures -> verdicts -> pages.
# A job runs the tasks that lib/repro/workflow/plan.py gives it, and skips fresh ones.
# `make help` lists the targets.
from pathlib import Path

from repro.run.jobs import Size
from repro.workflow.plan import STAGES, planned


configfile: "lib/repro/workflow/config.yaml"


TRIALS = int(config["trials"]) if config["trials"] else None
SIZE = Size(config["effort"], TRIALS, int(config["scale"]))
CHOSEN = (config["recorded"] or "", config["target"], config["readings"])
PLAN = planned(Path.cwd(), SIZE, *CHOSEN)

# One thread a job: the workflow assigns the cores, and sums are reproducible.
shell.prefix(
    "set -euo pipefail; export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 "
    "MKL_NUM_THREADS=1 OPENCV_FOR_THREADS_NUM=1 PYTHONHASHSEED=0 MPLBACKEND=Agg "
    f"RAXEL_EFFORT={SIZE.name} "
    'MPLCONFIGDIR="$PWD/.cache/matplotlib"; '
)


rule all:
    default_target: True
    input:
        [PLAN.marker(job) for job in PLAN.jobs.values()],


for stage in STAGES:

    rule:
        name:
            stage
        input:
            lambda wildcards, stage=stage: PLAN.before(PLAN.jobs[stage, wildcards.job]),
        output:
            marker=f"{PLAN.base}/jobs/{stage}/{{job}}.json",
        log:
            f"{PLAN.base}/logs/{stage}/{{job}}.log",
        conda:
            "lib/repro/workflow/environment.yaml"
        threads: 1
        resources:
            mem_mb=lambda wildcards, attempt, stage=stage: (
                attempt * PLAN.memory_mb(PLAN.jobs[stage, wildcards.job])
            ),
            runtime=lambda wildcards, attempt, stage=stage: (
                attempt * PLAN.minutes(PLAN.jobs[stage, wildcards.job])
            ),
        params:
            key=lambda wildcards, stage=stage: PLAN.key(PLAN.jobs[stage, wildcards.job]),
            title=lambda wildcards, stage=stage: PLAN.jobs[stage, wildcards.job].title,
            stage=stage,
            effort=SIZE.effort,
            more=PLAN.options,
        message:
            "{params.title}"
        shell:
            "python -m repro.workflow.job {params.stage} {wildcards.job} "
            "--effort {params.effort} {params.more} > {log:q} 2>&1"
