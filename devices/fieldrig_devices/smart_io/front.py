"""The front of a Smart-IO node: the keyboard card with its display, keys and LEDs, and the terminals.

Source: section 15.4 of the digest for the keyboard cards, appendix F for the display, B.2 for the LEDs of the ring.
The layout of the keyboard is lost; each key has its LED above it, eight in a row.
"""

from collections.abc import Iterator
from typing import Final

from fieldrig.front import Clamp, Front, Gap, Group, Key, Led, Number, Part, Plate, SevenSegment, Text
from fieldrig_devices.smart_io.addresses import addresses_of
from fieldrig_devices.smart_io.settings import SmartIoSettings

_COLUMNS: Final = 8


def front_of(settings: SmartIoSettings, has_ring: bool, has_display: bool) -> Front:
    keyboard = [*_keyboard(settings)]
    groups = [Group([*_state(has_ring, has_display)], "node")]
    groups += [Group(keyboard, "keyboard", columns=_COLUMNS)] if keyboard else []
    for module in sorted(settings.modules):
        addresses = tuple(addresses_of(module))
        groups += [
            Group([_input(f"in {at}", f"in{at}", settings) for at in addresses], f"inputs of module {module}"),
            Group([Clamp(f"out {at}", f"out{at}", side="out") for at in addresses], f"outputs of module {module}"),
        ]
    groups.append(Group([Clamp("analog 1", "analog1", side="out")], "analog output"))
    groups += [_motor(f"motor{number}") for number in range(1, len(settings.motors) + 1)]
    return Front(Plate("Socapel", f"Smart-IO, keyboard {settings.keyboard}"), groups)


def _state(has_ring: bool, has_display: bool) -> Iterator[Part]:
    if has_display:
        yield SevenSegment("display", "display", "a code of the node, or a character", segments="display.segments")
        yield Led("CRC", "ring_leds", "an error of the ring", colour="red")
        yield Led("carrier", "ring_leds", "an error of the ring", colour="yellow")
    yield Text("outputs", "owner", "the side that controls the outputs", names=(("pam", "PAM"), ("alone", "the node")))
    yield Text("error word", "error_word", names=((0, "none"),), hex_digits=4)
    if has_ring:
        yield Text("node", "node", good=("running",))
        yield Text("fault of the ring", "ring", names=(("", "none"),))


def _keyboard(settings: SmartIoSettings) -> Iterator[Part]:
    """Yield rows of LEDs, each above the row of its keys."""
    keys, leds = list(settings.keys), list(settings.leds)
    for first in range(0, max(len(keys), len(leds)), _COLUMNS):
        row = range(first, first + _COLUMNS)
        for at in row:
            yield Led(str(leds[at]), f"led{leds[at]}", colour="yellow") if at < len(leds) else Gap()
        for at in row:
            yield _key(keys[at], settings) if at < len(keys) else Gap()


def _key(number: int, settings: SmartIoSettings) -> Part:
    """Return a key, or a terminal without a button if a wire has its contact."""
    is_wired = f"key{number}" in settings.terminals
    return _input(str(number), f"key{number}", settings) if is_wired else Key(str(number), f"key{number}")


def _input(label: str, terminal: str, settings: SmartIoSettings) -> Clamp:
    return Clamp(label, terminal, is_set=terminal not in settings.terminals)


def _motor(name: str) -> Group:
    return Group(
        [
            Number("position", f"{name}.position"),
            Led("ready", f"{name}.ready", "no order is carried out"),
            Text("error word", f"{name}.error", names=((0, "none"),), hex_digits=4),
        ],
        name.replace("motor", "motor "),
    )
