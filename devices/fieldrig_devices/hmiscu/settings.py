"""Settings of an HMISCU in a rig file."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Final, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from fieldrig.settings import Claim, ConfigFile, Settings, WrongKey, refuse_all
from fieldrig_devices.canopen.described import DescribedNode
from fieldrig_devices.canopen.master_settings import CanMasterSettings
from fieldrig_devices.canopen.point_slave import PointSlaveSettings
from fieldrig_devices.hmiscu.channels import Channels
from fieldrig_devices.hmiscu.faces.modbus import BLOCKS, ModbusFaceSettings
from fieldrig_devices.hmiscu.faces.objects import EDS, points_by_object
from fieldrig_devices.hmiscu.models import FAST_OUTPUTS, MODELS, Kind, Model, ModelName
from fieldrig_devices.iec.costs import Costs
from fieldrig_devices.modbus.client_settings import ModbusClientSettings
from fieldrig_devices.pulses.output import Mode
from fieldrig_devices.registers.described import DescribedUnit

ANALOG: Final[frozenset[Kind]] = frozenset({"analog input", "temperature input", "analog output"})
INPUTS: Final[frozenset[Kind]] = frozenset({"digital input", "analog input", "temperature input"})
MOST_RAW: Final = 4_095
"""Largest raw value of an analog terminal, which has 12 bits."""
Terminal = Annotated[str, Field(pattern=r"^[A-Z]{2}[0-9]{1,2}$", examples=["DI0"])]
PWM_INPUTS: Final = {"enable_0": "DI0", "sync_0": "DI1", "enable_1": "DI3", "sync_1": "DI4"}
"""Inputs IN_EN and IN_SYNC of the channels, for which the manual gives no numbers (digest 13)."""
PwmInput = Literal["enable_0", "sync_0", "enable_1", "sync_1"]


class AnalogWire(Settings):
    """The wire of an analog terminal, and the values at both ends of its range."""

    wire: str = Field(min_length=1, description="name of the wire")
    unit: str = Field(default="", description="unit of the signal")
    low: float = Field(default=0.0, description="value of the signal at raw 0; temperature inputs do not use it")
    high: float = Field(
        default=10.0, description=f"value of the signal at raw {MOST_RAW}; temperature inputs do not use it"
    )

    @model_validator(mode="after")
    def _has_a_range(self) -> Self:
        if self.low == self.high:
            raise ValueError(f"high: expected another value than low, which is {self.low}")
        return self


class MastSettings(Settings):
    """The task that copies the inputs, runs the blocks and the program, and writes the outputs."""

    cycle_ms: int = Field(
        default=10, ge=1, le=1_000, description="interval; a program with a task configuration has its own"
    )
    watchdog_ms: int = Field(
        default=100,
        ge=0,
        le=60_000,
        description="longest processor time of a cycle, which stops the controller; 0: none",
    )


def _as_list(value: Any) -> Any:
    return [value] if isinstance(value, str | Path) else value


class HmiscuSettings(Channels):
    """Settings of the controller."""

    model: ModelName = Field(default="HMISCU6A5", description="model, which determines the terminals and the display")
    pwm_inputs: dict[PwmInput, Terminal] = Field(
        default_factory=dict,
        description="terminals of the PWM inputs; default: DI0 and DI1 for channel 0, DI3 and DI4 for channel 1",
    )
    fast_signals: Mode = Field(
        default="segments", description="pulses and PWM on the wires: segments, or each edge, which costs much more"
    )
    terminals: dict[Terminal, str | AnalogWire] = Field(
        default_factory=dict,
        description="wires by terminal: DI0, DQ3, FQ0; analog terminals AI0, TI0 and AQ0 with unit and range",
    )
    mast: MastSettings = Field(default_factory=MastSettings, description="the task MAST")
    program: Annotated[list[ConfigFile], BeforeValidator(_as_list, json_schema_input_type=str | list[str])] = Field(
        default_factory=list,
        description="sources of the IEC program, a file or a list; without one, masters work the blocks directly",
    )
    dialect: Literal["epas-4", "edition-3", "codesys"] = Field(
        default="edition-3", description="rules of the language: IEC 61131-3 edition 3, EPAS-4, or CODESYS and TwinCAT"
    )
    resource: str = Field(
        default="", description="name of the RESOURCE that runs, if the configuration of the program has several"
    )
    costs: Costs = Field(default_factory=Costs, description="processor time of the operations of a program")
    modbus: ModbusFaceSettings = Field(
        default_factory=ModbusFaceSettings, description="Modbus server on the buses under links.modbus"
    )
    can_slave: PointSlaveSettings | None = Field(default=None, description="CiA 401 slave on links.can")
    modbus_client: ModbusClientSettings | None = Field(
        default=None, description="Modbus client on one of these buses, whose values are points"
    )
    can_master: CanMasterSettings | None = Field(
        default=None, description="CANopen master on links.can, whose values are points"
    )
    autostart: bool = Field(default=True, description="whether the program runs from power-on")

    @property
    def kinds(self) -> Mapping[str, Kind]:
        """The kind of each terminal of the model, in the order of the image."""
        return dict(self._model.terminals())

    @property
    def _model(self) -> Model:
        return MODELS[self.model]

    @property
    def dedicated(self) -> frozenset[str]:
        """The fast outputs that a channel has, which only its block reaches (SCU-075)."""
        if self.channel_0.mode == "pto":
            return frozenset(FAST_OUTPUTS)
        modes = (self.channel_0.mode, self.channel_1.mode)
        return frozenset(output for output, mode in zip(FAST_OUTPUTS, modes, strict=True) if mode == "pwm")

    def pwm_input(self, which: PwmInput) -> str:
        """The terminal of an input of a PWM channel."""
        return self.pwm_inputs.get(which, PWM_INPUTS[which])

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        refuse_all(self._wrong_keys())
        return self

    def _wrong_keys(self) -> Iterator[WrongKey]:
        yield from self._wrong_terminals()
        for which, terminal in self.pwm_inputs.items():
            if not terminal.startswith("DI") or terminal not in self.kinds:
                remedy = "expected DI0 and so on"
                yield WrongKey(("pwm_inputs", which), f"{terminal} is not a normal input of {self.model}", remedy)

    def _wrong_terminals(self) -> Iterator[WrongKey]:
        kinds = self.kinds
        for terminal, wire in self.terminals.items():
            kind = kinds.get(terminal)
            if kind is None:
                yield WrongKey(("terminals", terminal), f"{self.model} has no terminal {terminal}", _known(kinds))
            elif kind in ANALOG and isinstance(wire, str):
                yield WrongKey(("terminals", terminal), f"{terminal} is an {kind}", "expected wire, unit, low and high")
            elif kind not in ANALOG and not isinstance(wire, str):
                yield WrongKey(("terminals", terminal), f"{terminal} is a {kind}", "expected the name of a wire")

    def wire_of(self, terminal: str) -> str:
        """Return the wire of a terminal; an empty text if it has none."""
        wired = self.terminals.get(terminal, "")
        return wired if isinstance(wired, str) else wired.wire

    def canopen_nodes(self) -> Iterator[DescribedNode]:
        if self.can_slave is not None:
            yield self.can_slave.described(EDS, points_by_object())

    def register_tables(self) -> Iterator[DescribedUnit]:
        yield DescribedUnit(self.modbus.unit_id, self.modbus.table or BLOCKS)

    def claims(self, device: str) -> Iterator[Claim]:
        yield Claim("modbus", "unit", self.modbus.unit_id, ("modbus", "unit_id"))
        if self.can_slave is not None:
            yield Claim("can", "node-ID", self.can_slave.node_id, ("can_slave", "node_id"))
        if self.can_master is not None:
            yield Claim("can", "node-ID", self.can_master.node_id, ("can_master", "node_id"))
            for name, node in self.can_master.nodes.items():
                yield Claim("can", "master of node-ID", node.node_id, ("can_master", "nodes", name, "node_id"))
        kinds = self.kinds
        for terminal in self.terminals:
            if kinds[terminal] not in INPUTS:
                yield Claim("wires", "wire", self.wire_of(terminal), ("terminals", terminal))

    def needs(self, device: str) -> Iterator[Claim]:
        if self.modbus_client is not None:
            for name, unit in self.modbus_client.units.items():
                path = ("modbus_client", "units", name, "unit")
                yield Claim("modbus", "unit", unit.unit, path, self.modbus_client.link - 1)


def _known(kinds: Mapping[str, Kind]) -> str:
    return f"expected one of {', '.join(kinds)}"
