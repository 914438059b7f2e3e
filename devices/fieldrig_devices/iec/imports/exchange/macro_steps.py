"""Macro steps of a chart: the chart inside takes their place.

Source: TC6 2.01 (`macroStep` with a body in SFC) and IEC 60848 5.3: the steps inside begin with the one that no line
leads to, and end with the one that no transition follows.
"""

from collections.abc import Sequence
from dataclasses import replace

from fieldrig_devices.iec.imports.networks.graph import Item, Kind, Pin
from fieldrig_devices.iec.imports.report import Report


def resolved(name: str, identifier: str, line: int, before: list[Pin], items: list[Item], report: Report) -> list[Item]:
    """Return the items inside of a macro step with identifiers of their own; its last step has that of the macro step.

    `before` are the lines that lead to the macro step.
    """
    steps = [item for item in items if item.kind is Kind.STEP]
    drawn = (item for item in items if item.kind is not Kind.ACTIONS)
    followed = {wire.source for item in drawn for pin in _pins(item) for wire in pin.wires}
    first = [step for step in steps if not any(pin.wires for pin in step.inputs)]
    last = [step for step in steps if step.id not in followed]
    if len(first) != 1 or len(last) != 1:
        report.mistake(
            line,
            f"The macro step {name[:60]} has {len(first)} steps to begin with and {len(last)} to end with",
            "one of each",
            "Resolve it into steps in the tool.",
        )
        return []
    names = {item.id: f"{identifier}/{item.id}" for item in items} | {last[0].id: identifier}
    for item in items:
        item.id = names[item.id]
        _rename(_pins(item), names)
    first[0].inputs = before
    return items


def _pins(item: Item) -> list[Pin]:
    condition = item.condition.pin if item.condition is not None else None
    return [*item.pins(), *([condition] if condition is not None else [])]


def _rename(pins: Sequence[Pin], names: dict[str, str]) -> None:
    for pin in pins:
        pin.wires = tuple(replace(wire, source=names.get(wire.source, wire.source)) for wire in pin.wires)
