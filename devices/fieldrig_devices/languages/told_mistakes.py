"""The end of a command that checks a program: its mistakes and notes, for people or as JSON, and the exit code."""

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING

import typer

from fieldrig.cli.common import echo_json
from fieldrig.system.exits import Exit

if TYPE_CHECKING:
    from fieldrig_devices.languages.mistakes import Mistake


def tell(mistakes: "Sequence[Mistake]", right: str, *, as_json: bool) -> None:
    """Print mistakes and notes, or else what is to be said of a right program; typer.Exit if it has mistakes."""
    is_wrong = any(not mistake.is_note for mistake in mistakes)
    if as_json:
        echo_json([dataclasses.asdict(mistake) for mistake in mistakes])
    else:
        for mistake in mistakes:
            typer.echo(str(mistake), err=not mistake.is_note)
        if not is_wrong:
            typer.echo(right)
    if is_wrong:
        raise typer.Exit(Exit.WRONG)
