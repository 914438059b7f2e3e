"""The tags in pages, which the controller replaces by live values.

Source: PacDrive manual 5188-5217 (digest PD-281): pages are HTML with diagnosis applets, which simple tags
describe.  The manual does not show these tags, and browsers no longer run applets.  So the tags are our choice, and the
controller itself replaces them:

    <pac value="belt.Position">              a value, by the path of its parameter
    <pac text="belt.AxisState">              a value with its meaning in words, and its unit
    <pac diagnosis="belt">                   code and message of the diagnosis of an object
    <pac table="parameters" of="belt">       the parameters of an object; without `of`, those of all objects
    <pac table="axes">                       states and actual values of the axes
    <pac table="log" rows="50">              the message logger, newest entry first

With `lang="en"` or `lang="de"` messages are in the language of the page, whatever that of the controller is.  With
`live="yes"`, the script `LIVE.JS` keeps the tag up to date by `/values?tag=`.  Everything that is shown is escaped.
"""

import re
from collections.abc import Iterable, Mapping
from html import escape, unescape
from typing import Final

from fieldrig.device import Value
from fieldrig_devices.max4.configuration.tree import Object, Parameter
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.max4.messages.catalogue import translated
from fieldrig_devices.max4.messages.diagnosis import MESSAGE_CLASS
from fieldrig_devices.max4.messages.logger import COLUMNS, ENTRIES

TAG: Final = re.compile(r"<pac\s([^<>]{0,400})>", re.IGNORECASE)
ATTRIBUTE: Final = re.compile(r'([a-z]+)\s*=\s*"([^"]*)"', re.IGNORECASE)
MOST_TAGS: Final = 1000
"""Tags of a page that are replaced; further ones stay as they are."""
AXIS_VALUES: Final = ("AxisState", "MC4State", "Position", "Velocity", "Torque", "FollowingError")
CODE: Final = COLUMNS.index("Diag. Code")
MESSAGE: Final = COLUMNS.index("Message")
NO_MESSAGE: Final[Mapping[str, str]] = {"de": "keine", "en": "none"}
DIGITS: Final = 3
"""Decimal places of a value with its unit."""


def expanded(page: str, controller: Controller) -> str:
    """Return the page with its tags replaced."""
    return TAG.sub(lambda tag: _wrapped(tag[1], controller), page, count=MOST_TAGS)


def shown_by(text: str, controller: Controller) -> str:
    """Return the HTML that a tag with these attributes shows."""
    return _replacement(_attributes(text), controller)


def value_of(controller: Controller, path: str) -> Value | None:
    """Return the value of a parameter by its path, stars for a secret; None if there is none."""
    try:
        return controller.tree.parameter(path).shown
    except KeyError:
        return None


def _attributes(text: str) -> Mapping[str, str]:
    return {name.lower(): unescape(value) for name, value in ATTRIBUTE.findall(text)}


def _wrapped(text: str, controller: Controller) -> str:
    attributes = _attributes(text)
    html = _replacement(attributes, controller)
    if attributes.get("live") != "yes":
        return html
    element = "div" if "table" in attributes else "span"
    return f'<{element} data-pac="{_shown(text.strip())}">{html}</{element}>'


def _replacement(attributes: Mapping[str, str], controller: Controller) -> str:
    language = attributes.get("lang", "")
    match attributes:
        case {"value": path}:
            value = value_of(controller, path)
            return _shown(f"[no parameter {path}]" if value is None else value)
        case {"text": path}:
            return _text(controller, path)
        case {"diagnosis": path}:
            return _diagnosis(controller, path, language)
        case {"table": "axes"}:
            return _axes(controller, language)
        case {"table": "log"}:
            return _log(controller, attributes.get("rows", ""), language)
        case {"table": "parameters"}:
            return _parameters(controller, attributes.get("of", ""))
    return _shown("[unknown tag]")


def _text(controller: Controller, path: str) -> str:
    try:
        parameter = controller.tree.parameter(path)
    except KeyError:
        return _shown(f"[no parameter {path}]")
    return _shown(f"{in_words(parameter)} {parameter.unit}".rstrip())


def in_words(parameter: Parameter) -> str:
    """Return a value with few decimal places, and with what it means."""
    value = parameter.shown
    if isinstance(value, float):
        return f"{value:.{DIGITS}f}".rstrip("0").rstrip(".")
    word = parameter.words.get(value) if isinstance(value, int) else None
    return str(value) if word is None else f"{value} {word}"


def _diagnosis(controller: Controller, path: str, language: str) -> str:
    code, message = value_of(controller, f"{path}.DiagCode"), value_of(controller, f"{path}.DiagMsg")
    if not isinstance(code, int):
        return _shown(f"[no diagnosis of {path}]")
    if not code:
        return _shown(f"0 {NO_MESSAGE.get(language) or NO_MESSAGE[controller.language]}")
    text = f"{code} {translated(str(message), code, language)}".strip()
    return f'<span class="error">{_shown(text)}</span>' if _is_error(code) else _shown(text)


def _is_error(code: int) -> bool:
    return 0 < code // 1000 < MESSAGE_CLASS


def _axes(controller: Controller, language: str) -> str:
    rows, errors = [], []
    for name, axis in controller.axes.items():
        code, message = int(axis.object["DiagCode"].shown), str(axis.object["DiagMsg"].shown)
        diagnosis = f"{code} {translated(message, code, language)}" if code else ""
        rows.append((name, *(in_words(axis.object[value]) for value in AXIS_VALUES), diagnosis))
        errors.append(_is_error(code))
    first = next(iter(controller.axes.values()), None)
    units = [first.object[value].unit if first is not None else "" for value in AXIS_VALUES]
    heads = [f"{value}, {unit}" if unit else value for value, unit in zip(AXIS_VALUES, units, strict=True)]
    return _table(("Axis", *heads, "Diagnosis"), rows, errors)


def _log(controller: Controller, rows: str, language: str) -> str:
    count = int(rows) if rows.isdecimal() and len(rows) < 6 else ENTRIES
    lines = [line.split("\t") for line in controller.logger.lines()[:count]]
    codes = [int(line[CODE]) if line[CODE].isdecimal() else 0 for line in lines]
    for line, code in zip(lines, codes, strict=True):
        line[MESSAGE] = translated(line[MESSAGE], code, language)
    return _table(COLUMNS, lines, map(_is_error, codes))


def _parameters(controller: Controller, path: str) -> str:
    try:
        objects = [controller.tree.object(path)] if path else list(controller.tree.objects())
    except KeyError:
        return _shown(f"[no object {path}]")
    rows = [_parameter(owner, parameter) for owner in objects for parameter in owner.parameters]
    return _table(("Parameter", "Value", "Unit", "Meaning"), rows, (False for _ in rows))


def _parameter(owner: Object, parameter: Parameter) -> tuple[Value, ...]:
    return f"{owner.symbol or owner.name}.{parameter.name}", in_words(parameter), parameter.unit, parameter.about


def _table(columns: Iterable[str], rows: Iterable[Iterable[Value]], errors: Iterable[bool]) -> str:
    """Return a table.  Its cells have their heads as labels, because a narrow screen shows each row as a list."""
    heads = [_shown(column) for column in columns]
    head = "".join(f"<th>{text}</th>" for text in heads)
    body = "".join(_row(heads, row, is_error) for row, is_error in zip(rows, errors, strict=True))
    return f'<table class="rows">\n<tr>{head}</tr>\n{body}</table>'


def _row(heads: Iterable[str], cells: Iterable[Value], is_error: bool) -> str:
    start = '<tr class="error">' if is_error else "<tr>"
    columns = zip(heads, cells, strict=False)  # an entry of a program may have tabs
    return start + "".join(f'<td data-label="{head}">{_shown(cell)}</td>' for head, cell in columns) + "</tr>\n"


def _shown(value: Value) -> str:
    return escape(str(value))
