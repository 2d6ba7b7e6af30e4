"""No test is timed: how long an example takes says how busy the machine is.

Files that build come first, and then those of most tests, so that no process is left
alone with a long file at the end (with `--no-loadscope-reorder`).
"""

from collections import Counter

from hypothesis import HealthCheck, settings

settings.register_profile(
    "untimed", deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("untimed")

BUILDING = (
    "test_report.py",
    "test_workflow.py",
    "test_workflow_sets.py",
    "test_site.py",
)


def pytest_collection_modifyitems(items):
    """Order the files, each with its tests as they stand in it."""
    tests = Counter(item.path for item in items)
    names = dict.fromkeys([*BUILDING, *(path.name for path, _ in tests.most_common())])
    place = {name: number for number, name in enumerate(names)}
    items.sort(key=lambda item: place[item.path.name])
