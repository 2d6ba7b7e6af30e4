# One set for all that declare it, of either size: nothing here knows the size.
rule rendered_set:
    input:
        "data/rigs/{rig}.yaml",
    output:
        manifest="data/synthetic/{rig}/{seed}.json",
    log:
        "data/synthetic/{rig}/{seed}.log",
    conda:
        "environment.yaml"
    params:
        code=WORK.rendered.of_rule,
        times=TIMES,
    message:
        "rendered set {wildcards.rig}/{wildcards.seed}"
    shell:
        "RAXEL_TIMES={params.times} job {wildcards.rig}/{wildcards.seed} "
        "repro.workflow.rendering {wildcards.rig:q} {wildcards.seed} > {log:q} 2>&1"
