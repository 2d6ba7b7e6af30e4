"""`make where`: from an id to the files and lines behind it."""

import ast
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

from repro.judge.ledger import load
from repro.run import where
from repro.run.discover import page_files, page_id, producers
from repro.run.names import parsed as parsed_file
from repro.run.reach import Reach

ROOT = Path(__file__).resolve().parents[1]
ATLAS = where.Whereabouts(ROOT)
MADE = producers(ROOT)
# What leads to no function of the library, and why.
BOOK_KEEPING = {
    "c3_border_formula": "arithmetic of the printed formula alone",
    "fig2_5_scale": "the scale at which arrows are drawn",
    "fig2_6_images": "a count of pictures",
    "fig2_6_step": "a step of the stage, put into the rig",
    "fig2_6_scale": "the scale at which arrows are drawn",
    "fig3_16_scale": "the scale at which arrows are drawn",
    "fig5_14_scale": "the scale at which arrows are drawn",
    "fig5_19_defl": "a push of the mirror, put into the rig",
}


@cache
def words(identifier):
    """(word, file, line) of what stands behind an id."""
    found = []
    for line in ATLAS.lines(identifier):
        path, _, number = line.place.rpartition(":")
        found.append((line.word, path, int(number)))
    return found


def source_line(path, number):
    return (ROOT / path).read_text("utf-8").splitlines()[number - 1]


def test_a_table_leads_to_its_trial():
    found = [n for n in words("table_3_4") if n[0] != "data"]
    found = [n for n in found if n[0] != "algorithm"]
    kinds = [word for word, _, _ in found]
    assert kinds[:5] == ["page", "trial", "experiment", "table", "numbers"]
    assert set(kinds[5:]) == {"claim"}
    lines = [source_line(path, number) for _, path, number in found]
    assert lines[1].startswith("def grid_trial(")
    assert lines[2].startswith("def pictures_of_sets(")
    assert lines[3].startswith("def table_3_4(")
    assert all(line.startswith("def ") for line in lines[1:])


def test_a_claim_leads_to_its_test_and_what_it_read():
    found = [n for n in words("c2_noise_linear_generic") if n[0] != "data"]
    kinds = list(dict.fromkeys(word for word, _, _ in found))
    assert kinds == ["page", "trial", "experiment", "algorithm", "claim"]
    assert found[0][1].endswith("s5_1_synthetic_data/page.py")
    assert "judge_noise_linear_generic" in source_line(*found[-1][1:])


def test_a_number_leads_to_the_function_that_gives_it():
    found = words("t2_2_persp_rms_set1")
    (given,) = [n for n in found if n[0] == "numbers"]
    assert "def values_of_table_2_2(" in source_line(*given[1:])
    assert [n for n in found if n[0] == "trial"]


def test_a_page_and_an_experiment_have_a_place():
    page = "ch03_planar_grids/s3_2_grid_sets"
    whole = words(page)
    assert whole[0] == ("page", f"chapters/{page}/page.py", 1)
    assert whole == words("s3_2_grid_sets")
    one = dict.fromkeys(word for word, _, _ in words("table_3_4_grids"))
    assert [w for w in one if w != "data"] == [
        "page",
        "trial",
        "experiment",
        "algorithm",
    ]


def test_every_experiment_has_a_trial():
    made = [p for p in MADE if p.kind == "experiment"]
    lost = [p.id for p in made if ATLAS.trial_of(p) is None]
    assert not lost


def test_everything_of_the_thesis_that_is_made_has_a_page_and_lines_that_exist():
    book = load(ROOT)
    made = {p.id for p in MADE}
    pages = {page_id(ROOT, path) for path in page_files(ROOT)}
    asked = [i for i in (*book.artefacts, *book.claims) if i in made]
    asked += [i for i, entry in book.numbers.items() if entry["artefact"] in made]
    assert len(asked) > 100
    lengths = {}
    for identifier in asked:
        found = words(identifier)
        assert found[0][0] == "page", identifier
        assert found[0][1].removeprefix("chapters/").removesuffix("/page.py") in pages
        for _, path, number in found:
            if path not in lengths:
                text = (ROOT / path).read_bytes()
                lengths[path] = text.count(b"\n") + 1
            assert 1 <= number <= lengths[path], (identifier, path, number)


def test_what_is_found_by_its_id_is_what_a_build_makes():
    for one in MADE:
        assert one in ATLAS.marked.of_id(one.id)
    for page in ATLAS.marked.pages:
        assert ATLAS.marked.of_page(page) == [p for p in MADE if p.page == page]


def test_every_id_leads_to_the_algorithm():
    numbers = load(ROOT).numbers
    made = {p.id for p in MADE}
    asked = {p.id for p in MADE} | {
        i for i, e in numbers.items() if e["artefact"] in made
    }
    lost = {i for i in asked if "algorithm" not in [word for word, _, _ in words(i)]}
    assert lost == set(BOOK_KEEPING)


def test_every_quoted_name_is_made_by_one_statement_and_leads_on():
    quoted = [(p, name) for p in ATLAS.marked.pages for name in ATLAS.quotes(p)]
    assert len(quoted) > 700
    made = {asked: ATLAS.makers(*asked) for asked in quoted}
    assert not {asked for asked, makers in made.items() if len(makers) != 1}
    lost, constants = [], 0
    for page, name in quoted:
        lines = ATLAS.lines(f"{page.rpartition('/')[2]}:{name}")
        kinds = [line.word for line in lines]
        # A number of the thesis is led on by its own lines, see above.
        if not {"algorithm", "constant", "function"} & set(kinds):
            lost.append((page, name))
        constants += "algorithm" not in kinds
    assert not lost
    assert constants < len(quoted) / 15


def test_the_first_lines_of_the_library_are_the_algorithm():
    def first(identifier):
        named = [n.name for n in ATLAS.lines(identifier) if n.word == "algorithm"]
        return named[:3]

    assert "celect" in first("table_3_4")
    assert "calibrate_zhang" in first("c2_noise_linear_generic")
    assert "linear_cgsp" in first("s3_2_results:omni.left_out")
    assert "rays_from_known_motion" in first("fig_2_2_error")


def test_what_is_listed_of_the_library_is_in_the_key_of_the_trial():
    reach = Reach(ROOT)
    for one in MADE:
        if one.id not in ("fig_2_3_noise", "table_3_4_grids", "table_4_3_rendered"):
            continue
        module = f"chapters.{one.path[:-3].replace('/', '.')}"
        reached = {reach.place(*p) for p in reach.reached((module, one.function))}
        listed = [n.place for n in ATLAS.lines(one.id) if n.word == "algorithm"]
        assert len(listed) > 3
        for place in listed:
            path, _, line = place.rpartition(":")
            assert (ROOT / path, int(line)) in reached


def test_only_files_that_an_id_concerns_are_parsed(monkeypatch):
    parsed = []
    parse = ast.parse

    def counted(source, filename="<unknown>", *given, **named):
        parsed.append(str(filename).removeprefix(f"{ROOT}/"))
        return parse(source, filename, *given, **named)

    # What an earlier test has parsed is kept for files of the same text.
    parsed_file.cache_clear()
    monkeypatch.setattr(ast, "parse", counted)
    where.Whereabouts(ROOT).lines("s3_2_results:omni.left_out")
    chapters = {path for path in parsed if path.startswith("chapters/")}
    packages = {"/".join(path.split("/")[1:3]) for path in chapters}
    pages = {p for p in packages if p in ATLAS.marked.pages}
    # The other page needs the decoding errors that are measured for this one.
    assert pages == {
        "ch04_central_generic/s3_2_results",
        "ch04_central_generic/s3_3_correction",
    }
    assert len(set(parsed)) < 60
    # The page is read twice: as it stands, and with its display lines.
    assert len(parsed) <= len(set(parsed)) + 1


def test_neither_arrays_nor_chapters_are_imported_to_look_something_up():
    code = "import sys, repro.run.where; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    loaded = {name.partition(".")[0] for name in done.stdout.split()}
    assert not loaded & {"numpy", "scipy", "cv2", "chapters", "snakemake", "matplotlib"}


def test_what_nothing_has_is_told_with_what_is_near(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    assert where.main(["table_3_44"]) == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("make where: table_3_44: no such id; did you mean ")
    assert "table_3_4" in said.err
    assert said.err.count("\n") == 1
    assert where.main([]) == 1


def test_words_and_places_stand_below_each_other(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    assert where.main(["table_3_4"]) == 0
    rows = capsys.readouterr().out.splitlines()
    assert len({row.index("chapters/") for row in rows if "chapters/" in row}) == 1


def test_the_listings_in_contributing_are_what_is_printed():
    text = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
    listings = text.split("$ make where ")[1:]
    assert len(listings) > 1
    for listing in listings:
        identifier, *rows = listing.partition("...")[0].split("\n")
        printed = [
            [line.word, line.place.rpartition(":")[0], *line.name.split()]
            for line in ATLAS.lines(identifier)
        ]
        # Lines move; what is said of them does not.
        listed = [re.sub(r":\d+ ", " ", row).split() for row in rows if row]
        assert listed == printed[: len(listed)]
