"""The commands of the debugger at the USER port."""

from typing import Final

from fieldrig_devices.languages.debugging.words import Help, Words

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
WORDS: Final = Words(COMMANDS, HINT)
