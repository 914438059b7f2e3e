"""Shared parts of all commands, including those of installed packages: groups, options, files, output, wrong usage.

A command raises RigError for whatever its user can fix, and `fieldrig.cli.outcome` prints it and chooses the exit code:
UsageError for a file or a request that is wrong, RefusedError for a device that refuses.  Wrong options and arguments
are `typer.BadParameter`, so that the command's usage is shown with the message.
"""

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Annotated, Any, Final

import typer
from typer.core import TyperGroup

from fieldrig.cli import completion
from fieldrig.errors import UsageError
from fieldrig.outside.addresses import ENDPOINT_VARIABLE
from fieldrig.outside.page_seat import NO_PAGE_VARIABLE
from fieldrig.text import durations
from fieldrig.text.nearest import nearest_file
from fieldrig.text.strict_json import strict_json

CONTEXT: Final[Mapping[str, Any]] = {"help_option_names": ["-h", "--help"], "max_content_width": 110}
MOST_IN_A_LINE: Final = 12
"""Characters of the longest cell of a column, such as a duration, that is not folded on a narrow terminal."""
NO_LIMIT: Final = 10**6
"""Width in characters of a table that goes into a pipe or a file."""

Overrides = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Override a value of the rig file, such as buses.can0.bitrate=250000. May be given several times.",
        show_default=False,
    ),
]
Endpoint = Annotated[
    str,
    typer.Option(
        "--control", metavar="ENDPOINT", envvar=ENDPOINT_VARIABLE, help="Connect to the rig at this control endpoint."
    ),
]
ListenAt = Annotated[
    str | None,
    typer.Option(
        "--control",
        metavar="ENDPOINT",
        envvar=ENDPOINT_VARIABLE,
        help="Listen for control connections here, instead of the rig file's `control`.",
        show_default=False,
    ),
]
WithoutPage = Annotated[
    bool, typer.Option("--no-ui", envvar=NO_PAGE_VARIABLE, help="Run without the page of the rig in a browser.")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON, for scripts.")]
For = Annotated[
    str | None,
    typer.Option("--for", metavar="DURATION", help="Stop after this time, such as 10s.", show_default=False),
]
Count = Annotated[
    int | None,
    typer.Option("--count", "-n", metavar="N", min=1, help="Stop after N lines or messages.", show_default=False),
]


def command_group(cls: type[TyperGroup] | None = None) -> typer.Typer:
    """Return an empty group of commands that looks like all others; `cls` may add commands to it."""
    return typer.Typer(
        cls=cls, no_args_is_help=True, add_completion=False, rich_markup_mode=None, context_settings=dict(CONTEXT)
    )


def argument(metavar: str, about: str, complete: Callable[..., Any] | None = None) -> Any:
    """Return an argument without a default in its help; `complete` offers words to the shell."""
    return typer.Argument(metavar=metavar, help=about, show_default=False, autocompletion=complete)


def port_option(what: str, variable: str) -> Any:
    """Return the option `--port` of a command that talks to a device over a serial line.

    `what` is the port's description, `variable` the environment variable that replaces the option.
    """
    return typer.Option(
        "--port",
        metavar="PORT",
        envvar=variable,
        help=f"{what}: a serial device, a pty, socket://HOST:PORT or rfc2217://HOST:PORT.",
        show_default=False,
    )


RigFile = Annotated[Path, argument("FILE", "The rig file.", completion.rig_file)]


def duration_ns(text: str) -> int:
    """Return a duration such as `10ms`, `1.5s` or `2min` in nanoseconds.  typer.BadParameter for anything else."""
    with wrong_usage():
        return durations.duration_ns(text)


def assignment(word: str, example: str) -> tuple[str, str]:
    """Return the two sides of KEY=VALUE.  typer.BadParameter, with the example, for anything else."""
    key, equals, value = word.partition("=")
    if not equals or not key:
        raise typer.BadParameter(f"{word!r} is not an assignment; expected KEY=VALUE, such as {example}")
    return key, value


@contextmanager
def wrong_usage() -> Iterator[None]:
    """Turn a ValueError into typer.BadParameter.  The first line of its text is the problem, the rest is the remedy."""
    try:
        yield
    except ValueError as cause:
        what, _, remedy = str(cause).partition("\n")
        raise typer.BadParameter(f"{what}; {remedy}" if remedy else what) from cause


def reading(path: Path, remedy: str = "") -> AbstractContextManager[None]:
    """Turn an OSError into a UsageError: the file cannot be read."""
    return _access(f"{path} cannot be read", nearest_file(path) or remedy)


def writing(path: Path, remedy: str = "") -> AbstractContextManager[None]:
    """Turn an OSError into a UsageError: the file, or one in the folder, cannot be written."""
    return _access(f"{path} cannot be written", remedy)


@contextmanager
def _access(failure: str, remedy: str) -> Iterator[None]:
    try:
        yield
    except OSError as cause:
        raise UsageError(f"{failure}: {cause.strerror or cause}", remedy) from cause


def echo_json(value: Any) -> None:
    """Print a value as one line of JSON."""
    typer.echo(json_text(value))


class JsonRows:
    """Prints a list as JSON with one line for each value, as soon as it is there."""

    def __init__(self) -> None:
        self._before = "["

    def add(self, value: Any) -> None:
        typer.echo(f"{self._before}{json_text(value)}")
        sys.stdout.flush()
        self._before = ","

    def end(self) -> None:
        typer.echo("]" if self._before == "," else "[]")


def json_text(value: Any, indent: int | None = None) -> str:
    """Return a value as JSON, in ASCII if the output has not all characters."""
    has_all = (sys.stdout.encoding or "").lower().replace("-", "") == "utf8"
    return strict_json(value, ensure_ascii=not has_all, indent=indent)


def echo_table(headings: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Print columns: fitted to the width of a terminal, where long cells are folded, and in full length elsewhere."""
    from rich.console import Console
    from rich.table import Table

    cells = [["" if cell is None else str(cell) for cell in row] for row in rows]
    table = Table(box=None, pad_edge=False, header_style="bold")
    for place, heading in enumerate(headings):
        is_short = all(len(row[place]) <= MOST_IN_A_LINE for row in cells)
        table.add_column(heading, overflow="fold", no_wrap=is_short)
    for row in cells:
        table.add_row(*row)
    console = Console(highlight=False, markup=False)
    if console.is_terminal:
        console.print(table)
        return
    console.width = NO_LIMIT
    with console.capture() as captured:
        console.print(table)
    for line in captured.get().splitlines():
        typer.echo(line.rstrip())
