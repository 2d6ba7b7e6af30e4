"""Keys over the code of each job: if one changes, the job runs again."""

from __future__ import annotations

import hashlib
import json

from raxel.io.rendering import rendering_missing
from repro.run import discover
from repro.run.jobs import CODE
from repro.workflow.work import Work

DRAW_CODE = (("repro.page.draw", "draw"),)
JUDGE_CODE = (("repro.run.judging", "judge"),)


class CodeKeys:
    """The keys of one build's jobs."""

    def __init__(self, work: Work) -> None:
        self._work = work

    def experiment(self, wildcards) -> str:
        """Return the key over the code that an experiment reaches."""
        return self._key("experiment", wildcards.experiment, CODE)

    def figure(self, wildcards) -> str:
        """Return the key over the code that draws a figure."""
        return self._drawn("figure", wildcards.artefact)

    def scene(self, wildcards) -> str:
        """Return the same for a figure with a scene, and whether scenes can be
        rendered."""
        flat = " not rendered" if rendering_missing() else ""
        return self.figure(wildcards) + flat

    def table(self, wildcards) -> str:
        """Return the key over the code that fills a table."""
        return self._drawn("table", wildcards.artefact)

    def _drawn(self, kind: str, identifier: str) -> str:
        """Key of an artefact, whose description links to the file of its function."""
        key = self._key(kind, identifier, DRAW_CODE)
        return f"{key} {self._work.producers[kind, identifier].module}"

    def _key(self, kind: str, identifier: str, more) -> str:
        producer = self._work.producers[kind, identifier]
        key = self._work.reach.key((producer.module, producer.function), *more)
        return key + self._hash_of(self._work.published.printed(producer.published))

    @staticmethod
    def _hash_of(content: dict) -> str:
        """Suffix of a key for values of the ledger; empty without any."""
        if not content:
            return ""
        text = json.dumps(content, sort_keys=True)
        return f"-{hashlib.sha256(text.encode()).hexdigest()[:16]}"

    def judge(self, wildcards) -> str:
        """Return the key over the code of a page's judgements."""
        page = wildcards.page
        functions = [
            (producer.module, producer.function)
            for kind in ("claim", "numbers")
            for i in self._work.of_page(page, kind)
            for producer in [self._work.producers[kind, i]]
        ]
        key = self._work.reach.key(*functions, *JUDGE_CODE)
        asked = {
            question
            for i in self._work.of_page(page, "claim")
            for question in self._work.producers["claim", i].details.get("readings", ())
        }
        return key + self._hash_of({q: self._work.published.readings[q] for q in asked})

    def page(self, wildcards) -> str:
        """Return the key over the code that a page's cells can call."""
        module = discover.page_module(wildcards.page)
        return self._work.reach.key(
            (module, "*"), ("repro.page.execute", "*"), ("repro.page.reader", "*")
        )

    def scoreboard(self) -> str:
        """Return the key over the code of the scoreboard."""
        return self._work.reach.key(("repro.site.scoreboard", "*"))

    def notebooks(self) -> str:
        """Return the key over the code that makes notebooks to work in."""
        return self._work.reach.key(("repro.site.notebooks", "*"))

    def site(self) -> str:
        """Return the key over the code that assembles the site."""
        rooms = ("assemble", "codes", "library", "sphinx", "check")
        return self._work.reach.key(*((f"repro.site.{name}", "*") for name in rooms))
