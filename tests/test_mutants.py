"""`make mutants`: its list fits the code, and its runner tells who is caught."""

import ast

import pytest

from tests.mutants import trial
from tests.mutants.__main__ import main
from tests.mutants.mutant import ROOT, Mutant, load_mutants

MUTANTS = load_mutants()
CODE = "def double(x):\n    return 2 * x\n"
TESTS = """from raxel.one import double

def test_double():
    assert double(3) == 6

def test_sign():
    assert double(3) > 0
"""
ONE = Mutant("one", "lib/raxel/one.py", "2 * x", "3 * x", ("tests/test_one.py",), "")


def test_the_code_still_holds_what_mutants_change():
    stale = [f"{m.name}: {why}" for m in MUTANTS if (why := m.stale(ROOT))]
    assert not stale, "give the text that stands there now:\n" + "\n".join(stale)
    for mutant in MUTANTS:
        assert mutant.old != mutant.new, mutant.name
        ast.parse(mutant.mutated(ROOT), mutant.name)


def test_mutants_have_names_of_their_own():
    assert len({mutant.name for mutant in MUTANTS}) == len(MUTANTS)


@pytest.fixture
def checkout(tmp_path):
    for name, text in {ONE.file: CODE, ONE.tests[0]: TESTS}.items():
        path = tmp_path / "checkout" / name
        path.parent.mkdir(parents=True)
        path.write_text(text)
    # A package, or an installed one of its name would be found before it.
    (tmp_path / "checkout/lib/raxel/__init__.py").touch()
    return tmp_path / "checkout"


def test_the_runner_tells_what_became_of_each(checkout, capsys, monkeypatch):
    def as_if_run(copy, tests, more=None):
        assert copy != checkout
        code = (copy / ONE.file).read_text()
        return 1 if "3 * x" in code else 2 if "2 *" not in code else 0, "said"

    monkeypatch.setattr(trial, "run_tests", as_if_run)
    others = [
        ONE._replace(name="two", new="2 * x + 0", why="nobody would know"),
        ONE._replace(name="three", old="5 * x", why="gone"),
        ONE._replace(name="four", new="x ***", why="no code"),
        ONE._replace(name="five", tests=("tests/test_one.py::test_none",), why="who"),
    ]
    assert main([], checkout, [ONE, *others], 2) == 1
    assert capsys.readouterr().out.splitlines() == [
        "caught       one",
        "NOT CAUGHT   two: nobody would know",
        "stale        three: lib/raxel/one.py: holds its old text 0 times, not once",
        "broken       four: no code",
        "stale        five: tests/test_one.py::test_none: no such test",
        "1 of 5 mutants caught",
    ]
    assert main(["one"], checkout, [ONE, *others], 1) == 0
    assert main(["six"], checkout, [ONE], 1) == 1
    assert (checkout / ONE.file).read_text() == CODE


def test_named_tests_are_run_in_the_copy_and_not_for_ever(
    checkout, capsys, monkeypatch
):
    named = ONE._replace(tests=("tests/test_one.py::test_double",))
    assert main([], checkout, [named], 1) == 0
    assert capsys.readouterr().out == "caught       one\n1 of 1 mutants caught\n"
    assert (checkout / ONE.file).read_text() == CODE
    monkeypatch.setattr(trial, "LIMIT_S", 0.01)
    assert trial.run_tests(checkout, ONE.tests) == (None, "")


def test_code_compiled_this_very_second_is_not_run_for_the_faulty_one(
    checkout, tmp_path
):
    (tmp_path / "room").mkdir()
    copies = trial.Copies(checkout, tmp_path / "room", 1)
    copies.spread()
    second = int((tmp_path / "room/0" / ONE.file).stat().st_mtime)
    with copies.with_fault(ONE) as copy:
        assert int((copy / ONE.file).stat().st_mtime) > second + 1
    assert int((copy / ONE.file).stat().st_mtime) == second


def test_tests_that_fail_anyway_catch_nothing(checkout, capsys, monkeypatch):
    monkeypatch.setattr(trial, "run_tests", lambda *_: (1, "FAILED test_double"))
    assert main([], checkout, [ONE], 1) == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err == "the tests fail without any mutant:\nFAILED test_double\n"


def test_what_is_compiled_and_the_constants_in_it_are_known(tmp_path):
    texts = {
        "one": "import numba\nfrom raxel.two import STEP\n",
        "two": "from raxel.three import far\nSTEP = 2\n",
        "three": "def far():\n    return 'no numba here'\n",
    }
    (tmp_path / "lib" / "raxel").mkdir(parents=True)
    for name, text in texts.items():
        (tmp_path / "lib" / "raxel" / f"{name}.py").write_text(text)
    found = {"lib/raxel/one.py", "lib/raxel/two.py"}
    assert trial.compiled_files(tmp_path) == found
