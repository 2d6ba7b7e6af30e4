"""What a figure or table says of itself can fail: checks of drawings and tables."""

import ast
from pathlib import Path

import pytest

from chapters.ch03_planar_grids.s3_2_grid_sets.report import corners_as_stated
from tests.made_results import as_planned

ROOT = Path(__file__).resolve().parents[3]


def decided_before(source):
    """Lines of checks that no result can change: what holds is a constant."""
    tree = ast.parse(source)
    calls = [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and ast.unparse(node.func).endswith("Check")
    ]
    return [call.lineno for call in calls if not _reads(_holds(call))]


def _holds(call):
    named = [one.value for one in call.keywords if one.arg == "holds"]
    return [*call.args, *named][0]


def _reads(expression):
    """Whether an expression reads a name that is no type: a constant does not."""
    names = {n.id for n in ast.walk(expression) if isinstance(n, ast.Name)}
    return bool(names - {"bool", "int", "float", "all", "any"})


@pytest.mark.parametrize(
    ("written", "found"),
    [
        ("Check(True, 'read')", [1]),
        ("outcomes.Check(bool(1), 'read')", [1]),
        ("Check(text='read', holds=not False)", [1]),
        ("Check(all([]), 'read')", [1]),
        ("Check(gap < 1e-9, 'read')", []),
        ("Check(\n    holds=bool(found), text='read'\n)", []),
    ],
)
def test_constant_is_not_a_check(written, found):
    assert decided_before(written) == found


def test_every_check_can_fail():
    wrong = [
        f"{path.relative_to(ROOT)}:{line}"
        for path in sorted((ROOT / "chapters").rglob("*.py"))
        for line in decided_before(path.read_text("utf-8"))
    ]
    assert not wrong, f"{', '.join(wrong)}: a check of a constant; check the drawn data"


def test_table_3_3_check_detects_another_grid():
    def shown(lost):
        def corners(condition):
            whole = 63 if condition["image"] < 7 else 108
            return {"corners": [whole - lost * (condition["image"] == 3)]}

        return corners_as_stated(as_planned("table_3_6_grids", corners))

    assert shown(0)
    assert all(shown(0))
    assert shown(1).count(False) == len(shown(1)) / 15
