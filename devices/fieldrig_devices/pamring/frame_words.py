"""One frame on the ring of a PAM in words: the object that it is about, and its values in the units of that object.

Levels are electrical, as in `frames`, so an input that is ACTIVE = LOW has the level 0 when it is on.
"""

from collections.abc import Callable
from dataclasses import fields
from enum import IntEnum, IntFlag
from typing import Any, Final

from fieldrig.points.values import show_number
from fieldrig_devices.pamring import frames
from fieldrig_devices.pamring.axis_words import Error, Status
from fieldrig_devices.pamring.described import DescribedNode, DescribedObject

UNKNOWN: Final = DescribedNode("", ())
LEVELS: Final = ("BINARY_INPUT", "DIGITAL_INPUT", "BINARY_OUTPUT", "DIGITAL_OUTPUT")
"""Objects whose values are levels."""
KINDS: Final = {
    frames.Identify: "identify", frames.Run: "run", frames.Group: "group", frames.SetOutput: "set output",
    frames.Blink: "blink", frames.Display: "display", frames.MotorOrder: "motor order",
    frames.AxisOrder: "axis order", frames.SetPoint: "set-point", frames.EndOfPipe: "end of pipe", frames.Read: "read",
    frames.InputItem: "configure input", frames.CounterItem: "configure counter", frames.KeyItem: "configure key",
    frames.OutputItem: "configure output", frames.AnalogItem: "configure analog output",
    frames.LedItem: "configure LED", frames.SevenSegmentItem: "configure display",
    frames.MotorItem: "configure motor", frames.AxisItem: "configure axis",
    frames.Identity: "identity", frames.Accepted: "accepted", frames.Refused: "refused", frames.Running: "running",
    frames.InputChanged: "input changed", frames.Answer: "answer", frames.AxisReport: "axis report",
    frames.MotorReport: "motor report", frames.Trouble: "trouble",
}  # fmt: skip
"""The word for each class of frame."""
SEVERITIES: Final = {frames.Severity.WARNING: "W", frames.Severity.ENDED: "K", frames.Severity.ERROR: "E"}
"""The letters of messages (section 14.3)."""


def words(frame: Any, node: DescribedNode) -> str:
    """Return a frame from or to a node of these objects, without its kind."""
    special = _SPECIAL.get(type(frame))
    return _plain(frame, node) if special is None else special(frame, node)


def _object(node: DescribedNode, item: int) -> DescribedObject:
    known = 1 <= item <= len(node.objects)
    return node.objects[item - 1] if known else DescribedObject(f"item {item}", "")


def object_of(node: DescribedNode, item: int) -> str:
    """Return the name of the object behind an item of a node."""
    return _object(node, item).name


def _axis(node: DescribedNode) -> DescribedObject:
    return next((each for each in node.objects if each.kind == "AXIS"), DescribedObject("axis", "AXIS"))


def _in_units(axis: DescribedObject, value: int) -> str:
    return show_number(float(f"{value / axis.units:.9g}")) if axis.units else f"{value} RU"


def _plain(frame: Any, node: DescribedNode) -> str:
    """Return all fields by their names; the item is the object."""
    named = [(each.name, getattr(frame, each.name)) for each in fields(frame)]
    first = [object_of(node, value) for name, value in named if name == "item"]
    rest = [f"{name.replace('_', ' ')} {value_text(value)}" for name, value in named if name != "item"]
    return " ".join([*first, ", ".join(rest)]).strip()


def value_text(value: Any) -> str:
    """Return the value of a field as people read it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return _word(value) if isinstance(value, IntEnum) else str(value)


def _word(value: IntEnum) -> str:
    return value.name.lower().replace("_", " ")


def _bits(value: IntFlag) -> str:
    """Return the names of the bits that are set, and the others as a number."""
    names = [bit.name.lower().replace("_", " ") for bit in type(value) if bit.name and bit in value]
    rest = int(value) & ~sum(int(bit) for bit in type(value))
    return ", ".join([*names, *([f"{rest:08X}h"] if rest else [])])


def _set(node: DescribedNode, item: int, value: int) -> str:
    item_object = _object(node, item)
    if item_object.kind == "ANALOG_OUTPUT":
        return f"{item_object.name} = {value} mV"
    return f"{item_object.name} {'level' if item_object.kind in LEVELS else '='} {value}"


def _numbered(number: int) -> str:
    return f" (order {number})" if number else ""


def _set_output(order: frames.SetOutput, node: DescribedNode) -> str:
    return _set(node, order.item, order.value) + _numbered(order.number)


def _input_changed(report: frames.InputChanged, node: DescribedNode) -> str:
    age = f", {report.age_us} us ago" if report.age_us else ""
    return _set(node, report.item, report.value) + age + _numbered(report.number)


def _motor_order(order: frames.MotorOrder, node: DescribedNode) -> str:
    values = " ".join(map(str, order.values))
    return f"{_object(node, order.item).name} {_word(order.order)} {values}".rstrip() + _numbered(order.number)


def _axis_order(order: frames.AxisOrder, node: DescribedNode) -> str:
    axis = _axis(node)
    text = f"{axis.name} {_word(order.move)}"
    if order.move not in (frames.Move.STOP, frames.Move.POWER_OFF, frames.Move.UPDATE_STATUS):
        text += f" {_in_units(axis, order.value)}"
    limits = (("speed", order.speed), ("acceleration", order.acceleration), ("deceleration", order.deceleration))
    text += "".join(f", {name} {_in_units(axis, abs(value))}" for name, value in limits if value)
    return text + _numbered(order.number)


def _set_point(order: frames.SetPoint, node: DescribedNode) -> str:
    axis = _axis(node)
    if order.mode is frames.SetPointMode.TORQUE:
        return f"{axis.name} torque limit {order.value / 10:g} %"
    return f"{axis.name} {_word(order.mode)} {_in_units(axis, order.value)}"


def _axis_report(report: frames.AxisReport, node: DescribedNode) -> str:
    axis = _axis(node)
    parts = [
        f"{axis.name} at {_in_units(axis, report.set_point)}",
        _bits(Status(report.status)),
        f"errors: {_bits(Error(report.error))}" if report.error else "",
    ]
    return ", ".join(part for part in parts if part) + (f" (order {report.number} done)" if report.number else "")


def _motor_report(report: frames.MotorReport, node: DescribedNode) -> str:
    error = f", error {report.error:06X}h" if report.error else ""
    ready = "ready" if report.is_ready else "not ready"
    return f"{_object(node, report.item).name} {ready}{error}{_numbered(report.number)}"


def _read(order: frames.Read, node: DescribedNode) -> str:
    return f"register {order.register} (request {order.request})"


def _answer(report: frames.Answer, node: DescribedNode) -> str:
    return f"{'no such register' if report.value is None else report.value} (request {report.request})"


def _trouble(report: frames.Trouble, node: DescribedNode) -> str:
    second, third = report.details
    return f"04..{SEVERITIES[report.severity]}{report.code:03X} {second:X}h {third:X}h, error word {report.word:08X}h"


_SPECIAL: Final[dict[type[Any], Callable[[Any, DescribedNode], str]]] = {
    frames.SetOutput: _set_output,
    frames.InputChanged: _input_changed,
    frames.MotorOrder: _motor_order,
    frames.AxisOrder: _axis_order,
    frames.SetPoint: _set_point,
    frames.AxisReport: _axis_report,
    frames.MotorReport: _motor_report,
    frames.Read: _read,
    frames.Answer: _answer,
    frames.Trouble: _trouble,
}
