"""Settings of a MAx-4 in a rig file."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from fieldrig.clock import MS
from fieldrig.settings import MASTER, Claim, ConfigFile, Settings, WrongKey, refuse_all
from fieldrig.text.source_text import decoded
from fieldrig_devices.canopen.described import DescribedNode
from fieldrig_devices.canopen.master_settings import CanMasterSettings
from fieldrig_devices.iec.costs import Costs
from fieldrig_devices.iec.dialect import DIALECTS
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.max4.can.objects import EDS
from fieldrig_devices.max4.can.settings import CanFaceSettings
from fieldrig_devices.max4.configuration.files import Configuration, DriveSettings, Symbol, symbol_of
from fieldrig_devices.max4.configuration.limits import MOST_AXES
from fieldrig_devices.max4.configuration.version import version_of
from fieldrig_devices.max4.modbus.marker_names import MarkerNames, markers_in
from fieldrig_devices.max4.modbus.settings import ModbusFaceSettings
from fieldrig_devices.max4.storage.disk import file_name
from fieldrig_devices.max4.storage.retain import RetainKind
from fieldrig_devices.modbus.client_settings import ModbusClientSettings
from fieldrig_devices.registers.described import NamedUnit
from fieldrig_devices.registers.packed import Element

Wires = dict[Symbol, str]
"""Wires by symbolic name of the terminal; an empty name means not wired."""


class BootTimes(Settings):
    """Times of a boot, counted from the start of its clock (manual 4093-4110, 4317-4337)."""

    started_ms: int = Field(default=1, ge=0, description="entry 8002")
    drives_ms: int = Field(default=14, ge=0, description="reports of drives during the boot")
    program_ms: int = Field(default=92, ge=0, description="entries 8004 and 8005, with autostart")
    finished_ms: int = Field(default=57, ge=0, description="entry 8003, without autostart")
    finished_autostart_ms: int = Field(default=98, ge=0, description="entry 8003, with autostart")
    ring_wait_ms: int = Field(default=3_000, ge=0, description="longest time to wait for an open ring to close")
    clock_starts: Literal["ring", "power_on"] = Field(
        default="ring", description="time stamps count from when the ring is up (or has failed), or from power-on"
    )


class IdentitySettings(Settings):
    """The data besides the version that a service report contains (manual 7739-7751)."""

    article_number: str = Field(default="13130241-001", max_length=32)
    serial_number: str = Field(default="0000000001", max_length=32)
    hardware_code: str = Field(default="01.00.00", max_length=32)


class ProcessTimes(Settings):
    """Processor time of the real-time process in each cycle, and of tasks of the system beside a program."""

    base_us: int = Field(default=60, ge=0, description="duration without axes")
    axis_us: int = Field(default=12, ge=0, description="additional duration per axis")
    io_map_us: int = Field(
        default=50, ge=0, le=100_000, description="duration of an IO map update, at the priority of IEC task 4"
    )
    tcp_us: int = Field(
        default=150, ge=0, le=100_000, description="duration of a request over TCP/IP, at the priority of IEC task 5"
    )


class Com1Settings(Settings):
    """The serial port COM1."""

    modem: Symbol | None = Field(
        default=None,
        description="symbolic name of the Modem object; parameters: start values of Com1User and of the object",
    )
    baud: int | None = Field(
        default=38_400,
        ge=300,
        le=10_000_000,
        description="bit/s (the manual gives 38400); null: bytes are handed to an unpaced line at once",
    )


class FtpSettings(Settings):
    """The login of FTP."""

    user_name: str = Field(min_length=1, max_length=64, description="user name")
    password: str = Field(min_length=1, max_length=64, description="password")


def _known_version(text: str) -> str:
    version_of(text)
    return text


def _classes(classes: dict[int, int]) -> dict[int, int]:
    for code, number in classes.items():
        if not 1 <= number <= 8:
            raise ValueError(f"class of {code}: expected 1 to 8, got {number}")
    return classes


def disk_name(path: Path) -> str:
    """Return the name of a file of the rig file on the flash disk.  ValueError if it cannot have this name there."""
    return file_name(f"\\{path.name}")


def _as_list(value: Any) -> Any:
    return [value] if isinstance(value, str | Path) else value


class Max4Settings(Settings):
    """Settings of the controller."""

    project: Annotated[str, Field(pattern=r"^[A-Z][A-Z0-9]{0,7}$", examples=["TEST"])] = Field(
        default="TEST", description="name of the configuration file and the parameter file"
    )
    version: Annotated[str, AfterValidator(_known_version)] = Field(
        default="V00.15.00", description="version of the software"
    )
    identity: IdentitySettings = Field(default_factory=IdentitySettings, description="data of the type plate")
    cycle_ms: Literal[1, 2, 4] = Field(default=4, description="cycle time of the ring (parameter CycleTime)")
    drives: dict[Symbol, DriveSettings] = Field(default_factory=dict, description="axes by symbolic name")
    max_axes: int = Field(
        default=40, ge=1, le=MOST_AXES, description="largest number of axes; the manual gives 40, 44 and 47"
    )
    missing_drive: Literal["leave_out", "stop"] = Field(
        default="leave_out", description="whether the ring comes up without a drive that does not answer, or not at all"
    )
    logic_encoders: list[Symbol] = Field(default_factory=list, description="symbolic names of logic encoders")
    master_encoders: Wires = Field(
        default_factory=dict, description="wires that master encoders count, by symbolic name"
    )
    inputs: Wires = Field(default_factory=dict, description="wires of digital inputs, by symbolic name")
    outputs: Wires = Field(default_factory=dict, description="wires of digital outputs, by symbolic name")
    measuring_inputs: Wires = Field(default_factory=dict, description="wires of touch probe inputs, by symbolic name")
    err_wire: str = Field(default="", description="wire that is true while the err LED flashes")
    parameters: dict[str, bool | int | float | str] = Field(
        default_factory=dict, description="start values by path: MAx-4.General.MsgFilter: 0xFFFF"
    )
    program: Annotated[list[ConfigFile], BeforeValidator(_as_list, json_schema_input_type=str | list[str])] = Field(
        default_factory=list, description="sources of the IEC program, which become DEFAULT.PRG: a file or a list"
    )
    dialect: Literal["epas-4", "edition-3", "codesys"] = Field(
        default="epas-4",
        description="rules of the language: the manual, IEC 61131-3 edition 3, or CODESYS and TwinCAT",
    )
    resource: str = Field(
        default="", description="name of the RESOURCE that runs, if the configuration of the program has several"
    )
    iec_tasks: list[Symbol] = Field(
        default_factory=list, description="IEC Task objects: the first one observes the first task, and so on"
    )
    autostart: bool = Field(default=False, description="whether the stored program starts at each boot")
    language: Literal["de", "en"] = Field(default="en", description="language of messages")
    diagnosis_classes: Annotated[dict[int, int], AfterValidator(_classes)] = Field(
        default_factory=dict, description="classes of codes whose class is not their first digit"
    )
    modbus: ModbusFaceSettings = Field(
        default_factory=ModbusFaceSettings, description="Modbus server on the buses under links.modbus"
    )
    modbus_client: ModbusClientSettings | None = Field(default=None, description="Modbus client on one of these buses")
    can_master: CanMasterSettings | None = Field(default=None, description="CANopen master on links.can")
    can_axes: CanFaceSettings | None = Field(
        default=None, description="CANopen slave on links.can, with the axes as CiA 402 axes"
    )
    com1: Com1Settings = Field(default_factory=Com1Settings, description="serial port links.com1, for a modem")
    ftp: FtpSettings | None = Field(default=None, description="login of FTP to the flash disk; null: no FTP")
    http_names: list[str] = Field(
        default_factory=list,
        description="names with a dot by which browsers reach the pages, such as plc.example.org (DNS rebinding)",
    )
    io_map_ms: int = Field(
        default=10, ge=1, le=1000, description="period of the IO map update, which exchanges data of field buses"
    )
    boot: BootTimes = Field(default_factory=BootTimes, description="times of a boot")
    load: ProcessTimes = Field(default_factory=ProcessTimes, description="duration of the real-time process")
    costs: Costs = Field(default_factory=Costs, description="processor time of the operations of a program")
    retain: RetainKind = Field(
        default="nvram",
        description="memory of retain data: 1 kB in the controller, 64 kB on the flash disk by a UPS, 101 kB in a PN-4",
    )
    retain_battery: bool = Field(
        default=False, description="whether the PN-4 has a battery, which keeps its data for more than 7 days"
    )
    off_days: float = Field(default=0.0, ge=0, description="days without power before the start of the rig")
    disk_bytes: int = Field(default=4_000_000, ge=65_536, description="size of the flash disk")
    files: list[ConfigFile] = Field(
        default_factory=list, description="further files of the flash disk, such as support points of cams"
    )
    memory_free_bytes: int = Field(default=6_930_636, ge=0, description="value of the parameter Memoryfree")

    def cycle_ns(self) -> int:
        """Return the cycle of the ring, unless the controller has stored another CycleTime."""
        return self.cycle_ms * MS

    def canopen_nodes(self) -> Iterator[DescribedNode]:
        if self.can_axes is not None:
            yield from (DescribedNode(node_id, EDS, self.can_axes.objects) for node_id in self.can_axes.node_ids)

    def register_names(self) -> Iterator[NamedUnit]:
        """Yield the server, whose markers are variables of the program."""
        sources = [SourceFile(path.name, decoded(path.read_bytes())) for path in self.program]
        yield NamedUnit(self.modbus.unit_id, MarkerNames(markers_in(sources, DIALECTS[self.dialect])))

    def serves(self) -> Iterator[Claim]:
        for service in ("http", "ftp"):
            yield Claim("tcp", "service", service, ())

    def claims(self, device: str) -> Iterator[Claim]:
        """The names and addresses that the controller occupies; a CANopen node answers only one master."""
        yield Claim("ring", MASTER, "of the ring", ())
        yield Claim("modbus", "unit", self.modbus.unit_id, ("modbus", "unit_id"))
        if self.can_axes is not None:
            for number, node_id in enumerate(self.can_axes.node_ids):
                yield Claim("can", "node-ID", node_id, ("can_axes", "node_ids", number))
        if self.can_master is not None:
            yield Claim("can", "node-ID", self.can_master.node_id, ("can_master", "node_id"))
            for symbol, node in self.can_master.nodes.items():
                yield Claim("can", "master of node-ID", node.node_id, ("can_master", "nodes", symbol, "node_id"))
        for symbol, wire in self.outputs.items():
            if wire:
                yield Claim("wires", "wire", wire, ("outputs", symbol))
        if self.err_wire:
            yield Claim("wires", "wire", self.err_wire, ("err_wire",))

    def needs(self, device: str) -> Iterator[Claim]:
        if self.modbus_client is not None:
            for symbol, unit in self.modbus_client.units.items():
                path = ("modbus_client", "units", symbol, "unit")
                yield Claim("modbus", "unit", unit.unit, path, self.modbus_client.link - 1)

    @property
    def configuration(self) -> Configuration:
        return Configuration(
            drives=self.drives,
            logic_encoders=self.logic_encoders,
            master_encoders=list(self.master_encoders),
            inputs=list(self.inputs),
            outputs=list(self.outputs),
            measuring_inputs=list(self.measuring_inputs),
            iec_tasks=self.iec_tasks,
            modems=[] if self.com1.modem is None else [self.com1.modem],
        )

    def _modules(self) -> Iterator[tuple[tuple[str, ...], list[Element]]]:
        """Yield the path of each module of a field bus, which ends with its name, and its values."""
        if self.modbus_client is not None:
            for name, unit in self.modbus_client.units.items():
                values = [value for message in (*unit.reads, *unit.writes) for value in message.values]
                yield ("modbus_client", "units", name), values
        if self.can_master is not None:
            for name, node in self.can_master.nodes.items():
                values = [value for pdo in (*node.inputs.values(), *node.outputs.values()) for value in pdo]
                yield ("can_master", "nodes", name), values

    def _wrong_names(self) -> Iterator[WrongKey]:
        """Yield names of modules and of their values that cannot be names in the object tree."""
        for path, values in self._modules():
            for name in (path[-1], *(value.name for value in values)):
                try:
                    symbol_of(name)
                except ValueError as wrong:
                    yield WrongKey(path, str(wrong))

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        refuse_all(self._wrong_names())
        names = [disk_name(path) for path in self.files]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"files: expected each name once, but {twice[0]} is used twice")
        if len(self.drives) > self.max_axes:
            raise ValueError(f"drives: expected at most {self.max_axes} (max_axes), got {len(self.drives)}")
        configuration = self.configuration  # which checks itself
        if self.retain_battery and self.retain != "pn4":
            raise ValueError(
                "retain_battery: expected retain: pn4 beside it, because only the PN-4 module has a battery"
            )
        if unknown := sorted(self.modbus.units.keys() - self.drives.keys()):
            raise ValueError(f"modbus.units: expected names of drives, got {', '.join(unknown)}")
        seen = {symbol.casefold() for symbol in configuration.symbols}
        for symbol in (path[-1] for path, _ in self._modules()):
            if symbol.casefold() in seen:
                raise ValueError(f"symbolic name {symbol}: expected each name once, but it is used twice")
            seen.add(symbol.casefold())
        return self
