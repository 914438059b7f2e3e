"""The faults that an ST1 takes; `status.py` has the bits that each of them sets (table 12-1)."""

from typing import Annotated, Any, Final, Literal

from pydantic import Field

from fieldrig.faults.faults import Fault, Timed, models_of
from fieldrig.faults.injected import InjectedFaults


class PowerStage(Timed):
    """The power stage is disabled."""

    what: Literal["power_stage"]


class Resolver(Timed):
    """The resolver fails."""

    what: Literal["resolver"]


class OverVoltage(Timed):
    """The voltage UA is too high."""

    what: Literal["over_voltage"]


class Overload(Timed):
    """The power stage is overloaded."""

    what: Literal["overload"]


class Supply(Timed):
    """The internal or the auxiliary supply fails."""

    what: Literal["supply"]
    of: Literal["internal", "auxiliary"] = "internal"


class MotorTemperature(Timed):
    """The motor reports over-temperature."""

    what: Literal["motor_temperature"]


class Jam(Timed):
    """The shaft is blocked."""

    what: Literal["jam"]


class ServoReset(Timed):
    """The servo processor resets itself when the fault begins, and reports that the reset is over."""

    what: Literal["servo_reset"]


St1Fault = Annotated[
    PowerStage | Resolver | OverVoltage | Overload | Supply | MotorTemperature | Jam | ServoReset,
    Field(discriminator="what"),
]
MODELS: Final = models_of(St1Fault)
St1Faults = InjectedFaults[Fault[Any]]
