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


# One result for both sizes. A set that the command rejects leaves its message.
rule calibrated_set:
    output:
        record="report/build/sets/{set}.json",
    log:
        "report/build/sets/{set}.log",
    conda:
        "environment.yaml"
    params:
        folder=WORK.image_sets.folder,
        code=WORK.image_sets.key,
        times=TIMES,
    message:
        "image set {wildcards.set}"
    shell:
        "RAXEL_TIMES={params.times} job recorded/{wildcards.set} "
        "repro.workflow.image_sets {params.folder:q} {wildcards.set} > {log:q} 2>&1"
