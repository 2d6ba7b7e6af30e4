# The thesis, regenerated: experiments -> results -> figures -> verdicts -> pages.
# `make help` lists the targets; lib/repro/rules holds the rules.


configfile: "lib/repro/rules/config.yaml"


include: "lib/repro/rules/common.smk"
include: "lib/repro/rules/experiments.smk"
include: "lib/repro/rules/artefacts.smk"
include: "lib/repro/rules/report.smk"


rule all:
    default_target: True
    input:
        rules.site.output,
