"""The keys and the faults of a stepper in a rig file."""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Annotated, Any, Final, Literal, Self

from pydantic import Field, model_validator

from fieldrig.faults.faults import Timed, models_of
from fieldrig.settings import Claim
from fieldrig_bus.signals.pulse_train import FASTEST_HZ
from fieldrig_devices.plants.settings import PlantSettings

MOST_POINTS: Final = 100


class StepperSettings(PlantSettings):
    mode: Literal["pulse_direction", "cw_ccw"] = Field(
        default="pulse_direction",
        description="one input for pulses and one for the direction, or one for each direction",
    )
    pulse_wire: str = Field(description="input: pulses; in the mode cw_ccw those clockwise, which is forwards")
    direction_wire: str | None = Field(
        default=None, description="input: true is forwards; needed for single edges, as a pulse train has its direction"
    )
    ccw_wire: str | None = Field(default=None, description="input of the mode cw_ccw: pulses counter-clockwise")
    pulses_per_turn: int = Field(
        default=200, ge=1, le=10_000_000, description="steps of a turn of the motor, times the microsteps"
    )
    reversed: bool = Field(default=False, description="forward pulses turn the load backwards")
    gear_ratio: float = Field(default=1.0, gt=0, description="turns of the motor for one of the load")
    pull_out: list[tuple[float, float]] = Field(
        min_length=1,
        max_length=MOST_POINTS,
        description="pairs of a speed of the motor in turns/s and its largest torque in N m there; linear between them",
    )
    start_hz: float = Field(
        default=500.0,
        gt=0,
        description="largest jump of the pulse frequency that the motor follows, from standstill too",
    )
    highest_hz: float = Field(
        default=200_000.0, gt=0, le=FASTEST_HZ, description="highest frequency of the drive's input"
    )
    motor_inertia_kg_m2: float = Field(gt=0)
    load_inertia_kg_m2: float = Field(default=0.0, ge=0, description="inertia of the load, behind the gear")
    coulomb_nm: float = Field(default=0.0, ge=0, description="dry friction at the motor")
    load_torque_nm: float = Field(
        default=0.0, description="constant torque at the load, for example of a weight; positive pulls it down"
    )
    detects_loss: bool = Field(
        default=True, description="the drive sees that the motor is out of step, and gives an alarm; else it goes on"
    )
    enable_wire: str | None = Field(
        default=None, description="input: the drive works while it is true; default: always"
    )
    reset_wire: str | None = Field(
        default=None, description="input: a rising edge clears the alarm; default: NAME.reset"
    )
    load_torque_wire: str | None = Field(default=None, description="input: further torque; default: NAME.load_torque")
    position_wire: str | None = Field(default=None, description="output: of the load, rad; default: NAME.position")
    ready_wire: str | None = Field(default=None, description="output: the ready contact; default: NAME.ready")
    alarm_wire: str | None = Field(default=None, description="output: default: NAME.alarm")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if (self.mode == "cw_ccw") != (self.ccw_wire is not None):
            raise ValueError("ccw_wire: expected with the mode cw_ccw, and only with it")
        if self.mode == "cw_ccw" and self.direction_wire is not None:
            raise ValueError("direction_wire: expected only with the mode pulse_direction")
        if any(not speed >= 0 <= torque for speed, torque in self.pull_out):
            raise ValueError("pull_out: expected speeds and torques of at least 0")
        if any(not (low[0] < high[0] and low[1] >= high[1]) for low, high in pairwise(self.pull_out)):
            raise ValueError("pull_out: expected speeds that rise and torques that do not")
        return self

    @property
    def inertia_kg_m2(self) -> float:
        """Inertia at the shaft of the motor."""
        return self.motor_inertia_kg_m2 + self.load_inertia_kg_m2 / self.gear_ratio**2

    def outputs(self, device: str) -> dict[str, str]:
        """Return the wires that the drive drives, by their keys."""
        return {
            "position_wire": self.wire_for(device, "position"),
            "ready_wire": self.wire_for(device, "ready"),
            "alarm_wire": self.wire_for(device, "alarm"),
        }

    def claims(self, device: str) -> Iterator[Claim]:
        for key, wire in self.outputs(device).items():
            yield Claim("wires", "wire", wire, (key,))


class Jam(Timed):
    """The rotor is blocked, so that every pulse is lost."""

    what: Literal["jam"]


class Weak(Timed):
    """The motor has less torque than its curve says."""

    what: Literal["weak"]
    percent: float = Field(default=50.0, ge=0, lt=100, description="torque that is left")


class Trip(Timed):
    """The drive gives an alarm when the fault begins, for a reason of its own."""

    what: Literal["trip"]


StepperFault = Annotated[Jam | Weak | Trip, Field(discriminator="what")]
MODELS: Final[Mapping[str, type[Any]]] = models_of(StepperFault)
