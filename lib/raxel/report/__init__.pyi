from .mirror import write_mirror_report as write_mirror_report
from .page import check_report as check_report
from .page import new_report as new_report
from .write import write_report as write_report
