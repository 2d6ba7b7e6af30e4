"""The report of a calibration: corners, residuals and coverage as pictures, a page."""

from raxel.report.mirror import write_mirror_report
from raxel.report.page import check_report, new_report
from raxel.report.write import write_report

__all__ = ["check_report", "new_report", "write_mirror_report", "write_report"]
