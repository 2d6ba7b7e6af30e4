# The thesis, regenerated: experiments -> results -> figures -> verdicts -> pages.
# `make help` lists the targets; lib/repro/workflow/rules holds the rules.


configfile: "lib/repro/workflow/rules/config.yaml"


include: "lib/repro/workflow/rules/common.smk"
include: "lib/repro/workflow/rules/sets.smk"
include: "lib/repro/workflow/rules/experiments.smk"
include: "lib/repro/workflow/rules/artefacts.smk"
include: "lib/repro/workflow/rules/report.smk"


rule all:
    default_target: True
    input:
        rules.site.output,
