"""Settings of the ports: one for each passage of the manual that can be read in more than one way."""

from typing import Literal

from pydantic import Field

from fieldrig.settings import Settings
from fieldrig_devices.pam.ports.memory import ByteOrder


class ClassCodes(Settings):
    """Codes of the classes of variables in the VME DualPort; VMECLASS.H, which defines them, is lost."""

    flag: int = Field(default=1, ge=0, le=0xFFFF, description="code of FLAG_VAR")
    word: int = Field(default=2, ge=0, le=0xFFFF, description="code of WORD_VAR")
    long: int = Field(default=3, ge=0, le=0xFFFF, description="code of LONG_VAR")
    real: int = Field(default=4, ge=0, le=0xFFFF, description="code of REAL_VAR")


class PortOptions(Settings):
    """How the ports behave where the manual is silent or ambiguous."""

    command_cleared_by: Literal["pam", "master"] = Field(
        default="pam",
        description="which side sets COMMAND of a VME DualPort back to NOP: the PAM when it acknowledges, and the "
        "master clears ACKNOWLEDGE before a command; or the master after the acknowledge, which the PAM then clears",
    )
    class_codes: ClassCodes = Field(default_factory=ClassCodes, description="codes of the classes in a VME DualPort")
    pam_ready: Literal["set_first", "as_printed"] = Field(
        default="set_first",
        description="start-up of a Simatic DualPort: `set_first` sets PAM_READY before the first wait, so that it "
        "works in every order; `as_printed` follows the manual, where the PAM and its host may wait for each other",
    )
    byte_order: ByteOrder | None = Field(
        default=None,
        description="which bits of a word have its even byte address for clients that read bytes: `big` bits 8 to 15, "
        "`little` bits 0 to 7; by default little for a Simatic DualPort, whose bit addresses are counted so, else big",
    )
    rs422_baud: int = Field(
        default=38_400, ge=300, le=1_000_000, description="bit rate of the RS422 line, with 8 data bits and no parity"
    )
