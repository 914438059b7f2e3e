"""Settings of a Smart-IO node in a rig file."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Final, Literal, Self

from pydantic import Field, model_validator

from fieldrig.settings import Claim, Settings, WrongKey, refuse_all
from fieldrig_bus.modbus.identification import Identification
from fieldrig_devices.canopen.described import DescribedNode
from fieldrig_devices.canopen.point_slave import PointSlaveSettings
from fieldrig_devices.modbus.point_server import PointServerSettings
from fieldrig_devices.registers.described import DescribedUnit
from fieldrig_devices.smart_io.addresses import MODULES, exists, place_of
from fieldrig_devices.smart_io.heap import HEAP_BYTES
from fieldrig_devices.smart_io.terminals import INPUTS


class NodeReadings(Settings):
    """Passages of the manual about the node that can be read in two ways, and facts of a machine that it leaves out.

    The defaults are the likelier readings.
    """

    autorepeat: Literal["gaps", "pulses"] = Field(
        default="gaps",
        description="value of a pressed AUTOREPEAT key: true with a gap of one PERIOD before each repetition, or a "
        "pulse of one PERIOD for the press and for each repetition",
    )
    time_stamps: bool = Field(
        default=True, description="whether reports of binary inputs say how long ago the level changed"
    )
    counts: Literal["direction", "up"] = Field(
        default="direction", description="pulses of a DC motor in its COUNTER_INPUT: down with DEC, or always up"
    )
    zero_at: Literal["edge", "rest"] = Field(
        default="edge", description="place of position 0 after zero_position: at the edge of ZERO, or at rest behind it"
    )
    stray_pulses: int | None = Field(
        default=None,
        ge=0,
        le=1_000_000,
        description="pulses of a DC motor at rest with which its position is not lost yet; by default BRAKING",
    )
    font: dict[
        Annotated[str, Field(min_length=1, max_length=1)],
        Annotated[str, Field(pattern="^[a-gp]*$", examples=["abdeg"])],
    ] = Field(default_factory=dict, description="segments of characters that differ from the font, such as {z: abdeg}")


MOST_KEYS: Final = 32
"""Keys, and LEDs, of a keyboard at most (G-05)."""
MOST_MOTORS: Final = 8
Terminal = Annotated[str, Field(pattern=r"^(in|out|key|led|analog)[0-9]{1,4}$", examples=["in101"])]
Place = Annotated[int, Field(ge=101, le=1612)]


class SmartIoServerSettings(PointServerSettings):
    """Settings of the Modbus server."""

    identification: Identification = Field(
        default_factory=lambda: Identification(product_code="006.7018", product_name="Smart-IO"),
        description="response to function 43/14",
    )


class ModuleSettings(Settings):
    """The scan of the inputs of one module while the node works alone; a PAM gives each input its own."""

    period_ms: int = Field(default=1, ge=1, le=1_000, description="time from one sample of the inputs to the next")
    debounce: int = Field(default=1, ge=1, le=1_000, description="equal samples after which a new level is accepted")


class MotorSettings(Settings):
    """A DC motor that the node moves while it works alone; a PAM configures its own."""

    increase: Place = Field(description="address of the output INC")
    decrease: Place = Field(description="address of the output DEC")
    zero: Place = Field(description="address of the input ZERO")
    counter: Place = Field(description="address of the input with the pulses")
    timeout_ms: int = Field(default=500, ge=1, le=1_000_000, description="longest time without a pulse while driven")
    braking: int = Field(default=0, ge=0, le=1_000_000, description="pulses before the target at which it is off")


class SmartIoSettings(Settings):
    """Settings of the node."""

    ring_address: int | None = Field(
        default=None, ge=1, le=255, description="ADDRESS of the node, by its switches; required with links.ring"
    )
    ring_inactive_ms: int = Field(
        default=50, ge=2, le=10_000, description="time without cycles after which the node counts the ring as inactive"
    )
    modules: dict[Annotated[int, Field(ge=1, le=MODULES)], ModuleSettings] = Field(
        default_factory=lambda: {1: ModuleSettings()}, description="I/O cards by module number, 1 to 16"
    )
    keyboard: Literal["006.7012", "006.7010", "none"] = Field(
        default="006.7012", description="keyboard card: keys and LEDs with a display, without one, or no card"
    )
    key_count: int = Field(default=24, ge=0, le=MOST_KEYS, description="keys of the keyboard, key1 and so on")
    led_count: int = Field(default=24, ge=0, le=MOST_KEYS, description="LEDs of the keyboard, led1 and so on")
    terminals: dict[Terminal, str] = Field(
        default_factory=dict, description="wires by terminal: in101, out212, key12, led6, analog1 (V)"
    )
    motors: list[MotorSettings] = Field(
        default_factory=list, max_length=MOST_MOTORS, description="DC motors of a node that works alone, motor1 first"
    )
    motor_rest_ms: int = Field(
        default=100, ge=1, le=60_000, description="a DC motor counts as stopped when no pulse has come for this long"
    )
    outputs_without_ring: Literal["inactive", "hold"] = Field(
        default="inactive", description="outputs when the ring is silent; DC motors stop in any case"
    )
    readings: NodeReadings = Field(
        default_factory=NodeReadings, description="readings of the PAM's manual where it is silent or unclear"
    )
    heap_bytes: int = Field(default=HEAP_BYTES, ge=256, le=1 << 20, description="memory for the items of a PAM")
    can_slave: PointSlaveSettings | None = Field(default=None, description="CiA 401 slave on links.can")
    modbus: SmartIoServerSettings = Field(
        default_factory=SmartIoServerSettings, description="Modbus server on the buses under links.modbus"
    )

    @property
    def keys(self) -> range:
        """The numbers of the keys."""
        return range(1, 1 + (0 if self.keyboard == "none" else self.key_count))

    @property
    def leds(self) -> range:
        return range(1, 1 + (0 if self.keyboard == "none" else self.led_count))

    def has(self, terminal: str) -> bool:
        """True if the node has this terminal."""
        letters, number = terminal.rstrip("0123456789"), int(terminal.lstrip("abcdefghijklmnopqrstuvwxyz"))
        if letters in ("in", "out"):
            return exists(number) and place_of(number)[0] in self.modules
        return number in {"key": self.keys, "led": self.leds, "analog": range(1, 2)}[letters]

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        refuse_all(self._wrong_keys())
        return self

    def _wrong_keys(self) -> Iterator[WrongKey]:
        fitted = ", ".join(map(str, sorted(self.modules)))
        remedy = (
            f"expected positions 1 to 12 of the modules {fitted}, such as in{100 * min(self.modules, default=1) + 1}"
        )
        for terminal in self.terminals:
            if not self.has(terminal):
                yield WrongKey(
                    ("terminals", terminal), f"there is no terminal {terminal}", f"{remedy}; key, led, analog1"
                )
        for number, motor in enumerate(self.motors):
            for key in ("increase", "decrease", "zero", "counter"):
                address = getattr(motor, key)
                if not self.has(f"in{address}"):
                    yield WrongKey(("motors", number, key), f"there is no address {address}", remedy)
            if motor.increase == motor.decrease:
                yield WrongKey(("motors", number, "decrease"), "both outputs are the same", "expected another address")

    def canopen_nodes(self) -> Iterator[DescribedNode]:
        if self.can_slave is not None:
            yield self.can_slave.described(Path(__file__).parent / "faces" / "smart_io.eds", {})

    def register_tables(self) -> Iterator[DescribedUnit]:
        if self.modbus.table is not None:
            yield DescribedUnit(self.modbus.unit_id, self.modbus.table)

    def claims(self, device: str) -> Iterator[Claim]:
        if self.ring_address is not None:
            yield Claim("ring", "ring address", self.ring_address, ("ring_address",))
        yield Claim("modbus", "unit", self.modbus.unit_id, ("modbus", "unit_id"))
        if self.can_slave is not None:
            yield Claim("can", "node-ID", self.can_slave.node_id, ("can_slave", "node_id"))
        for terminal, wire in self.terminals.items():
            if not terminal.startswith(INPUTS):
                yield Claim("wires", "wire", wire, ("terminals", terminal))
