# An experiment of one job leaves its result itself.
rule whole:
    input:
        files=WORK.inputs,
    output:
        result=f"{WORK.base}/results/{{experiment}}.json",
    log:
        f"{WORK.base}/logs/results/{{experiment}}.log",
    wildcard_constraints:
        experiment=WORK.experiments(sharded=False),
    conda:
        "environment.yaml"
    params:
        code=KEYS.experiment,
        effort=WORK.effort,
        files=WORK.input_key,
        trials=WORK.trials_option,
        results=WORK.folder(f"{WORK.base}/results"),
    message:
        "experiment {wildcards.experiment}"
    shell:
        "job experiment/{wildcards.experiment} repro whole {wildcards.experiment:q} "
        "--effort {params.effort} "
        "{params.trials} --results {params.results:q} "
        "--code {params.code} "
        "--out {output.result:q} > {log:q} 2>&1"


rule shard:
    input:
        WORK.inputs,
    output:
        records=f"{WORK.base}/shards/{{experiment}}/{{shard}}-of-{{of}}.json",
        arrays=f"{WORK.base}/shards/{{experiment}}/{{shard}}-of-{{of}}.npz",
    log:
        f"{WORK.base}/logs/shards/{{experiment}}/{{shard}}-of-{{of}}.log",
    conda:
        "environment.yaml"
    params:
        code=KEYS.experiment,
        effort=WORK.effort,
        files=WORK.input_key,
        trials=WORK.trials_option,
        results=WORK.folder(f"{WORK.base}/results"),
    message:
        "experiment {wildcards.experiment}, part {wildcards.shard} of {wildcards.of}"
    shell:
        "job experiment/{wildcards.experiment}/{wildcards.shard}-of-{wildcards.of} "
        "repro run {wildcards.experiment:q} --effort {params.effort} "
        "{params.trials} --results {params.results:q} "
        "--shard {wildcards.shard}/{wildcards.of} "
        "--out {output.records:q} > {log:q} 2>&1"


rule gather:
    input:
        files=WORK.inputs,
        shards=WORK.shards,
    output:
        result=f"{WORK.base}/results/{{experiment}}.json",
    log:
        f"{WORK.base}/logs/results/{{experiment}}.log",
    wildcard_constraints:
        experiment=WORK.experiments(sharded=True),
    conda:
        "environment.yaml"
    params:
        code=KEYS.experiment,
        effort=WORK.effort,
        files=WORK.input_key,
        trials=WORK.trials_option,
        results=WORK.folder(f"{WORK.base}/results"),
    message:
        "result {wildcards.experiment}"
    shell:
        "job result/{wildcards.experiment} repro gather {wildcards.experiment:q} "
        "--effort {params.effort} "
        "{params.trials} --results {params.results:q} "
        "--code {params.code} "
        "--shards {input.shards:q} "
        "--out {output.result:q} > {log:q} 2>&1"
