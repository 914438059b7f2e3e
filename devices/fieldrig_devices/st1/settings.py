"""The keys of an ST1 in a rig file."""

from collections.abc import Iterator
from math import tau
from typing import Literal, Self

from pydantic import ConfigDict, Field, model_validator

from fieldrig.settings import Claim, Settings
from fieldrig_devices.st1.faults import St1Fault
from fieldrig_devices.st1.readings import St1Readings

INPUTS = (0, 1, *range(16, 32))
"""IN 0 and 1 of the LPO board, IN 16 to 31 of the OIO board (PAMS-110)."""
OUTPUTS = tuple(range(8, 16))
TERMINALS = (*(f"IN{number}" for number in INPUTS), *(f"OUT{number}" for number in OUTPUTS))
WIRES_IN = ("enable", "load_torque", "motor_temperature", "supply", "auxiliary", "analog", "second", "incremental")
"""Inputs besides the terminals."""


class ParameterSettings(Settings):
    """The ST1's own parameters.  Lengths are turns of the motor."""

    model_config = ConfigDict(allow_inf_nan=False)

    ckv: float = Field(default=50.0, gt=0, le=10_000, description="CKV, largest speed, turns/s")
    cka: float = Field(default=1000.0, gt=0, le=1e6, description="CKA, largest acceleration, turns/s2")
    astop: float = Field(
        default=500.0, gt=0, le=1e6, description="ASTOP, deceleration of a stop without DECELERATION, turns/s2"
    )
    ckr: int = Field(default=0, ge=-32_768, le=65_535, description="CKR; grouped axes have the same")
    ckh: int = Field(default=0, ge=-32_768, le=65_535, description="CKH; grouped axes have the same")
    equip: int = Field(default=0, ge=0, le=65_535, description="EQUIP, equipment; grouped axes have the same")
    phil1: float | None = Field(default=None, description="PHIL1, lower limit of the position, turns; default: none")
    phil2: float | None = Field(default=None, description="PHIL2, upper limit of the position, turns; default: none")
    cacout: int = Field(
        default=0xFF, ge=0, le=0xFF, description="CACOUT, active levels of OUT 15 to OUT 8, one bit each, 1 is high"
    )
    cactin: int = Field(default=0xFFFF, ge=0, le=0xFFFF, description="CACTIN, active levels of IN 31 to IN 16")
    cvalin: int = Field(default=0, ge=0, le=0xFFFF, description="CVALIN, inputs that local actions of the ST1 use")
    cmasks: int = Field(default=0xFFFF, ge=0, le=0xFFFF, description="CMASKS, bits of C and D in the error word")
    cmasku: int = Field(
        default=0x1000, ge=0, le=0xFFFF, description="CMASKU; bit 12 reports a ring fault, from firmware 590 on"
    )

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.phil1 is not None and self.phil2 is not None and self.phil1 >= self.phil2:
            raise ValueError("phil2 must be above phil1")
        return self


class MotorSettings(Settings):
    """The motor with all that it turns, as the motor feels it."""

    model_config = ConfigDict(allow_inf_nan=False)

    largest_torque_nm: float = Field(default=20.0, gt=0, description="at the current limit of the ST1")
    inertia_kg_m2: float = Field(default=0.002, gt=0, description="of motor and load")
    friction_nm: float = Field(default=0.5, gt=0, description="dry friction, which stops a motor without power")
    gear_ratio: float = Field(default=1.0, gt=0, description="turns of the motor for one of the load")
    temperature_limit_degc: float = Field(default=120.0, description="MOTOR_TEMPERATURE above it")

    @property
    def most_turns_per_s2(self) -> float:
        return (self.largest_torque_nm - self.friction_nm) / self.inertia_kg_m2 / tau


class PlantSettings(Settings):
    """A motor that a plant models, such as `plant.servo`, instead of the ST1's own."""

    model_config = ConfigDict(allow_inf_nan=False)

    reference_wire: str | None = Field(
        default=None, description="output: torque, largest_torque_nm at 10 V; default: NAME.reference"
    )
    encoder_wire: str = Field(min_length=1, description="input: motion of the motor's encoder in counts")
    counts_per_turn: float = Field(default=4000.0, gt=0, description="counts for a turn of the motor")
    bandwidth_hz: float = Field(default=15.0, gt=0, le=50, description="of the position loop")


class SupplySettings(Settings):
    """The limits of the supply UA that the wire `supply` carries."""

    model_config = ConfigDict(allow_inf_nan=False)

    highest_v: float = Field(default=400.0, gt=0, description="OVER_VOLTAGE above it")
    lowest_v: float = Field(default=0.0, ge=0, description="INT_SUPPLY_FAILURE below it")


class RegisterSettings(Settings):
    """A further variable or parameter that an encoder of the PAM may read."""

    value: int = Field(ge=-(1 << 31), lt=1 << 32, description="until a point or a wire sets another value")
    wire: str | None = Field(default=None, min_length=1, description="input that sets the value, times `scale`")
    scale: float = Field(default=1.0, allow_inf_nan=False, description="units of the register for one of the wire")


class St1Settings(Settings):
    """The keys of an ST1."""

    model_config = ConfigDict(allow_inf_nan=False)

    ring_address: int = Field(ge=1, le=255, description="ADDRESS of the node, by the switches; unique on the ring")
    ring_inactive_ms: int = Field(
        default=50, ge=2, le=10_000, description="time without cycles after which the node counts the ring as inactive"
    )
    firmware: int = Field(default=590, ge=0, le=9999, description="version, V0590 as 590")
    oio_board: bool = Field(default=True, description="the OIO board with IN 16 to 31 and OUT 8 to 15 is plugged in")
    parameters: ParameterSettings = Field(default_factory=ParameterSettings)
    motor: MotorSettings = Field(default_factory=MotorSettings)
    plant: PlantSettings | None = Field(default=None, description="a motor on wires; default: the ST1's own")
    supply: SupplySettings = Field(default_factory=SupplySettings)
    readings: St1Readings = Field(
        default_factory=St1Readings, description="readings of the PAM's manual where it is silent or unclear"
    )
    lag_limit_turns: float = Field(default=1.0, gt=0, description="SERVO_LAG_ERROR above it")
    on_ring_fault: Literal["stop_and_power_off", "stop"] = Field(
        default="stop_and_power_off", description="after a break of the ring the axis stops with ASTOP"
    )
    initial_turns: float = Field(default=0.0, ge=-32_768, lt=32_768, description="position of the motor at the start")
    position_tolerance: float = Field(
        default=1e-4, gt=0, description="rad: largest error of the extrapolated position before it is published again"
    )
    variables: dict[int, RegisterSettings] = Field(default_factory=dict, description="by code, 27 to 255")
    further_parameters: dict[int, RegisterSettings] = Field(default_factory=dict, description="by code, 27 to 255")
    terminals: dict[str, str] = Field(
        default_factory=dict, description="wires by terminal: IN0, IN16, OUT8; default: NAME.IN0 and so on"
    )
    enable: bool = Field(default=True, description="state of the input `enable` until its wire is driven")
    enable_wire: str | None = Field(default=None, description="default: NAME.enable, and so on for the others")
    load_torque_wire: str | None = None
    motor_temperature_wire: str | None = None
    supply_wire: str | None = None
    auxiliary_wire: str | None = None
    analog_wire: str | None = None
    second_wire: str | None = None
    incremental_wire: str | None = None
    position_wire: str | None = None
    faults: list[St1Fault] = Field(default=[], description="faults that the ST1 has from the start")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        wrong = sorted(set(self.terminals) - set(TERMINALS))
        if wrong:
            raise ValueError(f"there is no terminal {wrong[0]}; expected IN0, IN1, IN16 to IN31 or OUT8 to OUT15")
        for codes in (self.variables, self.further_parameters):
            if any(not 27 <= code <= 255 for code in codes):
                raise ValueError("a register's code is out of range; expected 27 to 255")
        if self.parameters.cka > self.motor.most_turns_per_s2:
            raise ValueError(
                f"cka is more than the motor's torque gives; expected up to {self.motor.most_turns_per_s2:g} turns/s2"
            )
        return self

    def claims(self, device: str) -> Iterator[Claim]:
        yield Claim("ring", "ring address", self.ring_address, ("ring_address",))
        if self.plant is None:
            yield Claim("wires", "wire", self.wire_for(device, "position"), ("position_wire",))
        else:
            yield Claim("wires", "wire", self.reference_wire(device), ("plant", "reference_wire"))
        for number in OUTPUTS if self.oio_board else ():
            terminal = f"OUT{number}"
            yield Claim("wires", "wire", self.terminal(device, terminal), ("terminals", terminal))

    def reference_wire(self, device: str) -> str:
        own = None if self.plant is None else self.plant.reference_wire
        return own or f"{device}.reference"

    def terminal(self, device: str, terminal: str) -> str:
        return self.terminals.get(terminal) or f"{device}.{terminal}"
