"""The faults that an MC-4 drive and its motor take.  `causes.py` and `machine.py` say what each of them does."""

from typing import Annotated, Any, Final, Literal

from pydantic import Field

from fieldrig.faults.faults import Fault, Timed, models_of
from fieldrig.faults.injected import InjectedFaults


class EnableLost(Timed):
    """The input Inverter Enable is open."""

    what: Literal["enable_lost"]


class Overtemperature(Timed):
    """The thermo contact of the motor opens, or the heat sink is too hot."""

    what: Literal["overtemperature"]
    of: Literal["motor", "amplifier"] = "motor"


class Overload(Timed):
    """The overload model demands switching off."""

    what: Literal["overload"]


class DcBus(Timed):
    """The DC circuit, its supply or its controller fails."""

    what: Literal["dc_bus"]
    sort: Literal["communication", "undervoltage", "overvoltage", "phase"] = Field(
        default="communication",
        description="what fails: its controller's communication, the voltage, or a mains phase",
    )


class EncoderMemory(Timed):
    """The name plate in the encoder cannot be read."""

    what: Literal["encoder_memory"]


class EncoderSignal(Timed):
    """The sine and cosine signals are missing."""

    what: Literal["encoder_signal"]


class WrongMotor(Timed):
    """Another motor is connected, with a name plate that this drive cannot use."""

    what: Literal["wrong_motor"]


class StuckBrake(Timed):
    """The holding brake stays on, or off, regardless of its relay."""

    what: Literal["stuck_brake"]
    stays: Literal["on", "off"] = "on"


class Supply24V(Timed):
    """The external 24 V supply is too low."""

    what: Literal["supply_24v"]


DriveFault = Annotated[
    EnableLost
    | Overtemperature
    | Overload
    | DcBus
    | EncoderMemory
    | EncoderSignal
    | WrongMotor
    | StuckBrake
    | Supply24V,
    Field(discriminator="what"),
]
MODELS: Final = models_of(DriveFault)
DriveFaults = InjectedFaults[Fault[Any]]
