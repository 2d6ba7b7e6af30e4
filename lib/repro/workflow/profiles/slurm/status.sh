#!/bin/sh
# Print the state of a Slurm job for Snakemake: success, failed or running.
# Slurm forgets old jobs (MinJobAge): such a job runs again, without its finished tasks.
# If Slurm does not answer, the job counts as running.
trap '' INT
answer=$(scontrol --oneliner show job "$1" 2>&1)
state=$(echo "$answer" | sed -n 's/.* JobState=\([A-Z_]*\).*/\1/p')
case "${state:-$answer}" in
COMPLETED) echo success ;;
BOOT_FAIL | CANCELLED | DEADLINE | FAILED | NODE_FAIL | OUT_OF_MEMORY | PREEMPTED | TIMEOUT) echo failed ;;
*"Invalid job id"*) echo failed ;;
*) echo running ;;
esac
