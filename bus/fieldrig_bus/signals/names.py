"""The signals of wires by name: the wire with its value and unit, and the device that drives it.

The kind is that of the signal, so that a filter for `pulses` finds all pulse trains.
"""

from collections.abc import Iterator, Sequence
from typing import Any

from fieldrig.bus import Bus
from fieldrig.points.values import show_number
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
        """Return the value of a signal with its unit, and how it moves, number by number."""
        if not isinstance(message, Signal):
            return None
        text = f"{show_number(message.value)} {message.unit}".rstrip()
        moves = (_part(f"{message.name} {what}", value, unit) for what, value, unit in _moves(message))
        return Parts("", _kind(message), (Part(message.name, "", message.value, text), *moves))


def _moves(message: Signal) -> Iterator[tuple[str, int | float, str]]:
    match message:
        case Motion():
            yield "speed", message.speed, f"{message.unit}/s"
            yield "acceleration", message.acceleration, f"{message.unit}/s²"
        case PulseTrain():
            yield "frequency", float(message.frequency), "Hz"
            yield "rate", float(message.rate), "Hz/s"
            yield (
                "pulses",
                -1 if message.count is None else message.count,
                "" if message.count is not None else "(no end)",
            )
            yield "direction", message.direction, ""
            yield "phase", float(message.phase), "of a period"
            yield "sent", message.sent, "pulses"
        case Pwm():
            yield "frequency", float(message.frequency), "Hz"


def _part(key: str, value: int | float, unit: str) -> Part:
    return Part(key, "", value, f"{show_number(value)} {unit}".rstrip())


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
