"""The numbers that the page of the mirror benchmark quotes: the scorer's own rules."""

from raxel.evaluation import mirror_benchmark

# px, pixels, degrees, mm, mm, and percent of the way to a load.
STEP = mirror_benchmark.STEP_PX
FEWEST = mirror_benchmark.FEWEST_RAYS
RIGHT = mirror_benchmark.RIGHT_DEG
CELL = mirror_benchmark.CELL_MM
NEAR = mirror_benchmark.NEAR_MM
READ_AT = 100 * mirror_benchmark.READ_AT
