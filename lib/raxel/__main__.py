"""`python -m raxel`"""

import sys

from raxel.cli import main

sys.exit(main())
