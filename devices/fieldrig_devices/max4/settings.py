"""What a rig file says about a MAx-4."""

from collections.abc import Iterator
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from fieldrig.settings import MASTER, Claim, ConfigFile, Settings
from fieldrig_devices.max4.can.master_settings import CanMasterSettings
from fieldrig_devices.max4.can.settings import CanFaceSettings
from fieldrig_devices.max4.configuration.files import Configuration, DriveSettings, Symbol
from fieldrig_devices.max4.configuration.limits import MOST_AXES
from fieldrig_devices.max4.configuration.version import version_of
from fieldrig_devices.max4.modbus.client_settings import ModbusClientSettings
from fieldrig_devices.max4.modbus.settings import ModbusFaceSettings
from fieldrig_devices.max4.storage.retain import RetainKind

Wires = dict[Symbol, str]
"""By symbolic name; "" is not wired."""


class BootTimes(Settings):
    """When things happen in a boot, after its clock has started (manual 4093-4110, 4317-4337)."""

    started_ms: int = Field(default=1, ge=0, description="entry 8002")
    drives_ms: int = Field(default=14, ge=0, description="what drives report while booting")
    program_ms: int = Field(default=92, ge=0, description="entries 8004 and 8005, with autostart")
    finished_ms: int = Field(default=57, ge=0, description="entry 8003, without autostart")
    finished_autostart_ms: int = Field(default=98, ge=0, description="entry 8003, with it")
    ring_wait_ms: int = Field(default=3_000, ge=0, description="how long an open ring is waited for")
    clock_starts: Literal["ring", "power_on"] = Field(
        default="ring", description="stamps count from when the ring is up (or given up), or from power-on"
    )


class IdentitySettings(Settings):
    """What a service report asks for (manual 7739-7751), beside the version."""

    article_number: str = Field(default="13130241-001", max_length=32)
    serial_number: str = Field(default="0000000001", max_length=32)
    hardware_code: str = Field(default="01.00.00", max_length=32)


class ProcessTimes(Settings):
    """What the real-time process takes of each cycle."""

    base_us: int = Field(default=60, ge=0, description="in any case")
    axis_us: int = Field(default=12, ge=0, description="for each axis")


def _known_version(text: str) -> str:
    version_of(text)
    return text


def _classes(classes: dict[int, int]) -> dict[int, int]:
    for code, number in classes.items():
        if not 1 <= number <= 8:
            raise ValueError(f"class {number} of {code}: right would be 1 to 8")
    return classes


class Max4Settings(Settings):
    project: Annotated[str, Field(pattern=r"^[A-Z][A-Z0-9]{0,7}$")] = Field(
        default="TEST", description="names the configuration and the parameter file"
    )
    version: Annotated[str, AfterValidator(_known_version)] = Field(
        default="V00.15.00", description="of the controller's software"
    )
    identity: IdentitySettings = Field(default_factory=IdentitySettings, description="what its type plate says")
    cycle_ms: Literal[1, 2, 4] = Field(default=4, description="of the ring: parameter CycleTime")
    drives: dict[Symbol, DriveSettings] = Field(default_factory=dict, description="axes by symbolic name")
    max_axes: int = Field(default=40, ge=1, le=MOST_AXES, description="the manual says 40, 44 and 47")
    missing_drive: Literal["leave_out", "stop"] = Field(
        default="leave_out", description="one that doesn't answer: the ring comes up without it, or not at all"
    )
    logic_encoders: list[Symbol] = Field(default_factory=list, description="by symbolic name")
    master_encoders: Wires = Field(default_factory=dict, description="wires that they count, by symbolic name")
    inputs: Wires = Field(default_factory=dict, description="wires of digital inputs, by symbolic name")
    outputs: Wires = Field(default_factory=dict, description="wires of digital outputs")
    measuring_inputs: Wires = Field(default_factory=dict, description="wires of touch probe inputs")
    err_wire: str = Field(default="", description="out: true while the err LED flashes")
    parameters: dict[str, bool | int | float | str] = Field(
        default_factory=dict, description="start values by path: MAx-4.General.MsgFilter: 0xFFFF"
    )
    program: ConfigFile | None = Field(default=None, description="what lies in DEFAULT.PRG")
    autostart: bool = Field(default=False, description="the stored program starts with the boot")
    language: Literal["de", "en"] = Field(default="de", description="of messages")
    diagnosis_classes: Annotated[dict[int, int], AfterValidator(_classes)] = Field(
        default_factory=dict, description="of codes that are to have another than their first digit"
    )
    modbus: ModbusFaceSettings = Field(
        default_factory=ModbusFaceSettings, description="as Modbus server, on the buses under links.modbus"
    )
    modbus_client: ModbusClientSettings | None = Field(default=None, description="as Modbus client, on one of them")
    can_master: CanMasterSettings | None = Field(default=None, description="as CANopen master, on links.can")
    can_axes: CanFaceSettings | None = Field(
        default=None, description="as CANopen slave on links.can: its axes as CiA 402 axes"
    )
    io_map_ms: int = Field(default=10, ge=1, le=1000, description="period of the IO map update: data of field buses")
    boot: BootTimes = Field(default_factory=BootTimes, description="instants of a boot")
    load: ProcessTimes = Field(default_factory=ProcessTimes, description="load by the real-time process")
    retain: RetainKind = Field(
        default="nvram", description="retain data: 1 kB of its own, 64 kB on the flash disk by a UPS, 101 kB of a PN-4"
    )
    retain_battery: bool = Field(default=False, description="of the PN-4: it keeps them for more than 7 days")
    off_days: float = Field(default=0.0, ge=0, description="without power before the rig's start")
    disk_bytes: int = Field(default=4_000_000, ge=65_536, description="size of the flash disk")
    memory_free_bytes: int = Field(default=6_930_636, ge=0, description="parameter Memoryfree")

    def claims(self, device: str) -> Iterator[Claim]:
        """`master of node-ID`: a node answers one master only."""
        yield Claim("ring", MASTER, "of the ring", ())
        yield Claim("modbus", "unit", self.modbus.unit_id, ("modbus", "unit_id"))
        if self.can_axes is not None:
            for place, node_id in enumerate(self.can_axes.node_ids):
                yield Claim("can", "node-ID", node_id, ("can_axes", "node_ids", place))
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
        )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if len(self.drives) > self.max_axes:
            raise ValueError(f"{len(self.drives)} drives, but max_axes is {self.max_axes}")
        configuration = self.configuration  # its own checks
        if self.retain_battery and self.retain != "pn4":
            raise ValueError("retain_battery is of the PN-4 module: right beside it would be retain: pn4")
        if unknown := sorted(self.modbus.units.keys() - self.drives.keys()):
            raise ValueError(f"modbus.units: {', '.join(unknown)}: names of drives would be right")
        modules = [*(self.modbus_client.units if self.modbus_client is not None else ())]
        modules += self.can_master.nodes if self.can_master is not None else ()
        seen = {symbol.casefold() for symbol in configuration.symbols}
        for symbol in modules:
            if symbol.casefold() in seen:
                raise ValueError(f"symbolic name {symbol}: there are two of it")
            seen.add(symbol.casefold())
        return self
