"""The faults that a single drive takes, and the error code (603Fh) of each that is an error of the drive.

Source: CiA 402-2 and IEC 61800-7-201, annex 'error codes'.
"""

from collections.abc import Iterator
from typing import Annotated, Any, Final, Literal, NamedTuple

from pydantic import Field

from fieldrig.faults.faults import Fault, Timed, models_of
from fieldrig.faults.hex_bytes import Hex
from fieldrig.faults.injected import InjectedFaults
from fieldrig_devices.canopen.emergencies import MOST_INFO
from fieldrig_devices.canopen.node_faults import NodeFault


class DriveError(Timed):
    """The drive has an error with this code, until it is cleared and reset."""

    what: Literal["error"]
    code: int = Field(default=0x1000, ge=1, le=0xFFFF, description="error code in 603Fh and in the EMCY")
    coasts: bool = Field(default=False, description="the torque is off at once; otherwise 605Eh says how it stops")
    error_register: int | None = Field(
        default=None, ge=0, le=0xFF, description="its bits of the error register (1001h); default: those of the code"
    )
    info: Hex = Field(default="", max_length=14, description="up to 5 bytes of the maker, as hex digits")


class Overtemperature(Timed):
    """The motor or the drive is too hot."""

    what: Literal["overtemperature"]
    of: Literal["motor", "drive"] = "motor"


class Overcurrent(Timed):
    """The power stage has switched off because of too much current."""

    what: Literal["overcurrent"]


class DcLink(Timed):
    """The voltage of the DC link is too high or too low."""

    what: Literal["dc_link"]
    sort: Literal["overvoltage", "undervoltage"] = "undervoltage"


class MainsLost(Timed):
    """There is no supply for the power stage: the drive cannot be enabled, and loses its torque."""

    what: Literal["mains_lost"]


class StoOpen(Timed):
    """The input for safe torque off is open."""

    what: Literal["sto_open"]


class EncoderSignal(Timed):
    """The signals of the encoder are missing."""

    what: Literal["encoder_signal"]


class FollowingError(Timed):
    """The drive reports that the motor does not follow, by an error and bit 13 of the status word."""

    what: Literal["following_error"]


class Blocked(Timed):
    """The shaft is blocked."""

    what: Literal["blocked"]


class StuckBrake(Timed):
    """The holding brake stays on, or off, whatever the drive does."""

    what: Literal["stuck_brake"]
    stays: Literal["on", "off"] = "on"


class Warned(Timed):
    """The drive warns, by bit 7 of the status word."""

    what: Literal["warning"]


SingleDriveFault = Annotated[
    DriveError
    | Overtemperature
    | Overcurrent
    | DcLink
    | MainsLost
    | StoOpen
    | EncoderSignal
    | FollowingError
    | Blocked
    | StuckBrake
    | Warned,
    Field(discriminator="what"),
]
AnyDriveFault = Annotated[SingleDriveFault | NodeFault, Field(discriminator="what")]
"""The same, and those of its CANopen node."""
MODELS: Final = models_of(SingleDriveFault)
SingleDriveFaults = InjectedFaults[Fault[Any]]


class Cause(NamedTuple):
    """An error of the drive."""

    code: int
    coasts: bool
    """True if the torque is off at once, so that no ramp stops the motor."""
    error_register: int | None = None
    """Its bits of the error register; None for those of the code."""
    info: bytes = b""
    """Bytes of the maker in the EMCY."""


OVERLOAD: Final = Cause(0x2350, coasts=False)
"""I2t: more torque than the rated one, for too long."""
STO: Final = Cause(0x9000, coasts=True)
"""An open STO input, for a drive that takes it for a fault ('external error')."""
_TOO_HOT: Final = {"motor": Cause(0x4310, coasts=False), "drive": Cause(0x4210, coasts=False)}
_OVERCURRENT: Final = Cause(0x2310, coasts=True)
_VOLTAGE: Final = {"overvoltage": Cause(0x3210, coasts=True), "undervoltage": Cause(0x3220, coasts=True)}
_ENCODER: Final = Cause(0x7305, coasts=True)


def causes(faults: SingleDriveFaults, following_error_code: int) -> Iterator[Cause]:
    """Yield the errors that the present faults cause; makes differ in the code of a following error."""
    for fault in faults.active(DriveError):
        yield Cause(fault.code, fault.coasts, fault.error_register, bytes.fromhex(fault.info)[:MOST_INFO])
    yield from (_TOO_HOT[fault.of] for fault in faults.active(Overtemperature))
    yield from (_OVERCURRENT for _ in faults.active(Overcurrent))
    yield from (_VOLTAGE[fault.sort] for fault in faults.active(DcLink))
    yield from (_ENCODER for _ in faults.active(EncoderSignal))
    yield from (Cause(following_error_code, coasts=False) for _ in faults.active(FollowingError))
