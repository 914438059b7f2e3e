"""`fieldrig eds`: commands for EDS and DCF files."""

import json
from pathlib import Path
from typing import Annotated

import typer

from fieldrig.exits import Exit

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)


@app.callback()
def eds() -> None:
    """Look at EDS and DCF files.

    \b
        fieldrig eds check configs/eds/io32.eds
    """


@app.command()
def check(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="EDS or DCF files.", show_default=False)],
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, for scripts.")] = False,
) -> None:
    """Say what CiA 306 and CiA 301 ask for and a file doesn't have, and what to write instead.

    \b
        fieldrig eds check configs/eds/io32.eds
        fieldrig eds check --json *.eds *.dcf

    Exit code 0: no errors, though maybe warnings; 2: errors.
    """
    from fieldrig_devices.canopen.eds.check import Severity, check_eds

    has_error = False
    for path in files:
        try:
            found = check_eds(path)
        except OSError as cause:
            typer.echo(f"{path}: can't be read: {cause.strerror}", err=True)
            raise typer.Exit(Exit.WRONG) from cause
        has_error |= any(one.severity is Severity.ERROR for one in found)
        for one in found:
            fields = one._asdict() | {"severity": one.severity.value, "file": str(path)}
            typer.echo(json.dumps(fields, ensure_ascii=False) if as_json else f"{path}:{one}")
        if not found and not as_json:
            typer.echo(f"{path}: nothing to find fault with")
    if has_error:
        raise typer.Exit(Exit.WRONG)
