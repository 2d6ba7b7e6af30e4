# The thesis, regenerated: experiments -> results -> figures -> verdicts -> pages.
# `make help` lists the targets; lib/repro/run/rules holds the rules.


configfile: "lib/repro/run/rules/config.yaml"


include: "lib/repro/run/rules/common.smk"
include: "lib/repro/run/rules/experiments.smk"
include: "lib/repro/run/rules/artefacts.smk"
include: "lib/repro/run/rules/report.smk"


rule all:
    default_target: True
    input:
        rules.site.output,
