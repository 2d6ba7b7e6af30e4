"""A checkout with one page and all that the jobs before it leave, for tests."""

import shutil
from pathlib import Path

from repro.judge import ledger
from repro.page import style
from repro.page.execute import execute_page
from repro.page.wording import literal
from repro.run.as_columns import csv_text
from repro.run.outcomes import Drawing
from repro.run.results import write_atomic, write_json
from repro.site import assemble
from repro.site.mirror import mirror
from tests.sample_files import write

ROOT = Path(__file__).parents[1]


PAGE = """# %% [markdown]
# # 2.5 A page
#
# The value is {glue:text}`n_one.text`; half of it is {glue:text}`half:.2f` px.
# See [Fig. 2.3](#fig_2_3), [Table 2.1](#table_2_1), {cite}`zhang2000`, E-2.10 and the
# [order of coordinates](../conventions.md#plucker).
#
# $$
# M = \\begin{bmatrix} 1 & 0 \\\\ 0 & 1 \\end{bmatrix}
# \\tag{2.11}
# $$

# %%
from repro.page.exercise import check
from repro.page.reader import open_results, show, show_code, show_table, value, values


def half_of(number):
    '''Half of ``number``.'''
    return number / 2


# %% tags=["active-ipynb"]
# values()

# %% tags=["active-ipynb"]
# value("half", half_of(open_results("sweep").column("x").mean()))

# %% tags=["active-ipynb"]
# show("fig_2_3")

# %% tags=["active-ipynb"]
# show_table("table_2_1")

# %% tags=["active-ipynb"]
# show_code(csv_text)

# %% tags=["active-ipynb"]
# check(0.5, expected=lambda: half_of(1.0))

# %% tags=["active-py"]
if __name__ == "__main__":
    raise SystemExit("the notebook has no command line")
""".replace("# show_code(csv_text)", "# show_code(check)")


# Unusual names of an image, a set's camera, or a view.
ODD = (
    "<svg onload=alert(1)>.jpg",
    "a\"b'.jpg",
    "$x$.jpg",
    "{eval-rst}`x`.jpg",
    "`{raw} html`",
    "[a](javascript:x).jpg",
    "<javascript:alert(1)>",
    "|.jpg",
    "${HOME}.jpg",
    "a\\|b\\",
    "&lt;img src=x onerror=y&gt;",
    "![a](b.png){onclick=z}",
    "::::",
    ":name: taken",
    "# a *b* __c__ ~~d~~ #",
    "1. one",
    "- two",
    "> three",
    "</figcaption></td><script>4</script>",
    "{{ titles }} {% raw %}",
    "1.23456789",
    "two\n\n<b>lines</b>",
)
EXPERIMENT = """from repro.run import experiment


@experiment("sweep", artefact="fig_2_3")
def sweep(effort):
    pass
"""
INPUT_HASH = "ab" * 32
SWEEP = "ch02_sample/s5_page/experiment.py.html#sweep"
ODD_PAGE = """# %% [markdown]
# # {glue:text}`all`
#
# {glue:text}`all`
#
# {glue:text}`each`

# %%
import csv

from repro.page.reader import base, show, show_table, value
from repro.page.wording import literal


def names():
    '''Rows of the table.'''
    with (base() / "ext_odd_names.csv").open(newline="") as file:
        return [name for name, _ in csv.reader(file)][1:]


# %% tags=["active-ipynb"]
# value("all", "; ".join(map(literal, names())))

# %% tags=["active-ipynb"]
# value("each", "\\n\\n".join(map(literal, names())))

# %% tags=["active-ipynb"]
# show_table("ext_odd_names")

"""


LIBRARY = '''"""Lines: M = [a|b], `nan` where not valid."""


class Line:
    """A line through *two* points, (N, 3) each, #1 and $2."""

    places: int

    def __init__(self, a, b):
        self._a = a

    @property
    def length(self) -> float:
        """Its length, mm."""

    def moved(self, by, *, very_long_name_of_an_argument=1.0, another_argument=None):
        """The line moved.

            code = here

        Aligned:
          a   one
        """


def _hidden():
    """Nobody reads this."""
'''


def write_page(root, text, name="s5_page"):
    """Write a page file of a sample chapter below ``root``; return its path."""
    return write(root / "chapters" / "ch02_sample" / name / "page.py", text)


def run(page_file, out):
    """Execute a page as the workflow does."""
    execute_page(Path.cwd(), page_file, "quick", out)


def small_checkout(root):
    """Figures, results and a scoreboard, as the jobs before the pages leave them."""
    base = root / "figures" / "quick"
    shutil.copytree(ROOT / "data" / "published", root / "data" / "published")
    for name in ("CITATION.cff", "README.md", "REPRODUCED.md"):
        shutil.copy(ROOT / name, root)
    drawn, axes = style.new_figure()
    axes.plot([0, 1], [0, 1])
    axes.set(xlabel="Noise (px)", ylabel="Residual (px)")
    caption = "Residual against noise $\\sigma$."
    style.save_drawing(Drawing(drawn, {"noise_px": [0, 1]}, caption), base / "fig_2_3")
    about = {"caption": caption, "evidence": "synthetic", "results": ["sweep"]}
    about |= {"source": ["ch02_sample/s5_page/page.py", "half_of"], "scene": ""}
    about |= {"lines": True}
    write_json(base / "fig_2_3.json", about | {"scene": "3-D"})
    scene = '<!doctype html><html lang="en"><title>Fig. 2.3</title></html>'
    write_atomic(base / "fig_2_3.html", scene)
    columns = {"i": ["1", "2"], "V_i": ["$|a|$", "0"], "residual": [1.23456, 2.0]}
    write_atomic(base / "table_2_1.csv", csv_text(columns))
    write_json(base / "table_2_1.json", about | {"results": [], "caption": "Cells."})
    write_json(
        base / "results" / "sweep.json",
        {
            "experiment": "sweep",
            "artefact": "fig_2_3",
            "effort": "quick",
            "code": "0123",
            "seed": 2009,
            "inputs": {"small.yaml": INPUT_HASH},
            "settings": {},
            "conditions": [{}],
            "trials_per_condition": 2,
            "first_trial": 0,
            "trials": [{"condition": 0, "values": {"x": x}} for x in (1.0, 2.0)],
        },
    )
    number = {"value": 0.11345, "interval": [0.111, 0.1162], "unit": "px"}
    run = {"seconds": 1.5, "host": "some-machine", "versions": {"numpy": "2.0"}}
    run |= {"jobs": 1, "machine": "x86_64", "python": "3.11.0", "finished": "2026"}
    write_json(base / "results" / "sweep.run.json", run)
    write_json(
        base / "judged" / "ch02_sample" / "s5_page.json", {"numbers": {"n_one": number}}
    )
    kinds = [
        ("artefact", "artefact", "not yet"),
        ("claim", "claim", "differs"),
        ("n_one", "number", "setting"),
    ]
    origin = {"data": ["results/sweep.json"], "source": f"source/{SWEEP}"}
    write_json(
        base / "scoreboard.json",
        [
            {"id": name, "kind": kind, "chapter": 2, "verdict": verdict}
            | {"firmness": None, "changed": "", **origin}
            for name, kind, verdict in kinds
        ],
    )
    book = ledger.load(root)
    anchors = [
        f'<span id="{name}"></span>' for name in (*book.artefacts, *book.sections)
    ]
    write_atomic(base / "scoreboard.md", f"# Scoreboard\n\n{''.join(anchors)}Rows.\n")
    chapter = '"""Chapter 2: a sample.\n\nIts introduction.\n"""\n'
    for path, text in {
        "chapters/ch02_sample/__init__.py": chapter,
        "chapters/ch02_sample/s5_page/experiment.py": EXPERIMENT,
        "environment.txt": "numpy==2.0\n",
        "lib/raxel/rays/lines.py": LIBRARY,
        "lib/raxel/rays/__init__.py": '"""Rays | of <cameras>."""\n',
        "lib/raxel/__init__.py": '"""A *library*."""\n',
        "lib/raxel/errors.py": (ROOT / "lib/raxel/errors.py").read_bytes(),
        "data/recorded/README.md": "# Your own images\n",
    }.items():
        write_atomic(root / path, text)
    source = {
        name: path
        for name, path in assemble.files_below(ROOT / "report" / "source").items()
        if path.suffix != ".pyc"
    }
    mirror(source, root / "report" / "source")
    return base


def odd_page(root, base):
    """A page, a table and a figure for every name of ODD; returns the page's file."""
    about = {"evidence": "photograph", "results": [], "scene": "3-D", "lines": False}
    about |= {"source": ["ch02_sample/s6_odd/page.py", "names"]}
    columns = {"name": ODD, "number": [1.0] * len(ODD)}
    texts = {"caption": "; ".join(map(literal, ODD)), "texts": ["name"]}
    write_atomic(base / "ext_odd_names.csv", csv_text(columns))
    write_json(base / "ext_odd_names.json", about | texts | {"scene": ""})
    cells = []
    for number, name in enumerate(ODD):
        stem = base / f"ext_odd_{number}"
        for ending in ("svg", "png", "csv", "html"):
            write_atomic(stem.with_suffix(f".{ending}"), "<html></html>")
        write_json(stem.with_suffix(".json"), about | {"caption": literal(name)})
        cells.append(f'# %% tags=["active-ipynb"]\n# show("{stem.name}")\n')
    return write_page(root, ODD_PAGE + "\n".join(cells), "s6_odd")
