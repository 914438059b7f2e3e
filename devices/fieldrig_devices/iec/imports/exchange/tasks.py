"""Tasks and program instances of both exchange formats."""

import re
from typing import Final

from lxml import etree

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.imports.fragments import Fragments
from fieldrig_devices.iec.imports.xml import attribute, line_of

Element = etree._Element

_ISO: Final = re.compile(
    r"P(?:(\d{1,6})D)?(?:T(?:(\d{1,6})H)?(?:(\d{1,6})M)?(?:(\d{1,9}(?:\.\d{1,9})?)S)?)?", re.IGNORECASE
)
_CLOCK: Final = re.compile(r"()(\d{1,6}):(\d{1,6}):(\d{1,9}(?:\.\d{1,9})?)")
LOWEST_PRIORITY: Final = 31


def duration(text: str, line: int, fragments: Fragments) -> tree.Expression | None:
    """An interval: a constant of the language, a variable, a duration of ISO 8601 such as PT0.01S, or a clock.

    Version 1.01 of PLCopen XML writes hours, minutes and seconds, `00:00:00.100000`.
    """
    match = _CLOCK.fullmatch(text) or _ISO.fullmatch(text)
    if match is None or not any(match.groups()):
        return fragments.expression(text, line)
    days, hours, minutes, seconds = (float(part or 0) for part in match.groups())
    milliseconds = round((((days * 24 + hours) * 60 + minutes) * 60 + seconds) * 1_000)
    position = tree.Position(line, 1)
    return tree.Literal(tree.LiteralKind.TIME, milliseconds, f"T#{milliseconds}ms", position=position)


def program_without_task(
    tasks: list[tree.TaskDeclaration], programs: list[tree.ProgramInstance], free: list[tree.ProgramInstance]
) -> None:
    """A program without a task runs whenever no task does: in a free-running task of the lowest priority."""
    position = free[0].position
    names = {task.name.casefold() for task in tasks}
    name = "Background"
    while name.casefold() in names:
        name += "x"
    given = [task.priority.value for task in tasks if isinstance(task.priority, tree.Literal)]
    lowest = max([LOWEST_PRIORITY, *(value for value in given if isinstance(value, int))])
    priority = tree.Literal(tree.LiteralKind.INTEGER, lowest, str(lowest), position=position)
    tasks.append(tree.TaskDeclaration(name, priority, position=position))
    programs += [tree.ProgramInstance(p.name, name, p.type, position=p.position) for p in free]


def resource_of(
    node: Element, tasks: list[tree.TaskDeclaration], programs: list[tree.ProgramInstance]
) -> tree.Configuration:
    name = re.sub(r"\W", "_", attribute(node, "name").strip(), flags=re.ASCII) or "Resource"
    position = tree.Position(line_of(node), 1)
    return tree.Configuration(name, (), tuple(tasks), tuple(programs), resource=name, position=position)
