"""Messages whose cause comes and goes, as a bit set: those of faults, and those of measured values."""

from collections.abc import Iterable, Mapping
from typing import Final

from fieldrig.faults.faults import Timed
from fieldrig_devices.mc4.diagnosis import Code, Diagnosis
from fieldrig_devices.mc4.faults import DcBus, DriveFaults, EncoderSignal, Overload, Overtemperature, Supply24V
from fieldrig_devices.mc4.power import DcCircuit
from fieldrig_devices.mc4.thermal import Thermal

HOT: Final = {"motor": Code.MOTOR_TEMPERATURE, "amplifier": Code.AMPLIFIER_TEMPERATURE}
BUS: Final = {
    "communication": Code.DC_BUS_CONTROLLER,
    "undervoltage": Code.UNDERVOLTAGE,
    "overvoltage": Code.OVERVOLTAGE,
    "phase": Code.MAINS_PHASE,
}
OTHERS: Final[Mapping[type[Timed], Code]] = {
    Overload: Code.OVERLOAD,
    EncoderSignal: Code.ENCODER_SIGNAL,
    Supply24V: Code.SUPPLY_24V,
}
CAUSES: Final = (*HOT.values(), *BUS.values(), *OTHERS.values())
"""The messages; the position of each is the number of its bit."""
_BIT: Final = {code: 1 << bit for bit, code in enumerate(CAUSES)}


def bits(codes: Iterable[Code]) -> int:
    return sum({_BIT[code] for code in codes})


def given(faults: DriveFaults) -> int:
    """Return the causes that active faults give."""
    codes = [code for kind, code in OTHERS.items() if faults.first(kind) is not None]
    codes += [HOT[fault.of] for fault in faults.active(Overtemperature)]
    codes += [BUS[fault.sort] for fault in faults.active(DcBus)]
    return bits(codes)


def measured(thermal: Thermal, dc: DcCircuit, load_limit: float, *, has_torque: bool) -> int:
    """Return the causes that are measured.  `load_limit` is S-0-0114, as a fraction."""
    causes = 0
    if thermal.is_motor_hot:
        causes |= _BIT[Code.MOTOR_TEMPERATURE]
    if thermal.is_amplifier_hot:
        causes |= _BIT[Code.AMPLIFIER_TEMPERATURE]
    if thermal.amplifier_load >= 1 or thermal.motor_load >= load_limit:
        causes |= _BIT[Code.OVERLOAD]
    if dc.is_over:
        causes |= _BIT[Code.OVERVOLTAGE]
    if not dc.is_mains_on and has_torque:
        causes |= _BIT[Code.MAINS_PHASE]
    if dc.is_under and has_torque:
        causes |= _BIT[Code.UNDERVOLTAGE]
    return causes


class Causes:
    """The causes of one drive that are present, and the messages that begin and end with them."""

    __slots__ = ("_diagnosis", "_present", "given")

    def __init__(self, diagnosis: Diagnosis) -> None:
        self._diagnosis, self._present = diagnosis, 0
        self.given = 0
        """The causes that active faults give."""

    def update(self, measured: int) -> bool:
        """Take the causes that are measured at present.  Return true if any cause has changed."""
        causes = self.given | measured
        changed, self._present = causes ^ self._present, causes
        for bit, code in enumerate(CAUSES) if changed else ():
            if changed >> bit & 1:
                if causes >> bit & 1:
                    self._diagnosis.raise_(code, stays=True)
                else:
                    self._diagnosis.end(code)
        return bool(changed)
