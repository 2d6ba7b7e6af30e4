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


class CrateError(Exception):
    """A build of which no crate can be made; one line."""


def write_crate(root: Path, effort: str, out: Path) -> None:
    """Write the crate of a finished build as a folder; raises CrateError without
    one."""
    target, site = ("quick", "site-quick") if effort == "quick" else ("report", "site")
    done = root / f"report/build/{effort}/site.done"
    if not done.is_file():
        raise CrateError(f"no finished {effort} build; run make {target}")
    if _git(root, "status", "--porcelain"):
        raise CrateError("uncommitted changes; commit them, the crate names a commit")
    runs = [
        json.loads(path.read_text("utf-8"))
        for path in sorted(root.glob(f"figures/{effort}/results/*.run.json"))
    ]
    machines = ", ".join(sorted({run["machine"] for run in runs}))
    ended = datetime.fromtimestamp(done.stat().st_mtime, UTC)
    with tempfile.TemporaryDirectory() as folder:
        _git(root, "checkout-index", "--all", f"--prefix={folder}/")
        crate = ROCrate(version="1.1")
        workflow = _add_tracked(crate, Path(folder))
        _describe(crate, root)
        workflow["softwareRequirements"] = _software(crate, runs)
        built = crate.add_dataset(root / "report" / site, f"report/{site}")
        crate.root_dataset["mentions"] = crate.add_action(
            workflow,
            "#build",
            object=[crate.get(name) for name in INPUTS],
            result=[built, *_outputs(crate, root, effort)],
            properties={
                "name": f"make {target}",
                "description": f"Build of the report on {machines}. Unchanged results "
                "are of earlier builds.",
                "startTime": min(map(_started, runs)).isoformat("T", "seconds"),
                "endTime": ended.isoformat("T", "seconds"),
            },
        )
        crate.write(out)


def _git(root: Path, *words: str) -> str:
    """Output of a git command."""
    command = ["git", "-C", str(root), *words]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise CrateError(f"git {words[0]}: {done.stderr.strip()}")
    return done.stdout.strip()


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


def _format(name: str) -> dict:
    return {"encodingFormat": mimetypes.guess_type(name)[0] or "text/plain"}


def _describe(crate: ROCrate, root: Path) -> None:
    """Name, authors, licences, commit and profiles of the crate."""
    about = json.loads((root / "codemeta.json").read_text("utf-8"))
    crate.name = f"Report of {about['name']}"
    crate.description = (
        "The report, the workflow that built it, its inputs and its environment."
    )
    crate.mainEntity["version"] = about["version"]
    crate.metadata.extra_terms["sha256"] = SHA256
    crate.root_dataset["identifier"] = f"swh:1:rev:{_git(root, 'rev-parse', 'HEAD')}"
    crate.root_dataset["author"] = crate.add(
        ContextEntity(crate, "#authors", about["author"][0])
    )
    entities = {
        "license": [(i, _named(n)) for i, n in LICENCES.items()],
        "conformsTo": [
            (i, {**_named(n), "version": i.rpartition("/")[2]})
            for i, n in PROFILES.items()
        ],
    }
    for key, described in entities.items():
        found = [crate.add(ContextEntity(crate, i, dict(p))) for i, p in described]
        crate.root_dataset[key] = found


def _named(name: str) -> dict:
    return {"@type": "CreativeWork", "name": name}


def _software(crate: ROCrate, runs: Sequence[dict]) -> list[ContextEntity]:
    """Python and packages in the versions that the runs recorded."""
    used = {item for run in runs for item in run["versions"].items()}
    found = {(f"pkg:pypi/{name}@{v}", name, v) for name, v in used}
    found |= {
        (f"pkg:generic/python@{r['python']}", "Python", r["python"]) for r in runs
    }
    return [
        crate.add(
            ContextEntity(
                crate,
                identifier,
                {"@type": "SoftwareApplication", "name": name, "softwareVersion": v},
            )
        )
        for identifier, name, v in sorted(found)
    ]


def _outputs(crate: ROCrate, root: Path, effort: str) -> list:
    """The files of `codecheck.yml`, each with its hash."""
    checked = yaml.safe_load((root / "codecheck.yml").read_text("utf-8"))
    found = []
    for one in checked["manifest"]:
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


def main(argv: Sequence[str] | None = None) -> int:
    """Write and validate the crate; return 1 if it violates the profile."""
    parser = argparse.ArgumentParser(prog="python -m repro.site.crate")
    parser.add_argument("--effort", choices=("quick", "full"), default="full")
    effort = parser.parse_args(argv).effort
    out = f"report/raxel-crate-{effort}"
    with tempfile.TemporaryDirectory() as folder:
        try:
            write_crate(Path.cwd(), effort, Path(folder))
        except CrateError as error:
            print(f"make crate: {error}", file=sys.stderr)
            return 1
        found = violations(Path(folder))
        shutil.make_archive(out, "zip", folder)
    print(*found, f"{out}.zip: {len(found)} violations of {PROFILE} 0.5", sep="\n")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
