"""The numbers that the page quotes."""

from chapters.ch05_flexible_mirror.ext_orders.results.knots import KNOTS, Knots
from chapters.ch05_flexible_mirror.ext_orders.results.orders import ORDERS, quoted
from chapters.ch05_flexible_mirror.ext_orders.results.relief import RELIEF, ReliefRuns
from chapters.ch05_flexible_mirror.ext_orders.trials.knots import SHAPES
from chapters.ch05_flexible_mirror.ext_orders.trials.shapes import name_of
from chapters.shared.mirror_bench import ABERRATION_UM
from repro.page.reader import value


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {name: open_results(name) for name in (KNOTS, RELIEF, ORDERS)}
    for name, number in quoted(results).items():
        value(name, number)
    value("relief_um", ABERRATION_UM)
    knots, relief = Knots.of(results), ReliefRuns.of(results)
    for shape in SHAPES:
        value(f"{name_of(shape)}.step", knots.largest_step(shape))
        value(f"{name_of(shape)}.um", 1000 * knots.noise_free(shape).value)
    for name in ("back_mm", "residual_mm", "angle_deg"):
        value(f"removed.{name}", relief.removed(name).value)
        value(f"rise.{name}", relief.rise(name).value)
