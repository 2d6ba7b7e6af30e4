"""The files of the three rigs of chapter 5, for experiments to name as their inputs.

The same files as in `mirror_rigs`, as literals: the marks of experiments are read
without being run.
"""

GEOMETRY_A = (
    "data/rigs/flexible-mirror-a.yaml",
    "data/rigs/flexible-mirror-a-monitor.yaml",
)
GEOMETRY_B = (
    "data/rigs/flexible-mirror-b.yaml",
    "data/rigs/flexible-mirror-b-monitor.yaml",
)
BOTH = (
    "data/rigs/flexible-mirror-a.yaml",
    "data/rigs/flexible-mirror-a-monitor.yaml",
    "data/rigs/flexible-mirror-b.yaml",
    "data/rigs/flexible-mirror-b-monitor.yaml",
)
ALL_THREE = (
    "data/rigs/flexible-mirror-a.yaml",
    "data/rigs/flexible-mirror-a-monitor.yaml",
    "data/rigs/flexible-mirror-b.yaml",
    "data/rigs/flexible-mirror-b-monitor.yaml",
    "data/rigs/flexible-mirror-c.yaml",
    "data/rigs/flexible-mirror-c-monitor.yaml",
)
GEOMETRY_C = (
    "data/rigs/flexible-mirror-c.yaml",
    "data/rigs/flexible-mirror-c-monitor.yaml",
)
SMALL_A = (
    "data/rigs/flexible-mirror-a-small.yaml",
    "data/rigs/flexible-mirror-a-monitor-small.yaml",
)
