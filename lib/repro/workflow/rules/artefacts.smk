rule figure:
    input:
        WORK.result_files("figure"),
    output:
        description=f"{WORK.base}/{{artefact}}.json",
        svg=f"{WORK.base}/{{artefact}}.svg",
        png=f"{WORK.base}/{{artefact}}.png",
        data=f"{WORK.base}/{{artefact}}.csv",
    log:
        f"{WORK.base}/logs/{{artefact}}.log",
    wildcard_constraints:
        artefact=WORK.pattern("figure"),
    conda:
        "environment.yaml"
    params:
        code=KEYS.figure,
        results=WORK.folder(f"{WORK.base}/results"),
    message:
        "figure {wildcards.artefact}"
    shell:
        "job figure/{wildcards.artefact} repro figure {wildcards.artefact:q} "
        "--results {params.results:q} --out {output.description:q} > {log:q} 2>&1"


# A figure that can be turned around leaves one file more.
use rule figure as turnable_figure with:
    input:
        WORK.scene_inputs,
    output:
        description=f"{WORK.base}/{{artefact}}.json",
        svg=f"{WORK.base}/{{artefact}}.svg",
        png=f"{WORK.base}/{{artefact}}.png",
        data=f"{WORK.base}/{{artefact}}.csv",
        scene=f"{WORK.base}/{{artefact}}.html",
    wildcard_constraints:
        artefact=WORK.pattern("figure", scene=True),
    params:
        code=KEYS.scene,
        results=WORK.folder(f"{WORK.base}/results"),


rule table:
    input:
        WORK.result_files("table"),
    output:
        description=f"{WORK.base}/{{artefact}}.json",
        data=f"{WORK.base}/{{artefact}}.csv",
    log:
        f"{WORK.base}/logs/{{artefact}}.log",
    wildcard_constraints:
        artefact=WORK.pattern("table"),
    conda:
        "environment.yaml"
    params:
        code=KEYS.table,
        results=WORK.folder(f"{WORK.base}/results"),
    message:
        "table {wildcards.artefact}"
    shell:
        "job table/{wildcards.artefact} repro table {wildcards.artefact:q} "
        "--results {params.results:q} --out {output.description:q} > {log:q} 2>&1"


rule judge:
    input:
        WORK.judged_inputs,
    output:
        judged=f"{WORK.base}/judged/{{page}}.json",
    log:
        f"{WORK.base}/logs/judged/{{page}}.log",
    conda:
        "environment.yaml"
    params:
        code=KEYS.judge,
        effort=WORK.effort,
        folder=WORK.folder(WORK.base),
        readings=config["readings"],
    message:
        "claims and numbers of {wildcards.page}"
    shell:
        "job judge/{wildcards.page} repro judge {wildcards.page:q} "
        "--effort {params.effort} --folder {params.folder:q} "
        "--readings {params.readings} --out {output.judged:q} > {log:q} 2>&1"
