"""The front of an HMISCU: the panel with its lines, keys and lamps, the controller, and the terminals.

Source: SCU-095 for the image of the terminals, SCU-075 for the outputs that a channel has.  The panel is a touch screen
(`panel.py`), and the controller's LEDs are ours, as the library manual shows none.
"""

from collections.abc import Collection
from typing import Final

from fieldrig.front import Clamp, Front, Group, Key, Led, Lines, Number, Part, Plate, Text
from fieldrig_devices.hmiscu.models import Kind
from fieldrig_devices.hmiscu.panel import KEYS, LAMPS, LINES, WIDTH
from fieldrig_devices.hmiscu.plc.plc import COMMANDS
from fieldrig_devices.hmiscu.settings import INPUTS, HmiscuSettings

_STATES: Final = (
    (0, "Standstill"), (1, "DiscreteMotion"), (2, "ContinuousMotion"), (3, "Stopping"), (4, "ErrorStop"),
)  # fmt: skip


_PINS: Final = (".Duty", ".Frequency", ".InFrequency", ".Busy", ".Error")
"""The pins of a PWM block that its front shows (SCU-074)."""


def front_of(settings: HmiscuSettings, axis: str, keys: Collection[str]) -> Front:
    """Return the front; `axis` is the name of the axis of channel 0, empty if it has none.

    `keys` are those of the points, among which are the pins of the PWM blocks.
    """
    blocks = [key.removesuffix(_PINS[0]) for key in keys if key.endswith(_PINS[0])]
    lines = [f"panel.line{number}" for number in range(1, LINES + 1)]
    lamps = [Led(str(number), f"panel.lamp{number}", colour="yellow") for number in range(1, LAMPS + 1)]
    buttons = [Key(str(number), f"panel.key{number}") for number in range(1, KEYS + 1)]
    return Front(
        Plate("Schneider Electric", settings.model),
        [
            Group([Lines("screen", "", "the lines of the panel", columns=WIDTH, rows=LINES, lines=lines)]),
            Group([*lamps, *buttons], "lamps and keys", columns=KEYS),
            Group(
                [
                    Led("RUN", "plc/state", "the program runs", lit=("run",), blinks=("stop",)),
                    Led("ERR", "plc/problem", "the controller is in HALT, or refused a program", colour="red"),
                    Text("controller", "plc/state", good=("run",), bad=("halt",)),
                    Text("problem", "plc/problem", names=(("", "none"),)),
                    *(
                        Key(word.capitalize(), "plc/command", name=word, pressed=word, released=None)
                        for word in COMMANDS
                    ),
                ],
                "controller",
            ),
            *([_axis(axis)] if axis else []),
            *(_pwm(name) for name in blocks if all(f"{name}{pin}" in keys for pin in _PINS)),
            *_terminals(settings),
        ],
    )


def _axis(name: str) -> Group:
    return Group(
        [
            Text("state", f"{name}.State", names=_STATES, bad=(4,)),
            Number("position", f"{name}.Position"),
            Led("direction", f"{name}.DirectionLevel", "level of the direction output"),
        ],
        f"axis {name}",
    )


def _pwm(name: str) -> Group:
    return Group(
        [
            Number("duty", f"{name}.Duty", "in %"),
            Number("frequency", f"{name}.Frequency", "in 0.1 Hz"),
            Led("in frequency", f"{name}.InFrequency", "the asked frequency is there"),
            Led("busy", f"{name}.Busy", "a change is under way", colour="yellow"),
            Led("error", f"{name}.Error", colour="red"),
        ],
        f"channel {name}",
    )


def _terminals(settings: HmiscuSettings) -> list[Group]:
    groups: dict[Kind, list[Part]] = {}
    for terminal, kind in settings.kinds.items():
        if terminal not in settings.dedicated:
            is_input = kind in INPUTS
            is_set = is_input and not settings.wire_of(terminal)
            clamp = Clamp(terminal, terminal, side="in" if is_input else "out", is_set=is_set)
            groups.setdefault(kind, []).append(clamp)
    return [Group(parts, f"{kind}s") for kind, parts in groups.items()]
