"""The commands of the debugger and their arguments."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Help:
    words: tuple[str, ...]
    arguments: str
    about: str


COMMANDS: Final = (
    Help(("run", "r"), "[SECONDS]", "run from the first instruction, and wait until it stops"),
    Help(("continue", "c"), "[SECONDS]", "continue, and wait until it stops"),
    Help(("step", "s"), "[N]", "go to the next line, into subprograms"),
    Help(("next", "n"), "[N]", "go to the next line, over subprograms"),
    Help(("pause",), "", "pause the program"),
    Help(("break", "b"), "[LINE|ROUTINE]...", "stop before these lines too; without arguments, list the breakpoints"),
    Help(("delete", "d"), "[LINE|ROUTINE]...", "remove breakpoints; without arguments, all of them"),
    Help(("list", "l"), "[LINE|ROUTINE]", "show the program around a line or around the next instruction"),
    Help(("where", "w"), "", "show the next instruction and its callers"),
    Help(("print", "p"), "NAME...", "show values: V1, F3, POS1, or a name defined by EQU"),
    Help(("set",), "NAME=VALUE...", "write variables, flags, outputs, parameters in RAM"),
    Help(("state",), "", "show the card's state, error and warning"),
    Help(("stop",), "", "stop the program; outputs and axes keep their state"),
    Help(("reset",), "", "Ctrl-F2: outputs and axes off, errors cleared, program held"),
    Help(("help", "h"), "", "show this list"),
    Help(("quit", "q"), "", "leave; remove breakpoints, and continue a paused program"),
    Help(("leave",), "", "leave; keep breakpoints and a pause"),
)
HINT: Final = """\
To begin, enter `break 12` or `break ROUTINE`, then `run`. After a stop: `step`, `next`, `print V1`, `continue`.
A breakpoint stops before its line. It is no emergency stop: axes and outputs stay active while a program is paused."""


def command(word: str) -> str:
    """Find a command by its full name, its short name or its beginning.  Raises ValueError for an unknown command."""
    word = word.lower()
    for entry in COMMANDS:
        if word in entry.words:
            return entry.words[0]
    found = [entry.words[0] for entry in COMMANDS if entry.words[0].startswith(word)]
    if len(found) != 1:
        close = f"{word!r} is ambiguous: {' or '.join(found)}" if found else f"{word!r} is not a command"
        raise ValueError(f"{close}\n`help` lists the commands")
    return found[0]


def count(arguments: Sequence[str]) -> int:
    """The count in the arguments, or 1 if there are none.  Raises ValueError for an invalid count."""
    if not arguments:
        return 1
    if len(arguments) == 1 and arguments[0].isdecimal() and 1 <= int(arguments[0]) <= 1_000:
        return int(arguments[0])
    raise ValueError(f"{' '.join(arguments)!r} is not a count\nexpected 1 to 1000")


def none(arguments: Sequence[str]) -> None:
    if arguments:
        raise ValueError(f"unexpected {' '.join(arguments)!r} after this command\n`help` lists the commands")
