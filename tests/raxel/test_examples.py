"""Examples in docstrings run, and thirty functions that users meet first have one."""

import doctest
import importlib

from tests.raxel.test_public_names import FACES

MIN_EXAMPLES = 30


def test_docstring_examples_run():
    finder = doctest.DocTestFinder(recurse=False)
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    count = 0
    for face in FACES:
        module = importlib.import_module(face)
        for name in module.__all__:
            tests = finder.find(getattr(module, name), name, globs={})
            tests = [test for test in tests if test.examples]
            count += len(tests)
            for test in tests:
                assert runner.run(test).failed == 0, name
    assert count >= MIN_EXAMPLES
