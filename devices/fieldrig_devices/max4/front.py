"""The front of a MAx-4: its LEDs, the diagnosis, the ring, each axis with the names of its states, and its terminals.

Source: digest PD-090 to PD-099 for LEDs and diagnosis, PD-150 to PD-160 for the states.  Of the LEDs the manual has err
only; the others are those of the controller's points.
"""

from collections.abc import Collection, Iterator
from typing import Final

from fieldrig.front import Clamp, Colour, Front, Group, Key, Led, Number, Part, Plate, SevenSegment, Text
from fieldrig_devices.drives.state_words import AXIS_WORDS, MC4_WORDS
from fieldrig_devices.max4.settings import Max4Settings
from fieldrig_devices.motion.front import shaft

_LEDS: Final[dict[str, Colour]] = {"power": "green", "run": "green", "bus": "yellow", "err": "red"}
_COMMANDS: Final = ("start", "stop", "reset", "quit")
_AXIS: Final = ".AxisState"
_INCREMENTS: Final = 1_000_000.0
"""Encoder increments per revolution (manual 6929-6933)."""


def front_of(keys: Collection[str], settings: Max4Settings) -> Front:
    """Return the front of a controller whose points have these keys."""
    axes = [key.removesuffix(_AXIS) for key in keys if key.endswith(_AXIS)]
    groups = [Group([*_leds(), *_state()], "controller"), Group([*_diagnosis()], "diagnosis")]
    groups += [Group([*_axis(symbol)], symbol) for symbol in axes]
    groups.append(Group([*_terminals(keys, settings)], "terminals"))
    plate = Plate("ELAU", "MAx-4", {"article number": "ArticleNumber", "serial number": "SerialNumber"})
    return Front(plate, [group for group in groups if group.parts])


def _leds() -> Iterator[Part]:
    for name, colour in _LEDS.items():
        yield Led(name, f"led.{name}", colour=colour, lit=("on",), blinks=("flashing",))


def _diagnosis() -> Iterator[Part]:
    yield SevenSegment("DiagCode", "DiagCode", "code of the most severe pending diagnosis", digits=4)
    yield Text("diagnosis", "DiagMsg", names=(("", "none"),))
    yield Text("details", "DiagExtCode", names=(("", "none"),))
    yield Text("last message", "log.last", names=(("", "none"),))


def _state() -> Iterator[Part]:
    yield Text("program", "program", good=("running",))
    yield Text("ring", "ring.state", good=("up",))
    yield Number("phase", "ring.phase", "phase of the ring, CP0 to CP4")
    yield Led("open", "ring.open", "the ring is open", colour="red")
    yield Number("load", "CycleLoad", "of the real-time process")
    for word in _COMMANDS:
        yield Key(word.capitalize(), "command", name=word, pressed=word, released=None)


def _axis(symbol: str) -> Iterator[Part]:
    yield shaft(f"{symbol}.Position", _INCREMENTS, "the shaft of the motor")
    yield Text("AxisState", f"{symbol}.AxisState", names=tuple(AXIS_WORDS.items()), good=(3,), bad=(5,))
    yield Text("MC4State", f"{symbol}.MC4State", names=tuple(MC4_WORDS.items()), good=(0x21,), bad=(0x02,))
    yield Number("position", f"{symbol}.Position", decimals=0)
    yield Number("velocity", f"{symbol}.Velocity", decimals=0)
    yield Number("torque", f"{symbol}.Torque", decimals=0)
    yield Text("diagnosis", f"{symbol}.DiagMsg", names=(("", "none"),))


def _terminals(keys: Collection[str], settings: Max4Settings) -> Iterator[Part]:
    for symbol, wire in (settings.inputs | settings.measuring_inputs).items():
        if f"{symbol}.Value" in keys:
            yield Clamp(symbol, f"{symbol}.Value", is_set=not wire)
    for symbol in settings.outputs:
        if f"{symbol}.Value" in keys:
            yield Clamp(symbol, f"{symbol}.Value", side="out")
