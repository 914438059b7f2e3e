"""`fieldrig export`: a rig in the files of other tools."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli.common import Overrides, RigFile, writing
from fieldrig.errors import UsageError
from fieldrig.system.whole_file import whole_file

if TYPE_CHECKING:
    from fieldrig.config.rig_file import RigConfig

SECTION = "Files"
"""The group of the command in the help of `fieldrig`."""
DBC, CSV = ".dbc", ".csv"

Content = Mapping[str, bytes]
"""The content of files by their names, without an ending."""


def export(
    rig: RigFile,
    dbc: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE|DIR",
            help="Write the CAN network as DBC: a file, or a folder with a file for each bus.",
            show_default=False,
        ),
    ] = None,
    csv: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE|DIR",
            help="Write the register table as CSV: a file, or a folder with a file for each table.",
            show_default=False,
        ),
    ] = None,
    markdown: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write the register tables as a page in Markdown.", show_default=False),
    ] = None,
    overrides: Overrides = None,
) -> None:
    """Write what a rig consists of for other tools: CAN messages as DBC, registers as CSV and Markdown.

    \b
        fieldrig export lab.yaml --dbc lab.dbc           for SavvyCAN, asammdf and cantools
        fieldrig export machine.yaml --dbc networks      several CAN buses: a file for each, in a folder
        fieldrig export lab.yaml --csv pump.csv          `fieldrig new --registers pump.csv` reads it back
        fieldrig export lab.yaml --markdown registers.md
    """
    from fieldrig.config.rig_file import load

    if dbc is csv is markdown is None:
        raise UsageError("nothing is to be written", "name a file after --dbc, --csv or --markdown")
    config = load(rig, overrides or ())
    if dbc is not None:
        _write(dbc, DBC, _networks(config), f"{rig} has no CAN bus")
    if csv is not None:
        _write(csv, CSV, _lists(config), f"{rig} has no register table")
    if markdown is not None:
        _write_page(markdown, config, f"{rig} has no register table")


def _networks(config: "RigConfig") -> Content:
    from fieldrig_devices.export.can_networks import networks

    try:
        from fieldrig_devices.export.dbc import text_of
    except ImportError as missing:
        if (missing.name or "").partition(".")[0] != "cantools":
            raise
        raise UsageError("DBC files need the package cantools", "python -m pip install 'fieldrig[dbc]'") from missing
    return {network.name: text_of(network) for network in networks(config)}


def _lists(config: "RigConfig") -> Content:
    from fieldrig_devices.export.register_csv import csv_of
    from fieldrig_devices.export.register_units import unit_tables

    return {unit.name: csv_of(unit.table).encode() for unit in unit_tables(config)}


def _write(target: Path, ending: str, content: Content, without: str) -> None:
    """Write a file, or one for each in a folder if the target has no ending or is one."""
    if not content:
        raise UsageError(without, "")
    is_folder = target.is_dir() or not target.suffix
    if not is_folder and target.suffix.lower() != ending:
        raise UsageError(f"{target} has another ending", f"name a file that ends in {ending}, or a folder")
    if not is_folder and len(content) > 1:
        raise UsageError(f"{target} is one file, but there are {', '.join(content)}", "name a folder instead")
    files = {target / f"{name}{ending}" if is_folder else target: data for name, data in content.items()}
    with writing(target, "name another file or folder"):
        for file, data in files.items():
            file.parent.mkdir(parents=True, exist_ok=True)
            with whole_file(file) as opened:
                opened.write(data)
    for file in files:
        typer.echo(str(file))


def _write_page(target: Path, config: "RigConfig", without: str) -> None:
    from fieldrig_devices.export.register_page import page_of
    from fieldrig_devices.export.register_units import unit_tables

    tables = list(unit_tables(config))
    if not tables:
        raise UsageError(without, "")
    with writing(target, "name another file"):
        target.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(target) as opened:
            opened.write(page_of(config.name, tables).encode())
    typer.echo(str(target))
