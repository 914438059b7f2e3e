"""The register table of a node without a PAM.

Source: ours, as the manual knows the ring only.  A place of a module is 12 x (module - 1) + (position - 1), so 101 is
0 and 1612 is 191.

    coils              outputs at their places, LED n at 255 + n, blinking of LED n at 319 + n
    discrete inputs    inputs at their places, key n at 255 + n, "ready" of motor n at 319 + n
    holding registers  0 analog output in mV, 1 character of the display, 2 its blinking; motor n at 16 n: order,
                       value (two registers), second value (two)
    input registers    0 error word (two); motor n at 16 n: position (two), error word (two)
"""

from collections.abc import Iterable, Iterator
from typing import Any, Final

from fieldrig_devices.registers.table import Table
from fieldrig_devices.smart_io.addresses import POSITIONS, addresses_of
from fieldrig_devices.smart_io.settings import SmartIoSettings

KEYBOARD: Final = 256
"""Address of the first key, or LED."""
SECOND: Final = 320
"""Address of the blinking of the first LED, or of "ready" of the first motor."""
PER_MOTOR: Final = 16
Entry = dict[str, Any]


def table(settings: SmartIoSettings) -> Table:
    """Return the table with what this node has."""
    modules, keys, leds, motors = sorted(settings.modules), settings.keys, settings.leds, len(settings.motors)
    display = [
        {"address": 1, "name": "display.character"},
        {"address": 2, "name": "display.blink", "type": "bool"},
    ]
    return Table.model_validate(
        {
            "about": "Smart-IO node",
            "word_order": "little",
            "coils": [*_places("out", modules), *_row("led{}", KEYBOARD, leds), *_row("led{}.blink", SECOND, leds)],
            "discrete_inputs": [
                *_places("scan", modules),
                *_row("key{}", KEYBOARD, keys),
                *_row("motor{}.ready", SECOND, range(1, motors + 1)),
            ],
            "holding_registers": [
                {"address": 0, "name": "analog1", "type": "s16"},
                *(display if settings.keyboard == "006.7012" else ()),
                *_motors(motors, ("order", 0, "u16"), ("value", 1, "s32"), ("second", 3, "s32")),
            ],
            "input_registers": [
                {"address": 0, "name": "error_word", "type": "u32"},
                *_motors(motors, ("position", 0, "s32"), ("error", 2, "u32")),
            ],
        }
    )


def _places(terminal: str, modules: Iterable[int]) -> Iterator[Entry]:
    for module in modules:
        for bit, address in enumerate(addresses_of(module)):
            yield {"address": POSITIONS * (module - 1) + bit, "name": f"{terminal}{address}"}


def _row(name: str, first: int, numbers: range) -> Iterator[Entry]:
    for bit, number in enumerate(numbers):
        yield {"address": first + bit, "name": name.format(number)}


def _motors(count: int, *points: tuple[str, int, str]) -> Iterator[Entry]:
    for number in range(1, count + 1):
        for point, offset, kind in points:
            yield {"address": PER_MOTOR * number + offset, "name": f"motor{number}.{point}", "type": kind}
