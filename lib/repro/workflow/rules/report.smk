rule scoreboard:
    input:
        judged=WORK.judged(),
        ledger=WORK.ledger(),
        templates=WORK.templates("page", "site"),
    output:
        rows=f"{WORK.base}/scoreboard.json",
        page=f"{WORK.base}/scoreboard.md",
    log:
        f"{WORK.base}/logs/scoreboard.log",
    conda:
        "environment.yaml"
    params:
        code=KEYS.scoreboard(),
        effort=WORK.effort,
        judged=WORK.folder(f"{WORK.base}/judged"),
    message:
        "scoreboard"
    shell:
        "job scoreboard repro.site.scoreboard --effort {params.effort} "
        "--judged {params.judged:q} --out-json {output.rows:q} "
        "--out-page {output.page:q} > {log:q} 2>&1"


rule page:
    input:
        WORK.page_inputs,
    output:
        notebook=f"{WORK.pages_folder}/{{page}}.ipynb",
    log:
        f"{WORK.base}/logs/pages/{{page}}.log",
    conda:
        "environment.yaml"
    params:
        code=KEYS.page,
        effort=WORK.effort,
        source=WORK.page_source,
    message:
        "page {wildcards.page}"
    shell:
        "job page/{wildcards.page} repro.page.execute {params.source:q} "
        "--effort {params.effort} --out {output.notebook:q} > {log:q} 2>&1"


rule site:
    input:
        pages=WORK.notebooks(),
        artefacts=WORK.artefact_files(),
        rows=f"{WORK.base}/scoreboard.json",
        page=f"{WORK.base}/scoreboard.md",
        sets=WORK.image_sets.results(),
        sources=WORK.site_sources(),
    output:
        done=touch(WORK.site_done),
    log:
        f"{WORK.base}/logs/site.log",
    conda:
        "environment.yaml"
    params:
        code=KEYS.site(),
        effort=WORK.effort,
        source=WORK.folder(WORK.source),
        site=WORK.folder(WORK.site),
    message:
        "site"
    shell:
        "(job site/assemble repro.site.assemble --effort {params.effort} "
        "--pages {input.pages:q} --scoreboard {input.page:q} --json {input.rows:q} "
        "--sets {input.sets:q} --out {params.source:q} && "
        "job site/sphinx repro.site.sphinx --source {params.source:q} --out {params.site:q} && "
        "job site/check repro.site.check {params.site:q}) > {log:q} 2>&1"


rule notebooks:
    input:
        WORK.notebooks(),
    output:
        touch("report/notebooks/.done"),
    log:
        f"{WORK.base}/logs/notebooks.log",
    conda:
        "environment.yaml"
    params:
        code=KEYS.notebooks(),
        folder=WORK.folder("report/notebooks"),
    message:
        "notebooks"
    shell:
        "job notebooks repro notebooks {input:q} --out {params.folder:q} > {log:q} 2>&1"
