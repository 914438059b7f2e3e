"""Values of a program in the debugger: how they are read, written, forced and shown."""

import re
from collections.abc import Mapping, Sequence
from typing import Any, Final

from fieldrig_devices.languages.debugging.adapter import Ask
from fieldrig_devices.languages.debugging.texts import shown

MOST_SHOWN: Final = 200
"""Values that one name shows at most."""
_WORD: Final = re.compile(r"(?:'[^']*'|[^\s'])+|'")


def words_of(text: str) -> list[str]:
    """Split at blanks, but not inside of 'texts'."""
    return _WORD.findall(text)


def printed(ask: Ask, names: Sequence[str], thread: int | None) -> list[str]:
    """Return the values of variables and expressions, and what is in groups; the roots without names.

    ValueError for one that cannot be read.
    """
    if not names:
        return [_shown(variable) for variable in ask({"command": "variables", "path": ""})["variables"]]
    scope = {} if thread is None else {"thread": thread}
    lines = []
    for variable in ask({"command": "read", "names": list(names), **scope})["variables"]:
        if "error" in variable:
            raise ValueError(variable["error"])
        inside = []
        if variable["value"] is None:
            inside = ask({"command": "variables", "path": variable["path"]})["variables"]
        if not inside:
            lines.append(_shown(variable))
        lines += [_shown(child) for child in inside[:MOST_SHOWN]]
        if len(inside) > MOST_SHOWN:
            lines.append(f"and {len(inside) - MOST_SHOWN} more")
    return lines


def inside(ask: Ask, path: str) -> list[str]:
    """Return the values in a group."""
    variables = ask({"command": "variables", "path": path})["variables"]
    return [_shown(variable) for variable in variables[:MOST_SHOWN]]


def assign(ask: Ask, command: str, arguments: Sequence[str]) -> list[str]:
    """Write or force the values of NAME=VALUE, and return what they are then."""
    if not arguments:
        raise ValueError("nothing to change\nexpected NAME=VALUE, such as Main.count=5")
    wanted: dict[str, str] = {}
    for argument in arguments:
        name, sign, value = argument.partition("=")
        if not sign or not value:
            raise ValueError(f"{argument!r} has no value\nexpected {name}=VALUE, without blanks")
        wanted[name.rstrip(":")] = value
    return [_shown(variable) for variable in ask({"command": command, "values": wanted})["variables"]]


def forced(ask: Ask) -> list[str]:
    return [_shown(variable) for variable in _forced(ask)]


def release(ask: Ask, names: Sequence[str]) -> list[str]:
    """Release forced values, all of them without names, and return what they are then."""
    wanted = list(names) or [variable["path"] for variable in _forced(ask)]
    if not wanted:
        return ["no value is forced"]
    return [_shown(variable) for variable in ask({"command": "release", "names": wanted})["variables"]]


def _forced(ask: Ask) -> list[Mapping[str, Any]]:
    variables: list[Mapping[str, Any]] = ask({"command": "forced"})["variables"]
    return variables


def _shown(variable: Mapping[str, Any]) -> str:
    if "error" in variable:
        return f"{variable['name']}: {variable['error']}"
    path = variable["path"].partition(".")[2] if variable["path"].startswith("@") else variable["path"]
    mark = " (forced)" if variable["is_forced"] else ""
    about = f"  {variable['about']}" if variable["about"] else ""
    if variable["value"] is None:
        return f"{path}: {variable['type']}{about}"
    return f"{path} = {shown(variable)}{mark}{about}"
