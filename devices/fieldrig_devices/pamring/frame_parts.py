"""The frames of a PAM's ring value by value, by node, kind and object, such as `cutter/axis report status`."""

from collections.abc import Iterable
from dataclasses import fields
from enum import IntFlag
from typing import Any, Final

from fieldrig.traces.parts import Part
from fieldrig_devices.pamring.axis_words import Error, Status
from fieldrig_devices.pamring.described import DescribedNode
from fieldrig_devices.pamring.frame_words import KINDS, object_of, value_text
from fieldrig_devices.pamring.frames import AxisReport

WORDS: Final[dict[tuple[type[Any], str], type[IntFlag]]] = {
    (AxisReport, "status"): Status,
    (AxisReport, "error"): Error,
}
"""The fields that are sets of bits."""


def frame_parts(told: Iterable[tuple[str, DescribedNode, Any]]) -> list[Part]:
    """Return the fields of frames, each with the name and the objects of its node; bytes are no frame."""
    found: dict[str, Part] = {}
    for name, node, frame in told:
        for part in _of_frame(name, node, frame):
            found[_free(part.key, found)] = part
    return [part._replace(key=key) for key, part in found.items()]


def _free(key: str, found: dict[str, Part]) -> str:
    """Return a key that is not there yet: a node may have the same order twice in a cycle."""
    number, free = 1, key
    while free in found:
        number += 1
        free = f"{key} ({number})"
    return free


def _of_frame(name: str, node: DescribedNode, frame: Any) -> Iterable[Part]:
    if isinstance(frame, bytes):
        text = frame.hex(" ").upper()
        return [Part(f"{name}/frame", "", text, text)]
    kind, item = KINDS[type(frame)], getattr(frame, "item", None)
    begin = f"{name}/{kind}" if item is None else f"{name}/{kind} {object_of(node, item)}"
    values = [(each.name, getattr(frame, each.name)) for each in fields(frame) if each.name != "item"]
    if not values:
        return [Part(begin, "", 1, "sent")]
    return [
        _part(f"{begin} {field.replace('_', ' ')}", WORDS.get((type(frame), field)), value) for field, value in values
    ]


def _part(key: str, bits: type[IntFlag] | None, value: Any) -> Part:
    if bits is not None:
        names = {int(bit).bit_length() - 1: (bit.name or "").lower().replace("_", " ") for bit in bits}
        return Part(key, "", int(value), f"{int(value):08X}h", names)
    return Part(key, "", int(value) if isinstance(value, int) else str(value), value_text(value))
