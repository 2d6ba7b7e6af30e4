"""`make crate`: the built report as a Workflow Run RO-Crate, one zip file, validated.

It contains the tracked files of the checkout, the site, and the files that
`codecheck.yml` lists. It runs in an environment of its own (`lib/repro/crate.txt`), and
without a network.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import mimetypes
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from importlib.resources import files
from pathlib import Path

import yaml
from requests import Request
from requests_cache import CachedResponse, CachedSession
from rocrate.model import ContextEntity
from rocrate.rocrate import ROCrate
from rocrate_validator.services import ValidationSettings, validate

CONTEXT = "https://w3id.org/ro/crate/1.1/context"
PROFILE = "workflow-run-crate"
PROFILES = {
    "https://w3id.org/ro/wfrun/process/0.5": "Process Run Crate",
    "https://w3id.org/ro/wfrun/workflow/0.5": "Workflow Run Crate",
    "https://w3id.org/workflowhub/workflow-ro-crate/1.0": "Workflow RO-Crate",
}
LICENCES = {
    "https://spdx.org/licenses/MIT": "MIT License (code)",
    "https://spdx.org/licenses/CC-BY-4.0": "CC BY 4.0 (text and figures)",
}
SHA256 = "https://w3id.org/ro/terms/workflow-run#sha256"
INPUTS = ("data/published/", "data/rigs/", "data/recorded/", "environment.txt")


def write_crate(root: Path, effort: str, out: Path) -> None:
    """Write the crate of a finished build as a folder."""
    target, site = ("quick", "site-quick") if effort == "quick" else ("report", "site")
    done = root / f"figures/{effort}/records/site/all.json"
    if _git("status", "--porcelain"):
        sys.exit("make crate: uncommitted changes; commit them: it names the commit")
    runs = [
        json.loads(path.read_text("utf-8"))
        for path in root.glob(f"figures/{effort}/results/*.run.json")
    ]
    crate = ROCrate(version="1.1")
    crate.metadata.extra_terms["sha256"] = SHA256
    with tempfile.TemporaryDirectory() as folder:
        _git("checkout-index", "--all", f"--prefix={folder}/")
        workflow = _add_tracked(crate, Path(folder))
        workflow["softwareRequirements"] = _software(crate, runs)
        crate.root_dataset["mentions"] = crate.add_action(
            workflow,
            "#build",
            object=[crate.get(name) for name in INPUTS],
            result=[
                crate.add_dataset(root / "report" / site, f"report/{site}"),
                *_outputs(crate, root, effort),
            ],
            properties={
                "name": f"make {target}",
                "description": "Build of the report. Unchanged results are of earlier "
                f"builds. Machine: {', '.join({run['machine'] for run in runs})}.",
                "startTime": min(map(_started, runs)).isoformat("T", "seconds"),
                "endTime": datetime.fromtimestamp(done.stat().st_mtime, UTC).isoformat(
                    "T", "seconds"
                ),
            },
        )
        _describe(crate, json.loads((root / "codemeta.json").read_text("utf-8")))
        crate.write(out)


def _git(*words: str) -> str:
    return subprocess.check_output(["git", *words], text=True).strip()


def _entity(crate: ROCrate, identifier: str, kind: str, **about: str) -> ContextEntity:
    return crate.add(ContextEntity(crate, identifier, {"@type": kind, **about}))


def _add_tracked(crate: ROCrate, tracked: Path) -> ContextEntity:
    """Add the files of the checkout; return the workflow."""
    pins = (tracked / "environment.txt").read_text("utf-8")
    version = re.search(r"^snakemake==(\S+)", pins, re.MULTILINE)[1]
    workflow = crate.add_workflow(
        tracked / "Snakefile",
        "Snakefile",
        main=True,
        lang="snakemake",
        lang_version=version,
    )
    for path in sorted([*tracked.iterdir(), *(tracked / "data").iterdir()]):
        name = path.relative_to(tracked).as_posix()
        if path.is_file() and name != "Snakefile":
            crate.add_file(path, name, properties=_format(name))
        elif path.is_dir() and name != "data":
            crate.add_dataset(path, name)
    crate.get("README.md")["about"] = crate.root_dataset
    return workflow


def _format(name: str) -> dict[str, str]:
    return {"encodingFormat": mimetypes.guess_type(name)[0] or "text/plain"}


def _describe(crate: ROCrate, about: dict) -> None:
    """Name, authors, licences, commit and profiles of the crate."""
    crate.mainEntity["version"] = about["version"]
    known = {
        "name": f"Report of {about['name']}",
        "description": "The report, its workflow, its inputs and its environment.",
        "identifier": f"swh:1:rev:{_git('rev-parse', 'HEAD')}",
        "author": _entity(
            crate, "#authors", "Organization", name=about["author"][0]["name"]
        ),
        "license": [
            _entity(crate, identifier, "CreativeWork", name=name)
            for identifier, name in LICENCES.items()
        ],
        "conformsTo": [
            _entity(crate, i, "CreativeWork", name=name, version=i.split("/")[-1])
            for i, name in PROFILES.items()
        ],
    }
    for key, value in known.items():
        crate.root_dataset[key] = value


def _software(crate: ROCrate, runs: Sequence[dict]) -> list[ContextEntity]:
    """Python and packages in the versions that the runs recorded."""
    used = {("pypi", *item) for run in runs for item in run["versions"].items()}
    used |= {("generic", "python", run["python"]) for run in runs}
    return [
        _entity(
            crate,
            f"pkg:{source}/{name}@{version}",
            "SoftwareApplication",
            name=name,
            softwareVersion=version,
        )
        for source, name, version in sorted(used)
    ]


def _outputs(crate: ROCrate, root: Path, effort: str) -> list:
    """The files of `codecheck.yml`, each with its hash."""
    found = []
    for one in yaml.safe_load((root / "codecheck.yml").read_text("utf-8"))["manifest"]:
        name = one["file"].replace("figures/full/", f"figures/{effort}/")
        digest = hashlib.sha256((root / name).read_bytes()).hexdigest()
        about = {"name": one["comment"], "sha256": digest, **_format(name)}
        found.append(crate.add_file(root / name, name, properties=about))
    return found


def _started(run: dict) -> datetime:
    """Begin of a run; its jobs share the seconds."""
    seconds = run["seconds"] / run["jobs"]
    return datetime.fromisoformat(run["finished"]) - timedelta(seconds=seconds)


def violations(crate: Path) -> list[str]:
    """Return the REQUIRED rules of the profile that a crate violates.

    The validator fetches the context of RO-Crate. Its cache gets the copy in rocrate.
    """
    copy = files("rocrate").joinpath("data/ro-crate.jsonld").read_bytes()
    kind = {"Content-Type": "application/ld+json"}
    with tempfile.TemporaryDirectory() as folder:
        cache = f"{folder}/contexts"
        with CachedSession(cache, backend="sqlite") as session:
            key = session.cache.create_key(Request("GET", CONTEXT))
            session.cache.responses[key] = CachedResponse(
                status_code=200, url=CONTEXT, content=copy, headers=kind
            )
        settings = ValidationSettings(
            rocrate_uri=str(crate),
            profile_identifier=PROFILE,
            requirement_severity="REQUIRED",
            offline=True,
            cache_path=Path(cache),
        )
        issues = validate(settings).get_issues()
    return [f"{issue.check.identifier}: {issue.message}" for issue in issues]


def main() -> int:
    """Write and validate the crate; return 1 if it violates the profile."""
    parser = argparse.ArgumentParser(prog="python -m repro.site.crate")
    parser.add_argument("--effort", choices=("quick", "full"), default="full")
    effort = parser.parse_args().effort
    out = f"report/raxel-crate-{effort}"
    with tempfile.TemporaryDirectory() as folder:
        write_crate(Path.cwd(), effort, Path(folder))
        found = violations(Path(folder))
        shutil.make_archive(out, "zip", folder)
    print(*found, f"{out}.zip: {len(found)} violations of {PROFILE} 0.5", sep="\n")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
