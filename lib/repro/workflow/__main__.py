"""`python -m repro.workflow TARGET`: a build that may be interrupted at any time."""

import gc
import os
import signal
import sys

# The imports below take a second; Ctrl-C during them shows no traceback.
signal.signal(signal.SIGINT, lambda number, frame: os._exit(128 + number))

from repro.workflow.build import main  # noqa: E402

# A plan has several hundred thousand permanent objects: no garbage collection while
# they are made.
gc.set_threshold(100_000, 50, 50)
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.exit(main())
