"""Chapters and ledger: producers of all entries, and no access to published values."""

import ast
import importlib
from collections import Counter

import pytest

from repro.judge import ledger, verdict
from repro.run.discover import page_files, page_id, producers
from repro.run.source_index import import_aliases
from tests.small_checkouts import ROOT

LEDGER = ledger.load(ROOT)
PRODUCERS = producers(ROOT)
CHAPTER_FILES = sorted((ROOT / "chapters").rglob("*.py"))
HIDDEN = {
    "repro.judge.ledger",
    "repro.judge.number_rules",
    "repro.judge.verdict",
    "repro.judge.scoreboard",
    "repro.page.rows",
}
# The last table of a page shows its rows of the scoreboard, and chapter 6 all verdicts.
# It is display code: each import stands inside its function of the reader, and nothing
# of it goes back to an experiment.
READER = "repro.page.reader"
DISPLAY = {
    "compared": "repro.page.rows",
    "scoreboard": "repro.judge.scoreboard",
    "show_part": "repro.page.rows",
}


def of_thesis(identifier):
    return not identifier.startswith("ext_")


def test_artefacts_have_one_producer():
    unfinished = verdict.read_unfinished(ROOT)
    made = Counter(p.id for p in PRODUCERS if p.kind in ("figure", "table"))
    for identifier, entry in LEDGER.artefacts.items():
        if made[identifier]:
            assert made[identifier] == 1, f"{identifier} has several producers"
        else:
            assert str(entry["chapter"]) in unfinished, f"nothing makes {identifier}"


def test_producers_are_in_ledger():
    known = {"figure": LEDGER.artefacts, "table": LEDGER.artefacts}
    known |= {"claim": LEDGER.claims}
    assert {"figure", "table", "claim", "numbers"} <= {p.kind for p in PRODUCERS}
    for found in PRODUCERS:
        if found.kind in known and of_thesis(found.id):
            assert found.id in known[found.kind], f"{found.page}: {found.id}"
        about = found.details.get("artefact", found.id)
        if found.kind in ("experiment", "numbers") and of_thesis(about):
            LEDGER.entry(about)


def numbers_named():
    """(file, id) of every `"id": Value(...)` in the chapters."""
    for path in CHAPTER_FILES:
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if not isinstance(node, ast.Dict):
                continue
            for key, value in zip(node.keys, node.values, strict=True):
                is_value = isinstance(value, ast.Call) and ast.unparse(value.func)
                if is_value == "Value" and isinstance(key, ast.Constant):
                    yield path, key.value


def test_numbers_are_in_ledger():
    named = list(numbers_named())
    assert named
    for path, identifier in named:
        if of_thesis(identifier):
            assert identifier in LEDGER.numbers, f"{path.name}: {identifier}"


def names_of_options():
    """(module, {question: {option: what the trials call it}}) of all `Case`s."""
    for path in CHAPTER_FILES:
        if "import Case" in path.read_text("utf-8"):
            name = module_name(path)
            mappings = vars(importlib.import_module(name)).values()
            for names in (one for one in mappings if isinstance(one, dict) and one):
                if {*names} <= {*LEDGER.readings}:
                    yield name, names


def test_readings_match_settings():
    found = list(names_of_options())
    assert len(found) > 5
    for module, names in found:
        for question, options in names.items():
            entry = LEDGER.readings[question]
            assert list(options) == entry["options"], f"{module}: {question}"
            # Where a claim does not ask, the chapter takes its first option.
            assert next(iter(options)) == entry["primary"], f"{module}: {question}"


def test_fig_2_3_uses_values_of_settings():
    from chapters.ch02_general_camera_model.s5_1_synthetic_data import page
    from chapters.shared.general import three_planes as three_planes

    chosen = {k: e["value"] for k, e in LEDGER.settings["syn_ch2"]["chosen"].items()}
    used = {
        "noise_levels": list(page.LEVELS),
        "noise_in_fov_sweep": page.FOV_NOISE,
        "fov_in_noise_sweep_deg": page.NOISE_FOV_DEG,
        "lens_of_noise_sweep": {"k1": three_planes.LENS_K1, "k2": three_planes.LENS_K2},
        "fov_levels_deg": list(page.FOVS_DEG),
        "principal_point_px": three_planes.PRINCIPAL.tolist(),
        "grid_distance_mm": three_planes.DISTANCE_MM,
        "grid_shift_mm": [-three_planes.SHIFT_MM, three_planes.SHIFT_MM],
        "grid_tilt_deg": list(three_planes.TILT_DEG),
        "least_angle_between_grids_deg": three_planes.MIN_ANGLE_DEG,
        "finite_grid_mm": [-three_planes.FINITE_MM, three_planes.FINITE_MM],
    }
    assert {name: chosen[name] for name in used} == used


# The experiments cannot see the answer


def module_name(path, base=ROOT):
    name = path.relative_to(base).with_suffix("").as_posix().replace("/", ".")
    return name.removesuffix(".__init__")


def source_files():
    """Module -> file, of the chapters and of everything in lib."""
    lib = ROOT / "lib"
    files = {module_name(path): path for path in CHAPTER_FILES}
    return files | {module_name(p, lib): p for p in sorted(lib.rglob("*.py"))}


def imports(name, path, known):
    """Modules that a file imports, inside functions too, with their parents."""
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            targets = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            aliases = import_aliases(node, package).values()
            targets = [part for m, n in aliases for part in (m, f"{m}.{n}")]
        else:
            continue
        for target in targets:
            parts = target.split(".")
            for end in range(1, len(parts) + 1):
                if ".".join(parts[:end]) in known:
                    yield ".".join(parts[:end])


def graph():
    files = source_files()
    return {name: set(imports(name, path, files)) for name, path in files.items()}


def reached(edges, start):
    found, todo = set(), [start]
    while todo:
        name = todo.pop()
        if name not in found:
            found.add(name)
            todo += edges[name]
    return found


@pytest.fixture(scope="module")
def edges():
    return graph()


def test_chapters_and_raxel_do_not_import_ledger(edges):
    allowed = set(DISPLAY.values())
    assert allowed <= edges[READER], "an allowed import is gone: take it off here"
    without = {**edges, READER: edges[READER] - allowed}
    starts = [n for n in edges if n.split(".")[0] in ("chapters", "raxel")]
    assert len(starts) > 20
    for start in starts:
        assert not reached(without, start) & HIDDEN, start


def test_allowed_imports_are_inside_display_functions():
    tree = ast.parse((ROOT / "lib/repro/page/reader.py").read_text("utf-8"))
    holders = {
        function.name: node.module
        for function in ast.walk(tree)
        if isinstance(function, ast.FunctionDef)
        for node in ast.walk(function)
        if isinstance(node, ast.ImportFrom) and node.module in DISPLAY.values()
    }
    assert holders == DISPLAY
    top = [n.module for n in tree.body if isinstance(n, ast.ImportFrom)]
    assert not set(DISPLAY.values()) & set(top)


def test_display_is_called_in_commented_cells_only():
    for path in CHAPTER_FILES:
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Call):
                assert ast.unparse(node.func) not in DISPLAY, path


def test_import_of_ledger_is_detected(edges):
    assert "repro.judge.ledger" in reached(edges, "repro.page.reader")
    assert "repro.judge.ledger" in edges["repro.judge.verdict"]


@pytest.mark.parametrize("word", ["data/published", "import_module", "__import__"])
def test_chapters_and_raxel_do_not_name_ledger(word):
    for name, path in source_files().items():
        if name.split(".")[0] in ("chapters", "raxel"):
            assert word not in path.read_text("utf-8"), name


def test_producers_belong_to_pages():
    pages = {page_id(ROOT, path) for path in page_files(ROOT)}
    lost = [f"{p.id}: {p.page}" for p in PRODUCERS if p.page not in pages]
    assert not lost, lost
