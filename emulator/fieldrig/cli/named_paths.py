"""Empty texts where a command expects a path.

`fieldrig check "$RIG"` with an unset variable gives an empty text, which Python takes as the current folder: a command
would then write there, or complain of a folder that its user has not named.
"""

import inspect
from functools import partial
from pathlib import Path
from typing import Any, get_args, get_type_hints

import typer


def refuse_empty_paths(command: Any) -> None:
    """Have a command, and all commands below it, refuse empty texts as paths.

    What click calls a command is Any here: some versions of typer have a click of their own.
    """
    hints = get_type_hints(inspect.unwrap(command.callback)) if command.callback is not None else {}
    for parameter in command.params:
        if _is_path(hints.get(parameter.name)) and "process_value" not in vars(parameter):
            parameter.process_value = partial(_checked, parameter, parameter.process_value)
    for below in getattr(command, "commands", {}).values():
        refuse_empty_paths(below)


def _is_path(hint: Any) -> bool:
    """Return whether this is `Path`, `list[Path]` or the like."""
    return hint is Path or any(_is_path(part) for part in get_args(hint))


def _checked(parameter: Any, process: Any, context: Any, value: Any) -> Any:
    for text in value if isinstance(value, list | tuple) else [value]:
        if isinstance(text, str) and not text.strip():
            raise typer.BadParameter(f"expected a path, got {text!r}; `.` is the current folder", context, parameter)
    return process(context, value)
