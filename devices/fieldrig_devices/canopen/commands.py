"""`fieldrig eds`: commands for EDS and DCF files."""

from pathlib import Path
from typing import Annotated

import typer

from fieldrig.cli.common import AsJson, command_group, echo_json, reading
from fieldrig.system.exits import Exit

SECTION = "Files"
"""The group of the command in the help of `fieldrig`."""
app = command_group()


@app.callback()
def eds() -> None:
    """Check EDS and DCF files.

    \b
        fieldrig eds check configs/eds/io32.eds
    """


@app.command()
def check(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="EDS or DCF files.", show_default=False)],
    as_json: AsJson = False,
) -> None:
    """Compare files with CiA 306 and CiA 301; each finding says what to write instead.

    \b
        fieldrig eds check configs/eds/io32.eds
        fieldrig eds check --json *.eds *.dcf

    The exit code is 0 without errors, even if there are warnings, and 2 with errors.
    """
    from fieldrig_devices.canopen.eds.check import Severity, check_eds

    has_error = False
    for path in files:
        with reading(path):
            findings = check_eds(path)
        has_error |= any(finding.severity is Severity.ERROR for finding in findings)
        for finding in findings:
            if as_json:
                echo_json(finding._asdict() | {"severity": finding.severity.value, "file": str(path)})
            else:
                typer.echo(f"{path}:{finding}")
        if not findings and not as_json:
            typer.echo(f"{path}: no errors and no warnings")
    if has_error:
        raise typer.Exit(Exit.WRONG)
