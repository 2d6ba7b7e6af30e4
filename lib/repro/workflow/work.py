"""Paths and jobs for the rules of the Snakefile; `keys` has the keys of their code."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable
from functools import cache, cached_property
from pathlib import Path

from repro.judge.ledger import Ledger, load
from repro.run import discover
from repro.run.deciding import judged_with
from repro.run.jobs import input_hashes
from repro.run.reach import Reach
from repro.run.rendered import manifest
from repro.workflow.image_sets import ImageSets, image_sets
from repro.workflow.rendering import RenderedSets

GUIDE = "data/recorded/README.md"
VIEWER = (
    "lib/raxel/show/page.html",
    "lib/raxel/show/page.js",
    "lib/repro/page/templates/film.html.jinja",
)
ERRATA = "data/published/errata.md"
LEDGER = ("artefacts", "numbers", "claims", "settings", "contents", "conclusions")


class Work:
    """The plan of one build: effort, what-if trials, and the image sets with a page."""

    def __init__(
        self, root: Path, effort: str, trials: int | None, sets: dict[str, str]
    ) -> None:
        self.root = root
        self.effort = effort
        self.trials = trials
        self.sets = sets
        self.base = f"figures/{effort}"
        if trials is not None:
            self.base = f"figures/what-if/{effort}-trials-{trials}"
        self.pages_folder = f"report/build/{effort}/pages"
        self.source = f"report/build/{effort}/source"
        self.site = "report/site" if effort == "full" else f"report/site-{effort}"
        # The site itself is not an output: Snakemake would delete its start page first.
        self.site_done = f"report/build/{effort}/site.done"
        self.trials_option = "" if trials is None else f"--trials {trials}"
        self.reach = Reach(root)

    @cached_property
    def made(self) -> list[discover.Producer]:
        """Return every producer of the chapters, listed once: a build has one plan."""
        return discover.producers(self.root)

    @cached_property
    def producers(self) -> dict[tuple[str, str], discover.Producer]:
        """Return (kind, id) -> producer."""
        return {(producer.kind, producer.id): producer for producer in self.made}

    @cached_property
    def image_sets(self) -> ImageSets:
        """The image sets that the report calibrates."""
        return ImageSets(self.root, self.reach, self.sets)

    @cached_property
    def rendered(self) -> RenderedSets:
        """The rendered sets that experiments declare."""
        return RenderedSets(self.root, self.reach, self.made, self.effort)

    @cached_property
    def pages(self) -> dict[str, Path]:
        """Return page id -> chapter file."""
        return {
            discover.page_id(self.root, path): path
            for path in discover.page_files(self.root)
        }

    def of_page(self, page: str, *kinds: str) -> list[str]:
        """Ids of the page's producers of the given kinds."""
        return [p.id for p in self.made if p.page == page and p.kind in kinds]

    # Files

    @staticmethod
    def folder(path: str):
        """Parameter function for a folder that holds a rule's outputs."""

        def given(wildcards) -> str:
            return path

        return given

    def experiments(self, sharded: bool) -> str:
        """Wildcard constraint: the experiments of several jobs, or those of one."""
        return _one_of(
            identifier
            for kind, identifier in self.producers
            if kind == "experiment" and (self._shard_count(identifier) > 1) == sharded
        )

    def shards(self, wildcards) -> list[str]:
        """Shard files of an experiment."""
        name = wildcards.experiment
        count = self._shard_count(name)
        return [f"{self.base}/shards/{name}/{i}-of-{count}.json" for i in range(count)]

    def _shard_count(self, name: str) -> int:
        return self.producers["experiment", name].shards(self.effort)

    def inputs(self, wildcards) -> list[str]:
        """Return the results and the inputs that an experiment reads."""
        producer = self.producers["experiment", wildcards.experiment]
        declared = list(producer.inputs)
        sets = map(manifest, producer.rendered(self.effort))
        return self._result_files("experiment", wildcards.experiment) + [
            *declared,
            *sets,
        ]

    def input_key(self, wildcards) -> str:
        """Return the hash over names and content of all inputs except results."""
        producer = self.producers["experiment", wildcards.experiment]
        found = input_hashes(self.root, producer)
        text = json.dumps(found, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def pattern(self, kind: str, scene: bool = False) -> str:
        """Return a wildcard constraint: the artefacts of one kind, with a scene or not.

        The rules differ in their outputs, which Snakemake requires in advance.
        """
        return _one_of(
            identifier
            for (of_kind, identifier), producer in self.producers.items()
            if of_kind == kind and bool(producer.details.get("scene")) == scene
        )

    def page_source(self, wildcards) -> str:
        """Chapter file of a page."""
        return self.pages[wildcards.page].relative_to(self.root).as_posix()

    def result_files(self, kind: str):
        """Input function: the results that a figure or table reads."""

        def files(wildcards) -> list[str]:
            return self._result_files(kind, wildcards.artefact)

        return files

    def _result_files(self, kind: str, identifier: str) -> list[str]:
        needs = self.producers[kind, identifier].needs
        return [f"{self.base}/results/{name}.json" for name in needs]

    def scene_inputs(self, wildcards) -> list[str]:
        """Return the inputs of a figure with a scene: results, and the viewer's
        files."""
        return self._result_files("figure", wildcards.artefact) + list(VIEWER)

    def files_of_artefact(self, kind: str, identifier: str) -> list[str]:
        """Return the description file of a figure or table, which names its other
        files, and its scene, so that a missing scene is made.
        """
        scene = self.producers[kind, identifier].details.get("scene")
        endings = ("json", "html") if scene else ("json",)
        return [f"{self.base}/{identifier}.{ending}" for ending in endings]

    def artefact_files(self, page: str | None = None) -> list[str]:
        """Return the description files and scenes of a page, or of all pages."""
        wanted = set(self.of_page(page, "figure", "table")) if page else None
        return [
            path
            for kind, identifier in self.producers
            if kind in ("figure", "table") and (wanted is None or identifier in wanted)
            for path in self.files_of_artefact(kind, identifier)
        ]

    def page_results(self, page: str) -> list[str]:
        """Return the results that any producer of the page reads."""
        files: set[str] = set()
        for kind in ("figure", "table", "claim", "numbers"):
            for identifier in self.of_page(page, kind):
                files |= set(self._result_files(kind, identifier))
        for identifier in self.of_page(page, "experiment"):
            files.add(f"{self.base}/results/{identifier}.json")
        return sorted(files)

    def judged_inputs(self, wildcards) -> list[str]:
        """Return the inputs of judging a page."""
        return self.page_results(wildcards.page) + self.artefact_files(wildcards.page)

    def page_inputs(self, wildcards) -> list[str]:
        """Return the inputs of executing a page, its own file first."""
        return [
            self.page_source(wildcards),
            *self.judged_with(wildcards.page),
            *self.judged_inputs(wildcards),
            *self.ledger(),
            *self.pages_read(wildcards.page),
            *self.templates("page"),
            "CITATION.cff",
        ]

    def pages_read(self, page: str) -> list[str]:
        """Files of the chapters, and the README with the build times, for a page with
        `READS_PAGES = True`; the scoreboard for one with `READS_VERDICTS = True`.
        """
        text = self.pages[page].read_text("utf-8")
        if re.search(r"^READS_VERDICTS = True$", text, re.MULTILINE):
            return [f"{self.base}/scoreboard.json"]
        if not re.search(r"^READS_PAGES = True$", text, re.MULTILINE):
            return []
        files = {p.relative_to(self.root).as_posix() for p in self.pages.values()}
        parts = "chapters/ch", "chapters/appendix_"
        chapters = sorted(name for name in files if name.startswith(parts))
        return [*chapters, "README.md"]

    def judged_with(self, page: str) -> list[str]:
        """Return the page's judged file, and those that decide on its artefacts."""
        pages = judged_with(self.made, page, self.published)
        return [f"{self.base}/judged/{name}.json" for name in pages]

    @cached_property
    def published(self) -> Ledger:
        """Return the ledger."""
        return load(self.root)

    def judged(self) -> list[str]:
        """Judged files of every page."""
        return [f"{self.base}/judged/{page}.json" for page in self.pages]

    def notebooks(self) -> list[str]:
        """Executed notebooks of every page."""
        return [f"{self.pages_folder}/{page}.ipynb" for page in self.pages]

    def ledger(self) -> list[str]:
        """The ledger's files, and the list of unfinished chapters."""
        return [f"data/published/{name}.yaml" for name in LEDGER] + [
            "chapters/unfinished.yaml"
        ]

    def templates(self, *rooms: str) -> list[str]:
        """Return the HTML templates next to the code of a package of `repro`."""
        return [
            path.relative_to(self.root).as_posix()
            for room in rooms
            for path in sorted(self.root.glob(f"lib/repro/{room}/templates/*.jinja"))
        ]

    def site_sources(self) -> list[str]:
        """Return the files of the site's own source, the guide, and the displayed
        code."""
        shown = [
            *(self.root / "report" / "source").rglob("*"),
            *(self.root / "lib" / "raxel").rglob("*.py"),
            *(self.root / "chapters").glob("*/**/*.py"),
        ]
        ledger = [*self.ledger(), ERRATA, "CITATION.cff"]
        return [GUIDE, *ledger, *self.templates("page", "site")] + sorted(
            path.relative_to(self.root).as_posix()
            for path in shown
            if path.is_file() and "__pycache__" not in path.parts
        )


@cache
def planned(root: Path, effort: str, trials: int | None, recorded: str) -> Work:
    """Return the work of a build, shared by the command and the rules."""
    return Work(root, effort, trials, image_sets(root, recorded))


def _one_of(names: Iterable[str]) -> str:
    """A pattern that fits exactly the names."""
    return "|".join(map(re.escape, names)) or "(?!)"
