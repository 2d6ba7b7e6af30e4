"""States of jobs on a cluster, as Snakemake reads them."""

import os
import subprocess
from pathlib import Path

import pytest

from repro.workflow.build import PROFILES

ROOT = Path(__file__).resolve().parents[3]


@pytest.mark.parametrize(
    ("answer", "state"),
    [
        ("JobId=7 JobState=PENDING Reason=JobHeldUser", "running"),
        ("JobId=7 JobState=COMPLETING Reason=TimeLimit", "running"),
        ("JobId=7 JobState=COMPLETED Reason=None", "success"),
        ("JobId=7 JobState=TIMEOUT Reason=TimeLimit", "failed"),
        ("JobId=7 JobState=OUT_OF_MEMORY Reason=OutOfMemory", "failed"),
        ("JobId=7 JobState=CANCELLED Reason=None", "failed"),
        ("slurm_load_jobs error: Invalid job id specified", "failed"),
        ("slurm_load_jobs error: Unable to contact slurm controller", "running"),
    ],
)
def test_status_of_slurm_job(tmp_path, answer, state):
    scontrol = tmp_path / "scontrol"
    scontrol.write_text(f'#!/bin/sh\necho "{answer}"\n')
    scontrol.chmod(0o755)
    environment = {"PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}"}
    script = ROOT / PROFILES / "slurm" / "status.sh"
    done = subprocess.run(
        [script, "7"], env=environment, capture_output=True, text=True
    )
    assert done.stdout.split() == [state]
