"""`make times`: a table of the records that jobs leave."""

import pytest

from repro.run.discover import Producer
from repro.run.results import write_json
from repro.workflow import times


def test_times_sum_records_by_page(tmp_path, monkeypatch, capsys):
    made = [
        Producer("experiment", "sweep", "chapters.c.s.page", "f", "c/s", 1, {}),
        Producer("figure", "fig", "chapters.c.s.page", "g", "c/s", 9, {}),
    ]
    monkeypatch.setattr(times, "producers", lambda root: made)
    monkeypatch.chdir(tmp_path)
    assert times.main(["--effort", "quick"]) == 1
    folder = tmp_path / "figures/quick/times"
    for path, seconds, more in (
        (folder / "experiment/sweep/0-of-2.json", 1.0, {"peak_mb": 300.0}),
        (folder / "experiment/sweep/1-of-2.json", 2.0, {"peak_mb": 500.0}),
        (folder / "experiment/sweep/2-of-3.json", 4.0, {}),
        (folder / "figure/fig.json", 8.0, {}),
        (folder / "figure/gone.json", 1000.0, {}),
        (folder / "page/c/s.json", 16.0, {"peak_mb": 200.0}),
        (folder / "site/sphinx.json", 32.0, {}),
        (tmp_path / times.SET_TIMES / "rig/0.json", 64.0, {}),
    ):
        write_json(path, {"processor_seconds": seconds} | more)
    rows = {row[0]: row[1:] for row in times.rows_of(tmp_path, "quick")}
    assert rows == {
        "c/s": pytest.approx((7.0, 8.0, 16.0, 31.0, 500.0)),
        "image sets": pytest.approx((64.0, 0, 0, 64.0, 0)),
        "site": pytest.approx((0, 0, 32.0, 32.0, 0)),
    }
    assert times.main(["--effort", "quick"]) == 0
    last = capsys.readouterr().out.splitlines()[-1].split()
    assert last == ["all", "71.0", "8.0", "48.0", "127.0", "500.0"]
