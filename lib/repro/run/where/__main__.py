"""`python -m repro.run.where ID`."""

import sys

from repro.run.where import main

sys.exit(main())
