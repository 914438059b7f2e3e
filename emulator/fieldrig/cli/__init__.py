"""The command line.  It starts fast, because each command imports what it needs when it is called."""

import gc
import sys
from typing import Final, NoReturn

SEARCHES: Final = 200_000, 10, 10
"""Thresholds of Python's search for circles: new objects until it looks, and looks until it looks further.

Modules stay, and with Python's own thresholds the searches took a quarter of the time of a command that compiles a
program, and a sixth of the others.  A process that runs devices sets its own.
"""


def main() -> NoReturn:
    """Run a command.  Ctrl-C while its modules are still imported ends it without a traceback, as later."""
    gc.set_threshold(*SEARCHES)
    try:
        from fieldrig.cli.outcome import run
    except KeyboardInterrupt:
        sys.exit(130)  # as shells say it: 128 + SIGINT
    run()
