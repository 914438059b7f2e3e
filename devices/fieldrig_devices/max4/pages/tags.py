"""The tags in pages, which the controller replaces by live values.

Source: PacDrive manual 5188-5217 (digest PD-281): pages are HTML with diagnosis applets, which simple tags
describe.  The manual does not show these tags, and browsers no longer run applets.  So the tags are our choice, and the
controller itself replaces them:

    <pac value="belt.Position">              a value, by the path of its parameter
    <pac table="parameters" of="belt">       the parameters of an object; without `of`, those of all objects
    <pac table="axes">                       states and actual values of the axes
    <pac table="log" rows="50">              the message logger, newest entry first

Everything that is shown is escaped.
"""

import re
from collections.abc import Iterable, Mapping
from html import escape, unescape
from typing import Final

from fieldrig.device import Value
from fieldrig_devices.max4.configuration.tree import Object, Parameter
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.max4.messages.logger import COLUMNS, ENTRIES

TAG: Final = re.compile(r"<pac\s([^<>]{0,400})>", re.IGNORECASE)
ATTRIBUTE: Final = re.compile(r'([a-z]+)\s*=\s*"([^"]*)"', re.IGNORECASE)
MOST_TAGS: Final = 1000
"""Tags of a page that are replaced; further ones stay as they are."""
AXIS_VALUES: Final = (
    "AxisState",
    "MC4State",
    "Position",
    "Velocity",
    "Torque",
    "FollowingError",
    "DiagCode",
    "DiagMsg",
)


def expanded(page: str, controller: Controller) -> str:
    """Return the page with its tags replaced."""
    return TAG.sub(lambda found: _replacement(_attributes(found[1]), controller), page, count=MOST_TAGS)


def value_of(controller: Controller, path: str) -> Value | None:
    """Return the value of a parameter by its path, stars for a secret; None if there is none."""
    try:
        return controller.tree.parameter(path).shown
    except KeyError:
        return None


def _attributes(text: str) -> Mapping[str, str]:
    return {name.lower(): unescape(value) for name, value in ATTRIBUTE.findall(text)}


def _replacement(attributes: Mapping[str, str], controller: Controller) -> str:
    match attributes:
        case {"value": path}:
            value = value_of(controller, path)
            return _shown(f"[no parameter {path}]" if value is None else value)
        case {"table": "axes"}:
            return _axes(controller)
        case {"table": "log"}:
            return _log(controller, attributes.get("rows", ""))
        case {"table": "parameters"}:
            return _parameters(controller, attributes.get("of", ""))
    return _shown("[unknown tag]")


def _axes(controller: Controller) -> str:
    rows = [(name, *(axis.object[value].shown for value in AXIS_VALUES)) for name, axis in controller.axes.items()]
    return _table(("Axis", *AXIS_VALUES), rows)


def _log(controller: Controller, rows: str) -> str:
    count = int(rows) if rows.isdecimal() and len(rows) < 6 else ENTRIES
    return _table(COLUMNS, [line.split("\t") for line in controller.logger.lines()[:count]])


def _parameters(controller: Controller, path: str) -> str:
    try:
        objects = [controller.tree.object(path)] if path else controller.tree.objects()
    except KeyError:
        return _shown(f"[no object {path}]")
    rows = [_parameter(owner, parameter) for owner in objects for parameter in owner.parameters]
    return _table(("Parameter", "Value", "Unit", "Meaning"), rows)


def _parameter(owner: Object, parameter: Parameter) -> tuple[Value, ...]:
    return f"{owner.symbol or owner.name}.{parameter.name}", parameter.shown, parameter.unit, parameter.about


def _table(columns: Iterable[str], rows: Iterable[Iterable[Value]]) -> str:
    head = "".join(f"<th>{_shown(column)}</th>" for column in columns)
    body = "".join("<tr>" + "".join(f"<td>{_shown(cell)}</td>" for cell in row) + "</tr>\n" for row in rows)
    return f"<table>\n<tr>{head}</tr>\n{body}</table>"


def _shown(value: Value) -> str:
    return escape(str(value))
