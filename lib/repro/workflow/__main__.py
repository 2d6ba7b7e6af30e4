"""`python -m repro.workflow TARGET`: a build that may be interrupted at any time."""

import gc
import os
import signal
import sys

# The imports below take a second, and their traceback is nobody's news.
signal.signal(signal.SIGINT, lambda number, frame: os._exit(128 + number))

from repro.workflow.build import main  # noqa: E402

# A plan is a few hundred thousand objects that stay: not to be looked through again and
# again while they come.
gc.set_threshold(100_000, 50, 50)
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.exit(main())
