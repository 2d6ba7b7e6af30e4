"""The workflow: from an order to a finished build, with Snakemake."""
