"""A mutant: one expression of the code changed for a wrong one, and who must notice."""

from pathlib import Path
from typing import NamedTuple

from raxel.documents import read_yaml

ROOT = Path(__file__).resolve().parents[2]
LISTS = ("library.yaml", "calibration.yaml", "report.yaml")


class Mutant(NamedTuple):
    """name: short, of its own; file: below the checkout; old: text that stands there
    exactly once; new: what it becomes; tests: pytest ids, at least one of which must
    fail; why: the harm that it would do.
    """

    name: str
    file: str
    old: str
    new: str
    tests: tuple
    why: str

    def stale(self, root):
        """Why it cannot be made in a checkout, one line; '' where it can."""
        path = Path(root) / self.file
        if not path.is_file():
            return f"{self.file}: no such file"
        count = path.read_text("utf-8").count(self.old)
        if count != 1:
            return f"{self.file}: holds its old text {count} times, not once"
        for test in self.tests:
            file, *inner = test.split("::")
            path = Path(root) / file
            if not path.is_file():
                return f"{file}: no such file"
            if inner and f"def {inner[-1].partition('[')[0]}(" not in path.read_text(
                "utf-8"
            ):
                return f"{test}: no such test"
        return ""

    def mutated(self, root):
        """The text of its file with the fault in it."""
        return (Path(root) / self.file).read_text("utf-8").replace(self.old, self.new)


def load_mutants():
    """The Mutants of the lists beside this module, in their order."""
    paths = [Path(__file__).with_name(name) for name in LISTS]
    return [
        Mutant(**entry | {"tests": tuple(entry["tests"])})
        for path in paths
        for entry in read_yaml(path)
    ]
