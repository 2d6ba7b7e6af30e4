"""What the README says about the time that the commands take."""

import re

from repro.page.reader import checkout

ROW = re.compile(r"^\| `make (\w+)` \| (\d+ (?:min|s)) \|$", re.MULTILINE)


def stated_times():
    """Command -> its time in words, as the table of the README has it."""
    return dict(ROW.findall((checkout() / "README.md").read_text("utf-8")))
