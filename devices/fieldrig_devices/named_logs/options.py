"""The options of the commands that read a log by name, and what they make of them."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli.common import wrong_usage
from fieldrig_devices.named_logs.descriptions import NODES, UNITS, described
from fieldrig_devices.named_logs.filters import SERVICES, Filter
from fieldrig_devices.named_logs.named_log import NamedLog

if TYPE_CHECKING:
    from fieldrig.traces.oddities import Oddities
    from fieldrig_devices.dialogues.rtu_lines import RtuLines


def _option(name: str, metavar: str, about: str) -> typer.models.OptionInfo:
    option: typer.models.OptionInfo = typer.Option(name, metavar=metavar, help=about, show_default=False)
    return option


Eds = Annotated[
    list[str] | None,
    _option("--eds", "NODE=FILE", "The EDS or DCF file of a node, such as 5=io32.eds, or can1:5=io32.eds."),
]
Registers = Annotated[
    list[str] | None,
    _option("--registers", "UNIT=FILE", "The register table of a Modbus unit, such as 1=meter.yaml or 1=meter.csv."),
]
Nodes = Annotated[list[str] | None, _option("--node", "NODE", "Only this node: its node-ID, or a name of the rig.")]
Identifiers = Annotated[
    list[str] | None, _option("--id", "ID", "Only these CAN identifiers: 0x181, 0x180-0x1FF, or 0x180/0x780 (mask).")
]
Units = Annotated[list[str] | None, _option("--unit", "UNIT", "Only this Modbus unit.")]
RegisterWords = Annotated[
    list[str] | None,
    _option("--register", "REGISTER", "Only these registers: 40001, 40001-40010, holding:0, or a name of the table."),
]
Services = Annotated[
    list[str] | None, _option("--service", "SERVICE", f"Only this kind of service: {', '.join(SERVICES)}.")
]


def named_log(rig: Path | None, eds: list[str] | None, registers: list[str] | None) -> NamedLog:
    """Return the names that these options give.  ConfigError or UsageError for a file with mistakes."""
    from fieldrig.config.rig_file import load

    with wrong_usage():
        nodes = described(eds, NODES, "--eds 5=io32.eds")
        tables = described(registers, UNITS, "--registers 1=meter.yaml")
    return NamedLog(nodes, tables, None if rig is None else load(rig))


def chosen_by(
    names: NamedLog,
    nodes: list[str] | None,
    identifiers: list[str] | None,
    units: list[str] | None,
    registers: list[str] | None,
    services: list[str] | None,
) -> Filter:
    """Return what these options choose.  typer.BadParameter for a wrong one."""
    with wrong_usage():
        return Filter(nodes or (), identifiers or (), units or (), registers or (), services or (), names.tables)


def report_skipped(lines: "RtuLines", odd: "Oddities") -> None:
    """Report the bytes of lines with Modbus that are in no frame."""
    odd.number = 0  # it is no single place
    for bus, count in lines.skipped.items():
        odd.report("bytes are in no frame of Modbus", f": {count} on {bus}")
