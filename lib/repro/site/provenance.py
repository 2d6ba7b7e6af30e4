"""Pages of provenance: code, seed, inputs and versions behind each number.

`provenance/<experiment>.html` describes one result. `provenance/<page>.html` lists the
numbers that the text of a page quotes, with the code and the results of each.
"""

from __future__ import annotations

import ast
import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from jinja2 import Template

from repro.page.furniture import in_words
from repro.page.notebook import GLUED
from repro.page.templates import environment
from repro.run.discover import Producer
from repro.run.where import OF_NUMBER
from repro.site.source_pages import TEMPLATES, definitions


def experiment_page(made: Producer, result: Path) -> str:
    """Return HTML about a result file, with its record of the run."""
    record = result.with_suffix(".run.json")
    return _template().render(
        name=f"provenance/{made.id}",
        up="../",
        made=made,
        result=json.loads(result.read_text("utf-8")),
        run=json.loads(record.read_text("utf-8")),
    )


def quoted_page(root: Path, notebook: Path, rows: Mapping[str, Mapping]) -> str:
    """Return HTML about the quoted numbers of an executed page.

    ``rows`` are those of the scoreboard by id: they have code and results of a number
    of the ledger.
    """
    about = json.loads(notebook.read_text("utf-8"))["metadata"]["raxel"]
    text = (root / "chapters" / about["source"]).read_text("utf-8")
    quoted = []
    for name, form in dict.fromkeys(GLUED.findall(text)):
        made = about["names"][name]
        row = rows.get(OF_NUMBER.sub("", name), {})
        source = row.get("source") or _code_of(root, made)
        results = [Path(file).stem for file in row["data"]] if row else made["results"]
        quoted.append((format(made["value"], form), name, source, results))
    page = f"{notebook.parent.name}/{notebook.stem}"
    return _template().render(
        name=f"provenance/{page}", up="../../", page=page, quoted=quoted
    )


def _code_of(root: Path, made: Mapping) -> str:
    """The address of the function that named a value, or of the page whose cell did."""
    known = dict(definitions(ast.parse((root / made["path"]).read_text("utf-8")), ""))
    anchor = f"#{made['function']}" if made["function"] in known else ""
    return f"source/{made['path'].removeprefix('chapters/')}.html{anchor}"


@cache
def _template() -> Template:
    templates = environment(TEMPLATES)
    templates.filters["words"] = in_words
    return templates.get_template("provenance.html.jinja")
