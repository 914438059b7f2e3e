"""Commands that installed packages bring along: entry points of the group "fieldrig.commands".

An entry point names a function, as typer takes it for a command, or a `typer.Typer` with commands of its own.  It is
imported when it is called, and when all commands are listed; so its module should import little by itself.
"""

from typing import Any, Final

import typer
from typer.core import TyperGroup

from fieldrig.cli.common import command_group
from fieldrig.kinds import installed

COMMANDS: Final = "fieldrig.commands"


class Commands(TyperGroup):
    """Our own commands first, then the installed ones.

    What click calls a command is Any here: some versions of typer have a click of their own.
    """

    def list_commands(self, ctx: Any) -> list[str]:
        own = super().list_commands(ctx)
        return [*own, *(name for name in installed(COMMANDS) if name not in own)]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        found = super().get_command(ctx, cmd_name)
        return _loaded(cmd_name) if found is None and cmd_name in installed(COMMANDS) else found


def _loaded(name: str) -> Any:
    command = installed(COMMANDS)[name].load()
    if not isinstance(command, typer.Typer):
        function = command
        command = command_group()
        command.command(name)(function)
    made: Any = typer.main.get_command(command)
    made.name = name
    return made
