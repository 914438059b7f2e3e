"""A debugger at a terminal and in scripts: it reads commands, prints errors, and chooses the exit code.

Commands from a file or a pipe are echoed, and the first one that fails ends the session.
"""

import sys
from collections.abc import Iterator
from contextlib import suppress
from typing import Final, Protocol

import typer

from fieldrig.system.exits import Exit
from fieldrig.system.this_process import exit_on_signals

SCRIPT_LIMIT_S: Final = 30.0
"""Time that a script waits for a program to stop, in seconds."""
ENDING: Final = ("SIGTERM", "SIGHUP")
"""Signals that end a session like the end of its input."""
REPEATED: Final = ("s", "step", "n", "next")
"""Commands that an empty line repeats, as in other debuggers."""


class NotStoppedError(Exception):
    """The program did not stop in the given time."""


EXPECTED: Final[tuple[type[Exception], ...]] = (ValueError, NotStoppedError)


class Commands(Protocol):
    """A debugger."""

    @property
    def is_over(self) -> bool: ...

    def do(self, line: str) -> None:
        """Execute one command.  ValueError, which says what was expected, for one that is wrong."""


def is_script() -> bool:
    return not sys.stdin.isatty()


def converse(debugger: Commands, prompt: str, refusals: tuple[type[Exception], ...]) -> None:
    """Execute commands until the user leaves; `refusals` are the errors with which a device refuses one.

    Every end but that by `leave` removes the breakpoints and lets a paused program continue.
    """
    as_script = is_script()
    exit_on_signals(ENDING)
    try:
        for line in _lines(prompt, as_script):
            if line:
                _do(debugger, line, refusals, as_script)
            if debugger.is_over:
                return
    finally:  # also after a command that failed, Ctrl-C, and a signal
        if not debugger.is_over:
            with suppress(*EXPECTED, *refusals):  # the reason of the end is what counts
                debugger.do("quit")


def _do(debugger: Commands, line: str, refusals: tuple[type[Exception], ...], as_script: bool) -> None:
    """Execute a command.  An error is printed; in a script, it ends the session."""
    try:
        debugger.do(line)
    except KeyboardInterrupt:
        if as_script:
            raise
        typer.echo()
    except (*EXPECTED, *refusals) as cause:
        what, _, remedy = str(cause).partition("\n")
        typer.echo(f"error: {what}", err=as_script)
        if remedy:
            typer.echo(f"  {remedy.strip()}", err=as_script)
        if as_script:
            raise typer.Exit(Exit.WRONG if isinstance(cause, ValueError) else Exit.REFUSED) from cause


def _lines(prompt: str, as_script: bool) -> Iterator[str]:
    if as_script:
        for line in sys.stdin:
            typer.echo(f"{prompt}{line.strip()}")
            yield line.strip()
        return
    with suppress(ImportError):
        import readline  # noqa: F401  adds a history to input()
    last = ""
    while True:
        try:
            line = input(prompt).strip()
        except EOFError:
            typer.echo()
            return
        except KeyboardInterrupt:
            typer.echo()
            continue
        yield line or (last if last.split(" ")[0] in REPEATED else "")
        last = line or last
