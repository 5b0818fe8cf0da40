"""`python -m bentlight_native`: the command `bentlight`."""

import sys

from .command import run_command

sys.exit(run_command())
