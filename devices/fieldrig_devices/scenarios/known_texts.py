"""Texts that a place can have: those of a state with names, and true or false of a flag.

A comparison with any other text never holds, or always, and says nothing about the machine.
"""

from typing import TYPE_CHECKING, Final

from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.points.names import split_point
from fieldrig.text.nearest import closest

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig

FLAG: Final = ("true", "false")


def check_compared(rig: "Rig", place: str, text: Value, present: Value) -> None:
    """ControlError for a text that this place never has; `present` is its present value."""
    known = _known(rig, place, text, present)
    if known:
        raise ControlError(f"{place} is never {text!r}", closest(text, known))
    if isinstance(text, str) and isinstance(present, int | float) and not _states(rig, place):
        is_flag = isinstance(present, bool) or text.lower() in FLAG
        if not is_flag:
            raise ControlError(f"{place} is never {text!r}", f"it is a number, now {present}")


def check_written(rig: "Rig", place: str, value: object, present: Value) -> None:
    """ControlError for a text that is not one of those of the place."""
    known = _known(rig, place, value, present)
    if known:
        raise ControlError(f"{place} cannot be {value!r}", closest(value, known))


def _known(rig: "Rig", place: str, text: object, present: Value) -> list[str]:
    """Return the texts of the place, if this is a text and none of them."""
    if not isinstance(text, str):
        return []
    states = _states(rig, place)
    known = list(states) or (list(FLAG) if isinstance(present, bool) else [])
    return [] if text in known or (not states and text.lower() in FLAG) else known


def _states(rig: "Rig", place: str) -> list[str]:
    device, key = split_point(place)
    states: list[str] = rig.facts(device).get(key, {}).get("states", []) if device in rig.config.devices else []
    return states
