"""The command line.  It starts fast, because each command imports what it needs when it is called."""

import sys
from typing import NoReturn


def main() -> NoReturn:
    """Run a command.  Ctrl-C while its modules are still imported ends it without a traceback, as later."""
    try:
        from fieldrig.cli.outcome import run
    except KeyboardInterrupt:
        sys.exit(130)  # as shells say it: 128 + SIGINT
    run()
