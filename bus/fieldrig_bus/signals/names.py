"""The signals of wires by name: the wire with its value and unit, and the device that drives it.

The kind is that of the signal, so that a filter for `pulses` finds all pulse trains.
"""

from collections.abc import Sequence
from typing import Any

from fieldrig.bus import Bus
from fieldrig.traces.names import Member, Named, Namer
from fieldrig.traces.parts import Part, Parts
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_bus.signals.signal import Motion, Signal
from fieldrig_bus.signals.traced import show


class WireNames:
    """Names the signals of one bus of wires."""

    def __call__(self, message: Any, sender: str = "") -> Named:
        return Named(_kind(message), sender, show(message))

    def parts(self, message: Any, request: bytes = b"") -> Parts | None:
        """Return the value of a signal with its unit, and how it moves."""
        if not isinstance(message, Signal):
            return None
        text = show(message).removeprefix(message.name).lstrip(" =")
        value = message.value if type(message) is Signal else text
        return Parts("", _kind(message), (Part(message.name, "", value, text),))


def _kind(message: Any) -> str:
    match message:
        case Motion():
            return "motion"
        case PulseTrain():
            return "pulses"
        case Pwm():
            return "PWM"
        case Signal(value=bool()):
            return "digital"
        case Signal():
            return "analog"
    return "fault"


def namer(bus: Bus[Any], members: Sequence[Member]) -> Namer:
    """Return the namer of a bus of wires."""
    return WireNames()
