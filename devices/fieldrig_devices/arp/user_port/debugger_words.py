"""The words of the debugger, and what may stand behind them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Help:
    words: tuple[str, ...]
    arguments: str
    about: str


COMMANDS: Final = (
    Help(("run", "r"), "[SECONDS]", "run from the first instruction, until it stops somewhere"),
    Help(("continue", "c"), "[SECONDS]", "go on, until it stops somewhere"),
    Help(("step", "s"), "[N]", "go to the next line, into subprograms"),
    Help(("next", "n"), "[N]", "go to the next line, over subprograms"),
    Help(("pause",), "", "stop where it is"),
    Help(("break", "b"), "[LINE|ROUTINE]...", "stop in front of these lines too; without one: list them"),
    Help(("delete", "d"), "[LINE|ROUTINE]...", "take breakpoints away; without one: all"),
    Help(("list", "l"), "[LINE|ROUTINE]", "show the program, there or where it stands"),
    Help(("where", "w"), "", "show where it stands, and who called"),
    Help(("print", "p"), "NAME...", "show values: V1, F3, POS1, or a name that the source gives by EQU"),
    Help(("set",), "NAME=VALUE...", "write variables, flags, outputs, parameters in RAM"),
    Help(("state",), "", "show the card's state, error and warning"),
    Help(("stop",), "", "stop the program; outputs and axes stay"),
    Help(("reset",), "", "Ctrl-F2: outputs and axes off, errors cleared, program held"),
    Help(("help", "h"), "", "this"),
    Help(("quit", "q"), "", "leave; breakpoints are taken away, and a paused program goes on"),
    Help(("leave",), "", "leave; breakpoints and a pause stay as they are"),
)
HINT: Final = """\
To begin: `break 12` or `break ROUTINE`, then `run`. When it stands: `step`, `next`, `print V1`, `continue`.
A breakpoint stops in front of its line. Axes and outputs go on while a program stands: that is no emergency stop."""


def command(word: str) -> str:
    """By its whole name, its short one, or its beginning.  ValueError, with what would be right, if there is none."""
    word = word.lower()
    for one in COMMANDS:
        if word in one.words:
            return one.words[0]
    found = [one.words[0] for one in COMMANDS if one.words[0].startswith(word)]
    if len(found) != 1:
        close = f"{word!r} may be {' or '.join(found)}" if found else f"{word!r} is no command"
        raise ValueError(f"{close}\n`help` lists them")
    return found[0]


def count(arguments: Sequence[str]) -> int:
    """1 without one.  ValueError, with what would be right, for what is no count."""
    if not arguments:
        return 1
    if len(arguments) == 1 and arguments[0].isdecimal() and 1 <= int(arguments[0]) <= 1_000:
        return int(arguments[0])
    raise ValueError(f"{' '.join(arguments)!r} is no count\n1 to 1000 is right")


def none(arguments: Sequence[str]) -> None:
    if arguments:
        raise ValueError(
            f"nothing comes after this command, but there is {' '.join(arguments)!r}\n`help` explains them"
        )
