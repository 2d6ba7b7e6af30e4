"""The plan of a build: its tasks, and the jobs that run them.

A task makes one product: a rendered set, a result, a figure, a page. Its key covers the
code that it reaches and the files that it reads, so it is repeated exactly when one of
them changes, or a product of another task that it needs.

A job is one process with tasks of one stage. Starting it costs about two seconds, so
short tasks share a job, and long experiments are divided into several, according to
their measured costs (`repro.workflow.costs`).
"""

from __future__ import annotations

import hashlib
import json
import math
import re
import shlex
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache, cached_property, partial
from importlib import import_module
from pathlib import Path

from raxel.io.rendering import rendering_missing
from repro.judge.ledger import Ledger, load
from repro.run import discover, jobs
from repro.run.deciding import judged_with
from repro.run.discover import Producer
from repro.run.reach import Place, Reach
from repro.run.rendered import FOLDER as RENDERED
from repro.run.results import hash_of
from repro.workflow.costs import TABLE, Cost, costs
from repro.workflow.image_sets import ImageSets, image_sets
from repro.workflow.rendering import RenderedSets

# Stages of a build, in the order of their needs.
STAGES = ("sets", "experiments", "results", "pages", "notebooks", "report")
COMPUTING = ("sets", "experiments")
# Processor seconds up to which tasks that only read results share a job.
SHORT_S = 15.0
# The same of sets and experiments. A longer experiment is divided into such parts.
LONG_S = {"quick": 25.0, "full": 60.0}
# The same with more trials than planned: on a cluster a job waits for a node.
SCALED_S = 300.0
GATHERING_S = 1.0
# Of the largest result (fig_5_5_sweeps: 63 measured), for each multiple of the trials
# of a full build.
GATHERED_MB = 65.0
# What a job may need of the measured peak and processor time, on other machines.
MEMORY_FACTOR, TIME_FACTOR = 1.5, 4.0
UNMEASURED_MB = 2000.0
STARTING_S = 1.2  # processor time of the start of a job
STARTING_MB = 300  # of Snakemake, which starts a job on a node of a cluster
LEDGER = ("artefacts", "numbers", "claims", "settings", "contents", "conclusions")
VIEWER = (
    "lib/raxel/show/page.html",
    "lib/raxel/show/page.js",
    "lib/repro/page/templates/film.html.jinja",
)
COSTS = (TABLE.as_posix(), "lib/repro/workflow/image_costs.csv")
SITE_CODE = ("assemble", "codes", "library", "sphinx", "check")


@dataclass(frozen=True)
class BuildTask:
    """What makes one product, named KIND/ID, from the products of other tasks.

    ``unit``: tasks of one unit stay in one job. ``group``: only tasks of one group
    share a job. ``covered_by``: the experiment of a part, whose result makes it
    needless.
    """

    name: str
    stage: str
    make: Callable[[], object]
    key: Callable[[], str]
    needs: tuple[str, ...] = ()
    unit: str = ""
    group: str = ""
    covered_by: str = ""


@dataclass(frozen=True)
class Job:
    """Tasks of one process, in the order in which they run."""

    stage: str
    tasks: tuple[BuildTask, ...]

    @cached_property
    def name(self) -> str:
        """First task, and a digest of all names: another set is another job."""
        names = [task.name for task in self.tasks]
        words = re.sub(r"[^A-Za-z0-9_.-]+", "-", names[0].partition("/")[2] or names[0])
        return f"{words}-{digest(names)[:8]}"

    @property
    def title(self) -> str:
        """What the progress display shows."""
        first, *more = dict.fromkeys(task.unit or task.name for task in self.tasks)
        return f"{self.stage}: {first}" + (f" and {len(more)} more" if more else "")


class BuildPlan:
    """Tasks and jobs of a build of ``size`` up to a target of the command line.

    ``target`` is report, notebooks, a chapter (ch02) or an artefact (fig_2_3).
    """

    def __init__(
        self,
        root: Path,
        size: jobs.Size,
        recorded: str = "",
        target: str = "report",
        readings: str = "open",
    ) -> None:
        self.root, self.size, self.target = root, size, target
        self.recorded, self.readings = recorded, readings
        self.base = size.base
        self.source = f"report/build/{size.name}/source"
        self.reach = Reach(root)
        self.made = discover.producers(root)
        self.producers = {(p.kind, p.id): p for p in self.made}
        self.image_sets = ImageSets(root, self.reach, image_sets(root, recorded))
        self.rendered = RenderedSets(root, self.reach, self.made, size.effort)

    @property
    def options(self) -> str:
        """Arguments of a job, quoted for the shell; braces are for Snakemake."""
        size = self.size
        words = ["--scale", str(size.scale), "--target", self.target]
        words += ["--readings", self.readings, "--recorded", self.recorded]
        words += ["--trials", str(size.trials)] if size.trials is not None else []
        return shlex.join(words)

    # Tasks

    @cached_property
    def tasks(self) -> dict[str, BuildTask]:
        """Name -> task, of the whole report."""
        made = (
            *self._set_tasks(), *self._experiment_tasks(), *self._page_tasks(),
            *self._report_tasks(),
        )  # fmt: skip
        return {task.name: task for task in made}

    def _set_tasks(self) -> Iterator[BuildTask]:
        for name in self.rendered.names:
            make = partial(call, "repro.workflow.rendering:render_set", name)
            yield BuildTask(
                f"set/{name}", "sets", make, partial(self.rendered.key, name)
            )
        for name, folder in self.image_sets.folders.items():
            place = "repro.workflow.image_sets:calibrate_set"
            key = partial(self.image_sets.key, name)
            make = partial(call, place, folder, name)
            yield BuildTask(f"recorded/{name}", "sets", make, key)

    def _experiment_tasks(self) -> Iterator[BuildTask]:
        read = {need for p in self.made if p.kind == "experiment" for need in p.needs}
        for found in self.made:
            if found.kind != "experiment":
                continue
            name, count = f"experiment/{found.id}", self.parts(found)
            key = partial(self._experiment_key, found)
            needs = (
                *self._results(found.needs),
                *(f"set/{one}" for one in found.rendered(self.size.effort)),
            )
            group = f"{self._depth(found.id)}"
            if count == 1:
                make = partial(self._whole, found)
                yield BuildTask(name, "experiments", make, key, needs, group=group)
                continue
            parts = [f"part/{found.id}/{i}-of-{count}" for i in range(count)]
            for i, part in enumerate(parts):
                make = partial(self._part, found, i, count)
                yield BuildTask(
                    part, "experiments", make, key, needs, group=group, covered_by=name
                )
            group += " first" if found.id in read else ""
            make = partial(self._gathered, found, count)
            yield BuildTask(name, "results", make, key, (*parts, *needs), group=group)

    def parts(self, found: Producer) -> int:
        """Number of parts of an experiment; one for an unmeasured one."""
        cost = self.costs.get(f"experiment/{found.id}")
        if cost is None:
            return 1
        factor = self._factor(found, cost)
        pairs = max(1, round(cost.pairs * factor))
        seconds = cost.seconds * factor
        return min(pairs, max(1, round(seconds / (2 * self._limit("experiments")))))

    def _factor(self, found: Producer, cost: Cost) -> float:
        """Multiple of the measured trials."""
        return self.size.trials_of(found, cost.trials) / cost.trials

    def _depth(self, experiment: str) -> int:
        """Length of the longest chain of experiments that read each other's results."""
        needs = self.producers["experiment", experiment].needs
        return 1 + max(map(self._depth, needs), default=0)

    def _page_tasks(self) -> Iterator[BuildTask]:
        for page, path in self.pages.items():
            mine = [p for p in self.made if p.page == page]
            drawn = []
            for p in mine:
                if p.kind in ("figure", "table"):
                    make = partial(
                        call, "repro.page.draw:draw", self.root, p.kind, p.id,
                        self._results_folder, Path(self.base, f"{p.id}.json"),
                    )  # fmt: skip
                    name, needs = f"{p.kind}/{p.id}", self._results(p.needs)
                    key = partial(self._drawn_key, p)
                    yield BuildTask(name, "pages", make, key, needs, page)
                    drawn.append(name)
            own = [p.id for p in mine if p.kind == "experiment"]
            read = {need for p in mine for need in p.needs} | set(own)
            needs = (*self._results(sorted(read)), *drawn)
            make = partial(
                call, "repro.run.judging:judge", self.root, page, self.size.effort,
                Path(self.base), Path(self.base, "judged", f"{page}.json"),
                self.readings,
            )  # fmt: skip
            key = partial(self._judged_key, mine)
            yield BuildTask(f"judged/{page}", "pages", make, key, needs, page)
            deciding = [f"judged/{name}" for name in self.judged_with(page)]
            make = partial(
                call, "repro.page.execute:execute_page", self.root,
                path.relative_to(self.root), self.size.name, self._notebook(page),
            )  # fmt: skip
            key = partial(self._page_key, page)
            board = ("scoreboard",) if self._says(page, "READS_VERDICTS") else ()
            needs = tuple(dict.fromkeys((*board, *deciding, *needs)))
            group = "".join(board)
            yield BuildTask(
                f"notebook/{page}", "notebooks", make, key, needs, group=group
            )

    def _report_tasks(self) -> Iterator[BuildTask]:
        books = tuple(f"notebook/{page}" for page in self.pages)
        shown = tuple(f"{k}/{i}" for k, i in self.producers if k in ("figure", "table"))
        sets = tuple(f"recorded/{name}" for name in self.image_sets.folders)
        judged = tuple(f"judged/{page}" for page in self.pages)
        files = [self._notebook(page) for page in self.pages]
        board = [Path(self.base, f"scoreboard.{ending}") for ending in ("json", "md")]
        make = partial(
            call, "repro.site.scoreboard:write_board", self.root, self.size.effort,
            Path(self.base, "judged"), *board,
        )  # fmt: skip
        key = self._scoreboard_key
        yield BuildTask("scoreboard", "pages", make, key, judged, group="scoreboard")
        make = partial(
            call, "repro.workflow.scale:site", self.root, self.size.name, files,
            *board, self.image_sets.results(), Path(self.source), Path(self.size.site),
        )  # fmt: skip
        needs = ("scoreboard", *books, *shown, *sets)
        yield BuildTask("site", "report", make, self._site_key, needs)
        make = partial(
            call, "repro.site.notebooks:notebooks", files, Path("report/notebooks")
        )
        key = partial(self.reach.key, ("repro.site.notebooks", "*"))
        yield BuildTask("notebooks", "report", make, key, books)

    def _whole(self, found: Producer) -> None:
        jobs.whole(self.root, self._order(found), self._code(found), self._out(found))

    def _part(self, found: Producer, part: int, of: int) -> None:
        jobs.run(self.root, self._order(found), part, of, self._shard(found, part, of))

    def _gathered(self, found: Producer, of: int) -> None:
        shards = [self._shard(found, part, of) for part in range(of)]
        order, code = self._order(found), self._code(found)
        jobs.gather(self.root, order, code, shards, self._out(found))

    def _order(self, found: Producer) -> jobs.Order:
        return jobs.Order(found.id, self.size, self._results_folder)

    @property
    def _results_folder(self) -> Path:
        return Path(self.base, "results")

    def _out(self, found: Producer) -> Path:
        return self._results_folder / f"{found.id}.json"

    def _shard(self, found: Producer, part: int, of: int) -> Path:
        return Path(self.base, "shards", found.id, f"{part}-of-{of}.json")

    def _notebook(self, page: str) -> Path:
        return Path("report/build", self.size.name, "pages", f"{page}.ipynb")

    @staticmethod
    def _results(experiments: Iterable[str]) -> tuple[str, ...]:
        return tuple(f"experiment/{name}" for name in experiments)

    # Keys

    def _experiment_key(self, found: Producer) -> str:
        hashes = jobs.input_hashes(self.root, found)
        return digest([self._code(found), hashes])

    def _code(self, found: Producer) -> str:
        return self._key(found, jobs.CODE)

    def _drawn_key(self, found: Producer) -> str:
        """Key of an artefact, whose description links to the file of its function."""
        printed = self.published.printed(found.published) if found.published else {}
        parts = [self._key(found, (("repro.page.draw", "draw"),)), printed, found.path]
        if found.details.get("scene"):
            parts += [self._hashes(VIEWER), bool(rendering_missing())]
        return digest(parts)

    def _judged_key(self, mine: Iterable[Producer]) -> str:
        """Key of a page's claims and numbers, and of the readings that they ask for."""
        judging = [p for p in mine if p.kind in ("claim", "numbers")]
        asked = {q for p in judging for q in p.details.get("readings", ())}
        code = self.reach.key(
            *((p.module, p.function) for p in judging), ("repro.run.judging", "judge")
        )
        known = {q: self.published.readings[q] for q in sorted(asked)}
        places = [(p.path, p.function) for p in mine]
        return digest([code, known, places, self.readings])

    def _page_key(self, page: str) -> str:
        """Key of the code that a page's cells can call, and of the files it reads."""
        code = self.reach.key(
            (discover.page_module(page), "*"), ("repro.page.execute", "*"),
            ("repro.page.reader", "*"),
        )  # fmt: skip
        path = self.pages[page].relative_to(self.root).as_posix()
        files = [path, *self.ledger(), *self.pages_read(page), *self.templates("page")]
        return digest([code, self._hashes([*files, "CITATION.cff"])])

    def _scoreboard_key(self) -> str:
        code = self.reach.key(("repro.site.scoreboard", "*"))
        files = [*self.ledger(), *self.templates("page", "site")]
        return digest([code, self._hashes(files)])

    def _site_key(self) -> str:
        code = self.reach.key(
            ("repro.workflow.scale", "*"),
            *((f"repro.site.{name}", "*") for name in SITE_CODE),
        )
        return digest([code, self._hashes(self.site_sources())])

    def _key(self, found: Producer, more: tuple[Place, ...]) -> str:
        return self.reach.key((found.module, found.function), *more)

    def _hashes(self, files: Iterable[str]) -> dict[str, str]:
        return {name: hash_of(self.root / name) for name in files}

    # Files

    @cached_property
    def pages(self) -> dict[str, Path]:
        """Return page id -> chapter file."""
        files = discover.page_files(self.root)
        return {discover.page_id(self.root, path): path for path in files}

    def pages_read(self, page: str) -> list[str]:
        """Files of the chapters, and the README with the build times, for a page with
        `READS_PAGES = True`.
        """
        if not self._says(page, "READS_PAGES"):
            return []
        files = {p.relative_to(self.root).as_posix() for p in self.pages.values()}
        parts = "chapters/ch", "chapters/appendix_"
        return [*sorted(name for name in files if name.startswith(parts)), "README.md"]

    def _says(self, page: str, name: str) -> bool:
        """Whether a page's file sets a name to True."""
        text = self.pages[page].read_text("utf-8")
        return bool(re.search(rf"^{name} = True$", text, re.MULTILINE))

    def judged_with(self, page: str) -> list[str]:
        """Return the page, and those whose claims decide on its artefacts."""
        return judged_with(self.made, page, self.published)

    @cached_property
    def published(self) -> Ledger:
        """Return the ledger."""
        return load(self.root)

    def ledger(self) -> list[str]:
        """The ledger's files, and the list of unfinished chapters."""
        files = [f"data/published/{name}.yaml" for name in LEDGER]
        return [*files, "chapters/unfinished.yaml"]

    def templates(self, *rooms: str) -> list[str]:
        """Return the HTML templates next to the code of a package of `repro`."""
        found = (self.root / "lib" / "repro" / room / "templates" for room in rooms)
        paths = [path for folder in found for path in sorted(folder.glob("*.jinja"))]
        return [path.relative_to(self.root).as_posix() for path in paths]

    def site_sources(self) -> list[str]:
        """Return the files of the site's own source, the guide, and the displayed
        code."""
        shown = [
            *(self.root / "report" / "source").rglob("*"),
            *(self.root / "lib" / "raxel").rglob("*.py*"),
            *(self.root / "chapters").glob("*/**/*.py"),
        ]
        single = ["data/recorded/README.md", "data/published/errata.md", "CITATION.cff"]
        single += ["README.md", "REPRODUCED.md", "environment.txt", *COSTS]
        return [*single, *self.ledger(), *self.templates("page", "site")] + sorted(
            path.relative_to(self.root).as_posix()
            for path in shown
            if path.is_file() and "__pycache__" not in path.parts
        )

    def record(self, task: str) -> Path:
        """Return the path of the record of a task; sets are shared by all sizes."""
        kind, _, name = task.partition("/")
        folders = {"set": RENDERED, "recorded": "report/build/sets"}
        folder = (
            f"{folders[kind]}/.records"
            if kind in folders
            else f"{self.base}/records/{kind}"
        )
        return self.root / folder / f"{name or 'all'}.json"

    def product(self, task: str) -> Path:
        """Return the file to look at of a figure, a table or a notebook."""
        kind, _, name = task.partition("/")
        endings = {"figure": "svg", "table": "csv"}
        if kind in endings:
            return Path(self.base, f"{name}.{endings[kind]}")
        return self._notebook(name)

    def marker(self, job: Job) -> str:
        """Return the file that a job leaves."""
        return f"{self.base}/jobs/{job.stage}/{job.name}.json"

    # Jobs

    @cached_property
    def costs(self) -> dict[str, Cost]:
        """Measured costs of the tasks by their names."""
        return costs(self.root).get(self.size.effort, {})

    @cached_property
    def final(self) -> list[str]:
        """Names of the tasks of the target; LookupError if there is no such target."""
        if self.target in ("report", "notebooks"):
            return ["site" if self.target == "report" else "notebooks"]
        if re.fullmatch(r"ch\d+|appendix_[a-z]", self.target):
            folder = f"{self.target}_", f"{self.target}/"
            return [
                f"notebook/{page}" for page in self.pages if page.startswith(folder)
            ]
        named = [f"{kind}/{self.target}" for kind in ("figure", "table")]
        return [name for name in named if name in self.tasks]

    @cached_property
    def wanted(self) -> list[BuildTask]:
        """The tasks of the target, and all that they need, in order."""
        seen, waiting = set(), list(self.final)
        while waiting:
            name = waiting.pop()
            if name not in seen:
                seen.add(name)
                waiting += self.tasks[name].needs
        return [task for name, task in self.tasks.items() if name in seen]

    @cached_property
    def jobs(self) -> dict[tuple[str, str], Job]:
        """Stage and name -> job."""
        made = [job for stage in STAGES for job in self._packed(stage)]
        return {(job.stage, job.name): job for job in made}

    def _packed(self, stage: str) -> Iterator[Job]:
        """Jobs of a stage: tasks in order, until a job is long enough."""
        groups: dict[str, dict[str, list[BuildTask]]] = {}
        for task in self.wanted:
            if task.stage == stage:
                units = groups.setdefault(task.group, {})
                units.setdefault(task.unit or task.name, []).append(task)
        limit = math.inf if stage in ("results", "report") else self._limit(stage)
        for units in groups.values():
            held: list[BuildTask] = []
            length = 0.0
            for tasks in units.values():
                seconds = sum(map(self.seconds, tasks))
                if held and length + seconds > limit:
                    yield Job(stage, tuple(held))
                    held, length = [], 0.0
                held, length = [*held, *tasks], length + seconds
            yield Job(stage, tuple(held))

    def _limit(self, stage: str) -> float:
        if stage not in COMPUTING:
            return SHORT_S
        return SCALED_S if self.size.scale > 1 else LONG_S[self.size.effort]

    def seconds(self, task: BuildTask) -> float:
        """Return the expected processor seconds; an unmeasured task has its own job."""
        cost = self.cost(task)
        if task.stage == "results":
            return GATHERING_S
        if cost is None:
            return self._limit(task.stage)
        if task.stage != "experiments":
            return cost.seconds
        found = self.producers["experiment", task.name.split("/")[1]]
        return cost.seconds * self._factor(found, cost) / self.parts(found)

    def cost(self, task: BuildTask) -> Cost | None:
        """Return the measured cost; of a part, that of the experiment."""
        kind, *names = task.name.split("/")
        key = f"experiment/{names[0]}" if kind == "part" else task.name
        return self.costs.get(key)

    def minutes(self, job: Job) -> int:
        """Return the time limit of a job."""
        return 5 + math.ceil(TIME_FACTOR * sum(map(self.seconds, job.tasks)) / 60)

    def memory_mb(self, job: Job) -> int:
        """Return the memory that a job reserves; only trials are held one by one."""
        known = [self.cost(task) for task in job.tasks]
        peak = max(cost.peak_mb if cost else UNMEASURED_MB for cost in known)
        if job.stage not in COMPUTING:
            peak += GATHERED_MB * (self.size.scale - 1)
        return 100 * math.ceil((MEMORY_FACTOR * peak + STARTING_MB) / 100)

    def before(self, job: Job) -> list[str]:
        """Return the markers of the jobs that a job waits for."""
        needed = dict.fromkeys(need for task in job.tasks for need in task.needs)
        jobs_ = dict.fromkeys(self.job_of[name] for name in needed)
        return [self.marker(other) for other in jobs_ if other != job]

    @cached_property
    def job_of(self) -> dict[str, Job]:
        """Name of a task -> its job."""
        return {task.name: job for job in self.jobs.values() for task in job.tasks}

    def key(self, job: Job) -> str:
        """Return the key over all tasks of a job."""
        return digest([task.key() for task in job.tasks])


def call(place: str, *given: object) -> object:
    """Call MODULE:FUNCTION, which is imported only now."""
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)(*given)


@cache
def planned(
    root: Path, size: jobs.Size, recorded: str, target: str, readings: str
) -> BuildPlan:
    """Return the plan of a build, shared by the command and the rules."""
    return BuildPlan(root, size, recorded, target, readings)


def digest(content: object) -> str:
    """Return a short hash of JSON content."""
    text = json.dumps(content, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
