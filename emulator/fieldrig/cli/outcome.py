"""Runs a command, and turns what it raises into messages and an exit code."""

import gc
import sys
from collections.abc import Callable
from errno import EMFILE, ENFILE
from typing import Final, NoReturn, TextIO, cast

from fieldrig.cli.app import app
from fieldrig.errors import ConfigError, ControlError, RefusedError, RigError, UsageError
from fieldrig.points.values import counted
from fieldrig.system.exits import Exit
from fieldrig.system.steady_output import open_missing, steady, strict

INTERRUPTED: Final = 130
"""The exit code of Ctrl-C, as shells report it: 128 + SIGINT."""
READER_GONE: Final = 141
"""The exit code of a program such as `cat` whose reader has gone, as shells report it: 128 + SIGPIPE."""


def run() -> NoReturn:
    """Run a command.

    A fault that a user can fix ends in two lines and an exit code; only our own faults have a traceback.
    """
    open_missing()
    if sys.stdout is sys.__stdout__:  # not where a test has put another one
        sys.stdout = strict(cast(TextIO, sys.stdout))
        sys.stderr = steady(cast(TextIO, sys.stderr))  # what cannot be said there can be said nowhere
    code = _run(app)
    code = _run(sys.stdout.flush) or code
    gc.freeze()  # the last search of Python for circles took a fifth of the time of a short command
    sys.exit(code)


def _run(work: Callable[[], object]) -> int:
    """Return the exit code of a command."""
    try:
        work()
    except SystemExit as end:
        if isinstance(end.__context__, BrokenPipeError):  # typer ends so
            return READER_GONE
        return end.code if isinstance(end.code, int) else Exit.OK if end.code is None else Exit.BUG
    except ConfigError as wrong:
        _say(counted(len(wrong.mistakes), "mistake"), str(wrong))
        return Exit.WRONG
    except RigError as cause:
        _say(f"error: {cause.what}", cause.remedy)
        return _code(cause)
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        return READER_GONE
    except OSError as cause:
        if cause.errno not in (EMFILE, ENFILE):
            raise
        _say(f"error: {cause.strerror}", "`ulimit -n` shows how many this command may have, and sets it")
        return Exit.CANNOT_START
    return Exit.OK


def _code(cause: RigError) -> Exit:
    if isinstance(cause, UsageError):
        return Exit.WRONG
    if isinstance(cause, RefusedError):
        return Exit.REFUSED
    if not isinstance(cause, ControlError):
        return Exit.CANNOT_START
    # Only what talks to Zenoh can raise it, so this import costs nothing more.
    from fieldrig.control.endpoint import NoRigError

    return Exit.NO_RIG if isinstance(cause, NoRigError) else Exit.REFUSED


def _say(what: str, remedy: str) -> None:
    print(f"{what}\n{_indented(remedy)}" if remedy else what, file=sys.stderr)  # noqa: T201  this is a command line


def _indented(text: str) -> str:
    return "\n".join(f"  {line}" for line in text.splitlines())
