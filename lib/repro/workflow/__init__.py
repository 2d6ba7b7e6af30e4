"""The workflow: from a command to a finished build, with Snakemake."""
