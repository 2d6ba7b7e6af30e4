"""Times of the commands, from the README."""

import re

from repro.page.reader import checkout

ROW = re.compile(r"^\| `make (\w+)` \| (\d+ (?:min|s)) \|$", re.MULTILINE)


def stated_times():
    """Return command -> its time as text, from the table of the README."""
    return dict(ROW.findall((checkout() / "README.md").read_text("utf-8")))
