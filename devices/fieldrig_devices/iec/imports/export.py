"""Text files: Structured Text, Instruction List, and the export of CoDeSys V2.3 (`.exp`).

An export is program text; what the programming system knows besides is in comments such as (* @PATH := '' *).  Bodies
of the graphic languages and the configuration of the controller are in sections of their own.
"""

import re
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.languages.mistakes import Mistake

_BODY: Final = re.compile(r"^[ \t]*_(LD|FBD|CFC|SFC|KOP|FUP)_?BODY\b|^[ \t]*_NETWORKS\b", re.MULTILINE)
_IS_EXPORT: Final = re.compile(r"\(\*\s*@(NESTEDCOMMENTS|PATH|OBJECTFLAGS|SYMFILEFLAGS|END_DECLARATION)\b")
_CONFIGURATION: Final = re.compile(
    r"^[ \t]*(_ALARMCONFIG|_CNC_PROGRAMMS|_WORKSPACE|PLC_CONFIGURATION|PLC_CONFIG|TASKCONFIG|_TASK_CONFIG|LIBRARY|"
    r"_LIBRARY|VISUALISATION|_VISU|WATCHLIST|_TRACE|PARAMETER_LIST)\b.*?^[ \t]*(?:END_\1|_END\w*|END_\w+)[^\n]*$",
    re.MULTILINE | re.DOTALL,
)


def read_text(name: str, text: str, dialect: Dialect) -> tuple[tree.Unit, list[Mistake]]:
    """Parse program text, and say what an export contains that is not program text."""
    notes: list[Mistake] = []
    if _IS_EXPORT.search(text):
        drawn = _BODY.search(text)
        if drawn is not None:
            line = text.count("\n", 0, drawn.start()) + 1
            return tree.Unit(name, ()), [
                Mistake(
                    line,
                    1,
                    "The export contains a body in a graphic language",
                    "bodies in ST or IL",
                    file=name,
                    hint="Convert the POU to ST or IL in the programming system, and export it again.",
                )
            ]
        text = _CONFIGURATION.sub(lambda match: _left_out(match, text, name, notes), text)
    unit, mistakes = parse(text, name, dialect)
    return unit, sorted([*notes, *mistakes])


def _left_out(match: re.Match[str], text: str, name: str, notes: list[Mistake]) -> str:
    line = text.count("\n", 0, match.start()) + 1
    notes.append(
        Mistake(line, 1, f"{match.group(1)} is left out; the rig file has the configuration", is_note=True, file=name)
    )
    return "\n" * match.group().count("\n")
