"""What tests make up is a Result: what no plan has cannot be asked of it."""

import ast
from pathlib import Path

import numpy as np
import pytest

from chapters.ch02_general_camera_model.s2_camera_models.experiment import FOVS_DEG
from repro.run.results import Result
from tests.made_results import OfLaw, as_planned, of_columns, of_seed

EXPERIMENT = "exp_c2_fov180"
MADE = (
    as_planned(EXPERIMENT, {"feasible": [1, 0, np.nan]}),
    OfLaw(EXPERIMENT, lambda name, condition: [1, 0, np.nan], 3),
    of_columns(*(({"fov_deg": fov}, {"feasible": [1, 0, None]}) for fov in FOVS_DEG)),
)


@pytest.mark.parametrize("result", MADE)
def test_unknown_condition_is_rejected(result):
    assert isinstance(result, Result)
    found = result.column("feasible", fov_deg=FOVS_DEG[0])
    np.testing.assert_array_equal(found, [1, 0, np.nan])
    for wrong in ({"fov_deg": 7}, {"fov": FOVS_DEG[0]}, {}):
        with pytest.raises(KeyError, match="conditions fit"):
            result.column("feasible", **wrong)


def test_unknown_condition_key_is_rejected():
    only = of_columns(({"fov_deg": 90}, {"feasible": 1}))
    with pytest.raises(KeyError, match="0 conditions fit"):
        only.column("feasible", fov=90)


def test_law_is_evaluated_for_condition():
    result = OfLaw(EXPERIMENT, lambda name, condition: [condition["fov_deg"]], 1)
    assert [result.column("any", fov_deg=fov)[0] for fov in FOVS_DEG] == list(FOVS_DEG)


def test_constructed_results_match_build_results():
    result = of_seed(lambda c, rng: {"a": {"b": 1.5}, "drawn": rng.random(4)}, seed=3)
    assert result.column("a.b").tolist() == [1.5]
    (drawn,) = result.arrays("drawn")
    np.testing.assert_array_equal(drawn, np.random.default_rng(3).random(4))


def test_tests_use_made_results():
    """Tests use real results, which reject unknown conditions and keys."""
    reads = {"column", "texts", "arrays"}
    own = [
        f"{path.name}:{node.lineno}"
        for path in sorted(Path(__file__).parents[2].rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if reads & _made_up(node)
    ]
    assert not own, f"{', '.join(own)}: make a Result by tests.made_results"


def _made_up(node):
    """Methods of a class, keywords of a SimpleNamespace, attributes that are set."""
    if isinstance(node, ast.ClassDef):
        return {one.name for one in node.body if isinstance(one, ast.FunctionDef)}
    if isinstance(node, ast.Call) and ast.unparse(node.func).endswith("Namespace"):
        return {keyword.arg for keyword in node.keywords}
    if isinstance(node, ast.Assign):
        return {t.attr for t in node.targets if isinstance(t, ast.Attribute)}
    return set()
