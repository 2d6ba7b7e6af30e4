"""The ledger: contents, and one line for each fault."""

import pytest
import yaml

from repro.judge import ledger
from repro.judge.ledger import LedgerError
from repro.judge.number_rules import judge_number
from repro.run.outcomes import Value
from tests.small_checkouts import ROOT

PUBLISHED = ROOT / ledger.FOLDER


@pytest.fixture(scope="module")
def real():
    return ledger.load(ROOT)


def test_ledger_lists_all_entries(real):
    counts = {name: len(getattr(real, name)) for name in vars(real)}
    # The open questions are ours: their number grows with the chapters.
    del counts["readings"]
    assert counts == {
        "artefacts": 88,
        "numbers": 512,
        "claims": 233,
        "settings": 55,
        "sections": 25,
    }


@pytest.mark.parametrize(
    ("identifier", "chapter"),
    [
        ("fig_2_3", 2),
        ("app_a", "A"),
        ("s2_5_1_res", 2),
        ("app_a_even", "A"),
        ("c6_detect_8px", 6),
        ("c3_even_cancels", "A"),
        ("sec_5_3_3", 5),
    ],
)
def test_ids_have_chapter_of_section(real, identifier, chapter):
    assert real.chapter(identifier) == chapter


def test_unknown_id_is_reported_with_suggestion(real):
    with pytest.raises(
        LedgerError, match=r"fig_2_33: no such id; did you mean fig_2_3"
    ):
        real.entry("fig_2_33")
    with pytest.raises(LedgerError, match="have no chapter"):
        real.chapter("syn_ch2")


def test_claims_and_numbers_of_artefact_are_found(real):
    assert "c2_crossover" in real.claims_of("fig_2_3")
    assert "c2_crossover" in real.claims_of("table_2_2")
    assert real.numbers_of("sec_2_4_1") == ["s2_4_1_rankA", "s2_4_1_rankD"]


@pytest.mark.parametrize(
    ("identifier", "found", "verdict"),
    [
        ("s3_3_1_loc_init", 3, "differs"),  # corners up to 8 px off converge
        ("s3_3_1_loc_init", 9, "reproduced"),
        ("s3_3_1_pitch_ok", 66, "differs"),  # squares of 50 px succeed
        ("s3_3_1_pitch_ok", 40, "reproduced"),
        ("s3_3_1_intercorner", 22, "differs"),  # distances as small as 12 px
        ("s3_3_1_intercorner", 11, "reproduced"),
        ("s3_3_1_yaw_fail", 40, "differs"),  # beyond 48 deg it fails
        ("s3_3_1_yaw_fail", 60, "differs"),
        ("s3_3_1_maxerr", 6, "reproduced"),  # less than 6.5 px
        ("s3_3_1_loc_max", 0.5, "differs"),  # less than 0.46 px
        ("fig5_5_depth_thr", 2000, "reproduced"),  # independent beyond 3000 mm
        ("fig5_5_depth_thr", 4000, "differs"),
        ("s2_4_2_solutions", 4, "differs"),  # the eight possible solutions
    ],
)
def test_bounds_match_their_quotes(real, identifier, found, verdict):
    entry = real.numbers[identifier]
    made = Value(found, (found, found), entry["unit"])
    assert judge_number(entry, vars(made))[0] == verdict


@pytest.fixture(scope="module")
def contents():
    """The four files with a few entries each, enough to load."""
    files = {
        stem: ledger.read_yaml(PUBLISHED / f"{stem}.yaml") for stem in ledger.LISTS
    }
    kept = {
        "artefacts": {"fig_2_3", "table_2_1", "sec_2_4_1", "sec_2_6"},
        "numbers": {"s2_5_1_res", "s2_4_1_rankA"},
        "claims": {"c2_noise_linear_generic", "c2_table_coefficients"},
        "settings": {"syn_ch2", "noise", "scoring"},
    }
    small = {
        stem: {
            name: [e for e in items if e["id"] in kept[stem]]
            for name, items in content.items()
            if isinstance(items, list)
        }
        for stem, content in files.items()
    }
    for entry in small["settings"]["settings"] + small["settings"]["readings"]:
        entry["used_by"] = ["fig_2_3"]
        entry.pop("settled", None)
    return yaml.safe_dump(small)


@pytest.fixture
def written(tmp_path, contents):
    """Write the small ledger after a change to it; return the checkout."""

    def write(change=lambda files: None):
        files = yaml.safe_load(contents)
        change(files)
        folder = tmp_path / ledger.FOLDER
        folder.mkdir(parents=True, exist_ok=True)
        for stem, content in files.items():
            (folder / f"{stem}.yaml").write_text(yaml.safe_dump(content))
        return tmp_path

    return write


def test_sections_require_number_or_claim(written):
    assert list(ledger.load(written()).sections) == ["sec_2_4_1"]


def first(files, stem, name=None):
    return files[stem][name or stem][0]


MUTATIONS = {
    "missing field": (
        lambda f: first(f, "numbers").pop("unit"),
        "numbers.yaml: numbers.s2_5_1_res.unit: key missing; add it",
    ),
    "misspelt field": (
        lambda f: first(f, "claims").update(sources="real"),
        "claims.yaml: claims.c2_noise_linear_generic.sources: unknown key; did you "
        "mean source?",
    ),
    "strange field": (
        lambda f: first(f, "claims").update(zzz=1),
        "claims.yaml: claims.c2_noise_linear_generic.zzz: unknown key; known are id, ",
    ),
    "unknown comparator": (
        lambda f: first(f, "numbers").update(comparator="=="),
        "numbers.yaml: numbers.s2_5_1_res.comparator: found '=='; give enum ['eq', "
        "'approx', ",
    ),
    "wrong type": (
        lambda f: first(f, "numbers").update(value=[1]),
        "numbers.yaml: numbers.s2_5_1_res.value: found a list of 1; give type "
        "['number', 'string', ",
    ),
    "one line number": (
        lambda f: first(f, "artefacts").update(thesis_lines=[3]),
        "artefacts.yaml: artefacts.table_2_1.thesis_lines: found a list of 1; give "
        "minItems 2",
    ),
    "no reason for a choice": (
        lambda f: first(f, "settings")["chosen"]["grids"].pop("reason"),
        "settings.yaml: settings.syn_ch2.chosen.grids.reason: key missing; add it",
    ),
    "one option": (
        lambda f: first(f, "settings", "readings").update(options=["px"]),
        "settings.yaml: readings.noise.options: found a list of 1; give minItems 2",
    ),
    "primary is no option": (
        lambda f: first(f, "settings", "readings").update(primary="cm"),
        "settings.yaml: noise: primary: found 'cm'; give one of its options, px, mm",
    ),
    "not crossed with what is no question": (
        lambda f: first(f, "settings", "readings").update(not_crossed_with=["nois"]),
        "settings.yaml: noise: not_crossed_with: found 'nois', no question of the "
        "readings; did you mean noise?",
    ),
    "id twice in a file": (
        lambda f: f["numbers"]["numbers"].append(dict(first(f, "numbers"))),
        "numbers.yaml: s2_5_1_res: id: already used in numbers.yaml; rename one of "
        "the two",
    ),
    "id twice in two files": (
        lambda f: first(f, "claims").update(id="fig_2_3"),
        "claims.yaml: fig_2_3: id: already used in artefacts.yaml; rename one of the "
        "two",
    ),
    "unknown artefact": (
        lambda f: first(f, "numbers").update(artefact="fig_2_4"),
        "numbers.yaml: s2_5_1_res: artefact: found 'fig_2_4', no artefact or section "
        "of artefacts.yaml; did you mean fig_2_3?",
    ),
    "unknown section": (
        lambda f: first(f, "claims").update(artefacts=["sec_6_1"]),
        "claims.yaml: c2_noise_linear_generic: artefacts: found 'sec_6_1', no artefact "
        "or section of artefacts.yaml",
    ),
    "empty": (
        lambda f: f["claims"].clear(),
        "claims.yaml: claims: key missing; add it",
    ),
}


@pytest.mark.parametrize("name", MUTATIONS)
def test_ledger_fault_is_one_line(written, name):
    change, line = MUTATIONS[name]
    with pytest.raises(LedgerError) as error:
        ledger.load(written(change))
    assert str(error.value).startswith(line)
    assert "\n" not in str(error.value)


def test_several_faults_are_counted(written):
    def change(files):
        first(files, "numbers").update(comparator="==", role="answer")

    with pytest.raises(LedgerError, match=r"\(and 1 more\)$"):
        ledger.load(written(change))


def test_broken_yaml_and_missing_file_are_one_line(written):
    folder = written() / ledger.FOLDER
    twice = "^claims.yaml: line 3: key 'claims' is repeated, first in line 1; corr"
    for text, fault in (
        ("claims: [\n", r"^claims.yaml: line 2: .*correct the YAML$"),
        ("claims: []\nother: 1\nclaims: []\n", twice),
    ):
        (folder / "claims.yaml").write_text(text)
        with pytest.raises(LedgerError, match=fault):
            ledger.load(folder.parents[1])
    (folder / "claims.yaml").unlink()
    with pytest.raises(LedgerError, match=r"claims.yaml: not found; restore it"):
        ledger.load(folder.parents[1])
