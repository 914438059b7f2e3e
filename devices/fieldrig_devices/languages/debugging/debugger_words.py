"""The commands of `fieldrig debug`."""

from typing import Final

from fieldrig_devices.languages.debugging.words import Help, Words

WORDS: Final = Words(
    (
        Help(("run", "start"), "[SECONDS]", "start the program; with a breakpoint, wait until it stops"),
        Help(("continue", "c"), "[SECONDS]", "continue; with a breakpoint, wait until it stops"),
        Help(("step", "s"), "[N]", "go to the next line, into calls"),
        Help(("next", "n"), "[N]", "go to the next line, over calls"),
        Help(("out", "o"), "", "go to the caller"),
        Help(("pause",), "", "pause the program"),
        Help(("stop",), "", "stop the program"),
        Help(("reset",), "[warm|cold|origin]", "reset it; cold: also retained values, origin: delete it"),
        Help(("break", "b"), "[FILE:]LINE [if CONDITION]", "stop before this line; without arguments, list all"),
        Help(("delete", "d"), "[[FILE:]LINE]...", "remove breakpoints; without arguments, all of them"),
        Help(("watch",), "[NAME]...", "stop behind a statement that changes a value; without arguments, list all"),
        Help(("unwatch",), "[NAME]...", "remove such breakpoints; without arguments, all of them"),
        Help(("back",), "[N | TIME | to LINE]", "go back by N lines, to a time such as 12.34s, or to a line"),
        Help(("reverse-continue", "rc"), "", "go back to the last breakpoint, or before the last change"),
        Help(("last",), "NAME", "say when a variable got its value, and from which line"),
        Help(("list", "l"), "[[FILE:]LINE]", "show the source around a line or around the next one"),
        Help(("where", "w"), "", "show the next line and its callers"),
        Help(("threads", "t"), "[NUMBER]", "list tasks; with a number, choose the one that is looked at"),
        Help(("print", "p"), "[NAME]...", "show values or expressions without blanks; without arguments, all roots"),
        Help(("locals",), "[N]", "show the variables of the routine, or of its N-th caller"),
        Help(("set",), "NAME=VALUE...", "write values"),
        Help(("force",), "NAME=VALUE...", "hold values until they are released"),
        Help(("release",), "[NAME]...", "release forced values; without arguments, all of them"),
        Help(("forced",), "", "list forced values"),
        Help(("trace",), "NAME... [WORDS]", "record values; WORDS are explained below"),
        Help(("state",), "", "show the state of the program"),
        Help(("help", "h"), "[COMMAND]", "show this list, or its line about a command"),
        Help(("quit", "q"), "", "leave; remove breakpoints, and continue a paused program"),
        Help(("leave",), "", "leave; keep breakpoints and a pause"),
    ),
    """\
To begin, enter `list 1`, `break 12`, then `run`. After a stop: `step`, `next`, `print NAME`, `continue`.
`trace NAME... every 5 depth 20 trigger NAME rising 2.5 before 5 csv FILE` shows a table; all words after the names
may be left out: a sample in every 5th cycle, 20 samples, from 5 before the value crosses 2.5, and into a file.
A breakpoint is no emergency stop: axes and outputs stay active. Forced values stay forced when you leave.""",
)
