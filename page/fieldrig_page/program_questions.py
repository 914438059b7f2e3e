"""Questions to the debugging service of a device (`languages/debugging/service.py`), in the terms of the page."""

from typing import Any, Final

from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig_page.rig_link import RigLink

PROGRAM: Final = "program:"
"""Begins the key of a variable of a program."""
MOST_LEAVES: Final = 2_000
MOST_GROUPS: Final = 200
"""Most variables, and most groups of them, in the list of one device."""


async def debug(link: RigLink, device: str, command: str, **words: Any) -> Any:
    """Ask a `debug` question.  ControlError if the device has no program, or refuses."""
    return await link.ask(f"device/{device}/debug", {"command": command, **words})


async def has_program(link: RigLink, device: str) -> bool:
    """Return whether the device is one whose programs can be looked at."""
    try:
        await debug(link, device, "state")
    except ControlError:
        return False
    return True


async def read_variables(link: RigLink, device: str, names: list[str]) -> dict[str, tuple[Value | None, str]]:
    """Return the value of each variable, or why there is none."""
    try:
        answer = await debug(link, device, "read", names=names)
    except ControlError as wrong:
        return dict.fromkeys(names, (None, wrong.what))
    found = zip(names, answer["variables"], strict=True)
    return {
        name: (variable.get("text") or variable.get("value"), variable.get("error", "")) for name, variable in found
    }


async def write_variable(link: RigLink, device: str, name: str, value: Value) -> Any:
    """Write a variable, and return its value then.  ControlError if it cannot be written so."""
    (variable,) = (await debug(link, device, "write", values={name: value}))["variables"]
    if "error" in variable:
        raise ControlError(variable["error"])
    return variable["text"] or variable["value"]


async def leaves(link: RigLink, device: str) -> list[dict[str, Any]]:
    """Return the variables of a program that have values, as the facts of points; none without a program.

    A program with more groups or variables than the limits has the rest of them left out, as after the last one says.
    """
    found: list[dict[str, Any]] = []
    waiting = [""]
    groups = 0
    while waiting and groups < MOST_GROUPS and len(found) < MOST_LEAVES:
        path, groups = waiting.pop(0), groups + 1
        try:
            variables = (await debug(link, device, "variables", path=path))["variables"]
        except ControlError:  # no program, or one that has just been replaced
            continue
        for variable in variables:
            if variable["value"] is None:
                waiting.append(variable["path"])
            else:
                found.append(_fact(variable))
    return found[:MOST_LEAVES]


def _fact(variable: dict[str, Any]) -> dict[str, Any]:
    return {
        "key": PROGRAM + variable["path"],
        "unit": "",
        "about": variable["about"],
        "type": variable["type"],
        "writable": variable["is_writable"],
        "forced": variable["is_forced"],
    }
