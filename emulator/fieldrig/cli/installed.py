"""Commands that installed packages bring along: entry points of the group "fieldrig.commands".

The commands of `fieldrig trace` are in the group "fieldrig.trace_commands".

An entry point names a function, as typer takes it for a command, or a `typer.Typer` with commands of its own.  It is
imported when it is called, and when all commands are listed; so its module should import little by itself.
"""

import inspect
from difflib import get_close_matches
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, ClassVar, Final, get_args, get_type_hints

import typer
from typer.core import TyperGroup

from fieldrig.cli.common import command_group
from fieldrig.config.kinds import installed


def refuse_empty_paths(command: Any) -> None:
    """Have a command, and all commands below it, refuse empty texts as paths.

    `fieldrig check "$RIG"` with an unset variable gives an empty text, which Python takes as the current folder: a
    command would then write there, or complain of a folder that its user has not named.

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


COMMANDS: Final = "fieldrig.commands"


SECTIONS: Final = {
    "Run a rig": ("up", "restart", "stop", "pause", "step", "back", "run", "exec"),
    "Look and change": ("help", "status", "watch", "get", "set", "fault", "record", "trace"),
    "Files": ("check", "schema"),
    "Programs": ("coverage",),
    "Devices": ("devices",),
}
"""The groups of the help, with our own commands in them.

The module of an installed command names its group by the constant `SECTION`; without one it is among the devices.
"""


class Extended(TyperGroup):
    """A group of our own commands first, then of the installed ones.

    What click calls a command is Any here: some versions of typer have a click of their own.
    """

    entry_points: ClassVar[str]
    """The group of the entry points of the installed commands."""

    def list_commands(self, ctx: Any) -> list[str]:
        own = super().list_commands(ctx)
        return [*own, *(name for name in installed(self.entry_points) if name not in own)]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        command = super().get_command(ctx, cmd_name)
        if command is None and cmd_name in installed(self.entry_points):
            command = _loaded(self.entry_points, cmd_name)
        if command is not None:
            refuse_empty_paths(command)
        return command

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return a command; a mistyped one is refused with the nearest of all, the installed ones as well."""
        if args and not args[0].startswith("-") and self.get_command(ctx, args[0]) is None:
            near = get_close_matches(args[0], self.list_commands(ctx), n=1)
            hint = f" Did you mean {near[0]!r}?" if near else ""
            ctx.fail(f"No such command {args[0]!r}.{hint}")
        return super().resolve_command(ctx, args)


class TraceCommands(Extended):
    """The commands of `fieldrig trace`."""

    entry_points = "fieldrig.trace_commands"


class Commands(Extended):
    """The commands of `fieldrig`, which are in groups in the help."""

    entry_points = COMMANDS

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write a list of commands for each group."""
        names = self.list_commands(ctx)
        width = max(map(len, names))
        for section in SECTIONS:
            chosen = [name for name in names if _section_of(name) == section]
            shown = [(name.ljust(width), self.get_command(ctx, name)) for name in chosen]
            with formatter.section(section):
                limit = formatter.width - 6 - width
                formatter.write_dl([(name, command.get_short_help_str(limit)) for name, command in shown])


def _section_of(name: str) -> str:
    for section, own in SECTIONS.items():
        if name in own:
            return section
    module = import_module(installed(COMMANDS)[name].module)
    section = getattr(module, "SECTION", "")
    return section if section in SECTIONS else "Devices"


def _loaded(group: str, name: str) -> Any:
    command = installed(group)[name].load()
    if not isinstance(command, typer.Typer):
        function = command
        command = command_group()
        command.command(name)(function)
    made: Any = typer.main.get_command(command)
    made.name = name
    return made
