"""The command line.  It starts fast, because each command imports what it needs when it is called."""

import sys
from typing import NoReturn

from fieldrig.cli.app import app
from fieldrig.errors import ConfigError, ControlError, RefusedError, RigError, UsageError
from fieldrig.exits import Exit


def main() -> NoReturn:
    """Run a command.

    A fault that a user can fix ends in two lines and an exit code; only our own faults have a traceback.
    """
    try:
        app()
    except ConfigError as wrong:
        _say(f"{len(wrong.mistakes)} {'mistake' if len(wrong.mistakes) == 1 else 'mistakes'}", str(wrong))
        sys.exit(Exit.WRONG)
    except RigError as cause:
        _say(f"error: {cause.what}", cause.remedy)
        sys.exit(_code(cause))
    except KeyboardInterrupt:
        sys.exit(130)  # as shells say it: 128 + SIGINT
    sys.exit(Exit.OK)


def _code(cause: RigError) -> Exit:
    if isinstance(cause, UsageError):
        return Exit.WRONG
    if isinstance(cause, RefusedError):
        return Exit.REFUSED
    if not isinstance(cause, ControlError):
        return Exit.CANNOT_START
    # Only what talks to Zenoh can raise it, so this import costs nothing more.
    from fieldrig.endpoint import NoRigError

    return Exit.NO_RIG if isinstance(cause, NoRigError) else Exit.REFUSED


def _say(what: str, remedy: str) -> None:
    print(f"{what}\n{_indented(remedy)}" if remedy else what, file=sys.stderr)  # noqa: T201  this is a command line


def _indented(text: str) -> str:
    return "\n".join(f"  {line}" for line in text.splitlines())
