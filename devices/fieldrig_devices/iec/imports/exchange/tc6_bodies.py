"""Bodies of PLCopen TC6: text, networks and charts, as elements with wires.

Version 2.01 of the schema, and what is known of its writers: coordinates that are missing or all zero, the networks of
the CODESYS family that begin with a `vendorElement`, operands at pins, `???` for an empty operand, boxes with code.
"""

from collections.abc import Callable
from typing import Final

from lxml import etree

from fieldrig_devices.iec.imports.exchange.macro_steps import resolved
from fieldrig_devices.iec.imports.networks.graph import (
    Condition,
    Drawn,
    Edge,
    Item,
    Kind,
    Network,
    Pin,
    Storage,
    Use,
    Wire,
)
from fieldrig_devices.iec.imports.report import Report
from fieldrig_devices.iec.imports.xml import (
    TRUTHS,
    attribute,
    element,
    elements,
    formatted_text,
    is_set,
    line_of,
    name_of,
    number,
    refuse_unknown,
    text_of,
    word,
)  # fmt: skip

Element = etree._Element

LANGUAGES: Final = ("IL", "ST", "FBD", "LD", "SFC")
EXPORT: Final = "Convert the body to ST, LD, FBD, IL or SFC in the tool, and export it again."

_KINDS: Final = {
    "invariable": Kind.SOURCE, "outvariable": Kind.SINK, "inoutvariable": Kind.THROUGH, "block": Kind.BLOCK,
    "contact": Kind.CONTACT, "coil": Kind.COIL, "leftpowerrail": Kind.LEFT_RAIL, "rightpowerrail": Kind.RIGHT_RAIL,
    "label": Kind.LABEL, "jump": Kind.JUMP, "return": Kind.RETURN, "connector": Kind.CONNECTOR,
    "continuation": Kind.CONTINUATION, "comment": Kind.COMMENT, "step": Kind.STEP, "transition": Kind.TRANSITION,
    "jumpstep": Kind.JUMP_STEP, "selectiondivergence": Kind.SELECTION_DIVERGENCE,
    "selectionconvergence": Kind.SELECTION_CONVERGENCE, "simultaneousdivergence": Kind.SIMULTANEOUS_DIVERGENCE,
    "simultaneousconvergence": Kind.SIMULTANEOUS_CONVERGENCE, "actionblock": Kind.ACTIONS,
}  # fmt: skip
_OPERANDS: Final = {
    Kind.SOURCE: "expression", Kind.SINK: "expression", Kind.THROUGH: "expression", Kind.CONTACT: "variable",
    Kind.COIL: "variable", Kind.COMMENT: "content",
}  # fmt: skip
_NAMES: Final = {
    Kind.LABEL: "label", Kind.JUMP: "label", Kind.CONNECTOR: "name", Kind.CONTINUATION: "name", Kind.STEP: "name",
    Kind.JUMP_STEP: "targetName", Kind.BLOCK: "typeName", Kind.SIMULTANEOUS_DIVERGENCE: "name",
}  # fmt: skip
_EDGES: Final = {"rising": Edge.RISING, "falling": Edge.FALLING}
_STORAGES: Final = {"set": Storage.SET, "reset": Storage.RESET}
_VALUES: Final = {
    "negated": TRUTHS, "negatedIn": TRUTHS, "negatedOut": TRUTHS, "initialStep": TRUTHS,
    "edge": ("none", *_EDGES), "edgeIn": ("none", *_EDGES), "edgeOut": ("none", *_EDGES),
    "storage": ("none", *_STORAGES), "storageIn": ("none", *_STORAGES), "storageOut": ("none", *_STORAGES),
}  # fmt: skip
"""The values of the attributes that change what an element does."""
_EMPTY: Final = ("", "???")
_PHASES: Final = {
    "a6b08bd8-b696-47e3-9cbf-7408b61c9ff8": "entry",
    "700a583f-b4d4-43e4-8c14-629c7cd3bec8": "active",
    "a2621e18-7de3-4ea6-ae6d-89e9e0b7befd": "exit",
}
"""Attributes of a step in the CODESYS family that name its actions."""


def read_body(node: Element, report: Report) -> Drawn | None:
    """A `body` or `inline` element; None with a message."""
    inner = next((child for child in elements(node) if name_of(child).upper() in LANGUAGES), None)
    line = line_of(node)
    if any(name_of(drawing).upper() == "CFC" for drawing in node.iter()):
        report.mistake(line, "The body is a continuous function chart, which is not part of the standard", hint=EXPORT)
        return None
    if inner is None:
        if elements(node):
            report.mistake(line, "The body has no known language", ", ".join(LANGUAGES), EXPORT)
        return Drawn("ST", line)
    language = name_of(inner).upper()
    if language in ("ST", "IL"):
        text, first = formatted_text(inner)
        return Drawn(language, first, text)
    network = Network(_items(inner, report), line=line_of(inner))
    return Drawn(language, line_of(inner), networks=[network])


def _items(node: Element, report: Report) -> list[Item]:
    items: list[Item] = []
    for child in elements(node):
        if name_of(child).casefold() == "macrostep":
            items += _macro_step(child, report)
        elif (item := _item(child, report)) is not None:
            items.append(item)
    empty = {item.id for item in items if item.kind is Kind.SOURCE and item.text.strip() in _EMPTY}
    for item in items:
        for pin in item.pins():
            pin.wires = tuple(wire for wire in pin.wires if wire.source not in empty)
    return [item for item in items if item.kind is not Kind.SOURCE or item.id not in empty]


def _macro_step(node: Element, report: Report) -> list[Item]:
    inner = element(element(node, "body"), "SFC")
    items = [] if inner is None else _items(inner, report)
    before = [_pin(point) for point in elements(node, "connectionPointIn")]
    return resolved(attribute(node, "name"), attribute(node, "localId"), line_of(node), before, items, report)


def _item(node: Element, report: Report) -> Item | None:
    name = name_of(node).casefold()
    kind = _KINDS.get(name)
    line = line_of(node)
    if kind is None:
        return _other(node, name, line, report)
    item = Item(
        kind,
        attribute(node, "localId"),
        line,
        _text(node, kind),
        order=max(0, int(number(node, "executionOrderId") or 0)),
        x=number(element(node, "position"), "x") or 0.0,
        y=number(element(node, "position"), "y") or 0.0,
        is_negated=is_set(node, "negated") or is_set(node, "negatedIn"),
        is_negated_behind=is_set(node, "negatedOut"),
        edge=_EDGES.get(word(node, "edge") or word(node, "edgeIn"), Edge.NONE),
        storage=_STORAGES.get(word(node, "storage") or word(node, "storageIn"), Storage.NONE),
        inputs=[_pin(point) for point in elements(node, "connectionPointIn")],
    )
    _refuse_values(node, item, report)
    _refuse_modifiers(node, item, report)
    extra = _EXTRA.get(kind)
    if extra is not None:
        extra(node, item, report)
    return item


def _refuse_values(node: Element, item: Item, report: Report) -> None:
    """Values that the schema does not know, of an element and of its pins."""
    lists = [element(node, name) for name in ("inputVariables", "inOutVariables", "outputVariables")]
    pins = [pin for variables in lists for pin in elements(variables, "variable")]
    for part in (node, *pins, *elements(node, "condition")):
        refuse_unknown(part, _VALUES, item, report)


def _refuse_modifiers(node: Element, item: Item, report: Report) -> None:
    """Edges and storage where no tool draws them: behind a variable, and at the outputs of a block."""
    outputs = elements(element(node, "outputVariables"), "variable")
    pins = [*elements(element(node, "inputVariables"), "variable"), *outputs]
    modifiers = [word(node, "edgeOut"), word(node, "storageOut")]
    modifiers += [word(pin, "edge") for pin in outputs] + [word(pin, "storage") for pin in pins]
    for modifier in modifiers:
        if modifier in _EDGES or modifier in _STORAGES:
            report.mistake(
                item.line,
                f"The {item} has the modifier {modifier} at an output or a pin",
                "edges at inputs, and set or reset at variables and coils",
                "Use R_TRIG, F_TRIG, SR or RS.",
            )


def _text(node: Element, kind: Kind) -> str:
    if kind in _OPERANDS:
        return text_of(element(node, _OPERANDS[kind])).strip()
    return attribute(node, _NAMES[kind]).strip() if kind in _NAMES else ""


def _other(node: Element, name: str, line: int, report: Report) -> Item | None:
    identifier = attribute(node, "localId")
    if name == "vendorelement":
        types = [
            text_of(child).strip().casefold() for child in node.iter() if name_of(child).casefold() == "elementtype"
        ]
        if "networktitle" in types:
            return Item(Kind.TITLE, identifier, line, text_of(element(node, "alternativeText")).strip())
        if elements(element(node, "inputVariables")) or elements(element(node, "outputVariables")):
            report.mistake(line, f"Element {identifier} is known only to the tool that wrote it", hint=EXPORT)
    elif name == "error":
        report.mistake(line, f"Element {identifier} could not be exported: {text_of(node).strip()[:100]}")
    elif name not in ("adddata", "documentation"):
        report.note(line, f"The element {name_of(node)[:40]} is not known and is left out")
    return None


def _pin(point: Element) -> Pin:
    """The consuming side of an element."""
    operand = text_of(element(point, "expression")).strip()
    return Pin(line=line_of(point), wires=_wires(point), expression="" if operand in _EMPTY else operand)


def _wires(point: Element) -> tuple[Wire, ...]:
    wires = (Wire(attribute(c, "refLocalId"), attribute(c, "formalParameter")) for c in elements(point, "connection"))
    return tuple(dict.fromkeys(wires))


def _block(node: Element, item: Item, report: Report) -> None:
    item.instance = attribute(node, "instanceName").strip()
    item.inputs = [_variable(v) for v in elements(element(node, "inputVariables"), "variable")]
    item.in_outs = [_variable(v) for v in elements(element(node, "inOutVariables"), "variable")]
    item.outputs = [_variable(v) for v in elements(element(node, "outputVariables"), "variable")]
    for added in node.iter():
        match name_of(added).casefold():
            case "calltype":
                item.is_statement = text_of(added).strip().casefold() in ("program", "action", "method")
            case "stcode":
                item.code, item.code_line = formatted_text(added)
    if not item.text and not item.code:
        report.mistake(item.line, f"The block of element {item.id} has no type")


def _variable(node: Element) -> Pin:
    name = attribute(node, "formalParameter").strip()
    incoming, outgoing = element(node, "connectionPointIn"), element(node, "connectionPointOut")
    pin = _pin(incoming) if incoming is not None else Pin(line=line_of(node))
    if outgoing is not None and incoming is None:
        operand = text_of(element(outgoing, "expression")).strip()
        pin.expression = "" if operand in _EMPTY else operand
    pin.name, pin.is_negated = name, is_set(node, "negated")
    pin.edge = _EDGES.get(word(node, "edge"), Edge.NONE)
    return pin


def _step(node: Element, item: Item, report: Report) -> None:
    item.is_initial = is_set(node, "initialStep")
    for added in node.iter():
        phase = _PHASES.get(attribute(added, "guid").strip("{}").casefold()) if name_of(added) == "attribute" else None
        if phase is not None:
            item.phases[phase] = text_of(added).strip()


def _transition(node: Element, item: Item, report: Report) -> None:
    priority = number(node, "priority")
    item.priority = None if priority is None else int(priority)
    of_condition = element(node, "condition")
    inner = next(iter(elements(of_condition, "reference", "inline", "connectionPointIn")), None)
    if of_condition is None or inner is None:
        return
    item.condition = Condition(line_of(inner), is_negated=is_set(of_condition, "negated"))
    match name_of(inner).casefold():
        case "reference":
            item.condition.name = attribute(inner, "name").strip()
        case "inline":
            item.condition.body = read_body(inner, report)
        case _:
            item.condition.pin = _pin(inner)


def _actions(node: Element, item: Item, report: Report) -> None:
    for action in elements(node, "action"):
        inline = element(action, "inline")
        item.uses.append(
            Use(
                line_of(action),
                attribute(action, "qualifier", "N"),
                attribute(action, "duration"),
                attribute(element(action, "reference"), "name").strip(),
                None if inline is None else read_body(inline, report),
            )
        )


_EXTRA: Final[dict[Kind, Callable[[Element, Item, Report], None]]] = {
    Kind.BLOCK: _block,
    Kind.STEP: _step,
    Kind.TRANSITION: _transition,
    Kind.ACTIONS: _actions,
}
