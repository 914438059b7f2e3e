"""Bodies of IEC 61131-10: networks and rungs of typed objects, whose wires refer to numbered output points.

Source: the schema of edition 1.0 (2019) by its public facts, and documents of tools that follow it.  The schema itself
is not free, and no document with an SFC body is public: charts are read by analogy with TC6, its ancestor.
"""

from dataclasses import dataclass, field
from typing import Final

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
    Element,
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

_KINDS: Final = {
    "datasource": Kind.SOURCE, "datasink": Kind.SINK, "block": Kind.BLOCK, "jump": Kind.JUMP, "return": Kind.RETURN,
    "contact": Kind.CONTACT, "coil": Kind.COIL, "leftpowerrail": Kind.LEFT_RAIL, "rightpowerrail": Kind.RIGHT_RAIL,
    "comment": Kind.COMMENT, "connector": Kind.CONNECTOR, "continuation": Kind.CONTINUATION, "cfcjump": Kind.JUMP,
    "cfclabel": Kind.LABEL, "step": Kind.STEP, "transition": Kind.TRANSITION, "jumpstep": Kind.JUMP_STEP,
    "selectiondivergence": Kind.SELECTION_DIVERGENCE, "selectionconvergence": Kind.SELECTION_CONVERGENCE,
    "simultaneousdivergence": Kind.SIMULTANEOUS_DIVERGENCE, "simultaneousconvergence": Kind.SIMULTANEOUS_CONVERGENCE,
    "actionblock": Kind.ACTIONS, "actionblocks": Kind.ACTIONS,
}  # fmt: skip
_TEXTS: Final = {
    Kind.SOURCE: ("identifier",), Kind.SINK: ("identifier",), Kind.BLOCK: ("typeName",), Kind.CONTACT: ("operand",),
    Kind.COIL: ("operand",), Kind.JUMP: ("targetNetworkLabel", "targetLabel"), Kind.LABEL: ("label",),
    Kind.CONNECTOR: ("label",), Kind.CONTINUATION: ("label",), Kind.STEP: ("name",), Kind.JUMP_STEP: ("targetName",),
    Kind.SIMULTANEOUS_DIVERGENCE: ("name",),
}  # fmt: skip
_EDGES: Final = {"rising": Edge.RISING, "falling": Edge.FALLING}
_LATCHES: Final = {"set": Storage.SET, "reset": Storage.RESET}
_VALUES: Final = {
    "negated": TRUTHS, "initialStep": TRUTHS, "edge": ("none", *_EDGES), "latch": ("none", *_LATCHES),
}  # fmt: skip
"""The values of the attributes that change what an element does."""
_OBJECTS: Final = ("CommonObject", "FbdObject", "LdObject", "SfcObject")


def type_of(node: Element | None) -> str:
    """The local part of `xsi:type`, in small letters."""
    name = "" if node is None else node.get("{http://www.w3.org/2001/XMLSchema-instance}type", "")
    return name.rpartition(":")[2].strip().casefold()


def read_bodies(node: Element, report: Report) -> list[Drawn]:
    """The contents of a body, in the order in which they are evaluated."""
    bodies = elements(node, "BodyContent") or [
        inner for child in elements(node) for inner in elements(child, "BodyContent")
    ]
    contents = sorted(bodies, key=lambda content: number(content, "evaluationOrder") or 0)
    return [drawn for content in contents if (drawn := _content(content, report)) is not None]


def _content(node: Element, report: Report) -> Drawn | None:
    line, kind = line_of(node), type_of(node)
    match kind:
        case "st" | "il":
            inner = element(node, kind)
            text, first = formatted_text(node if inner is None else inner)
            return Drawn(kind.upper(), first, text)
        case "ld" | "fbd" | "ldsection" | "fbdsection":
            networks = [Reader(report).network(parts) for parts in _in_order(node)]
            return Drawn("LD" if kind.startswith("ld") else "FBD", line, networks=networks, is_divided=True)
        case "sfc":
            parts = _in_order(node)
            return Drawn("SFC", line, networks=[Reader(report).network(parts[0] if parts else node)], is_divided=True)
    report.mistake(line, f"The body has the type {kind[:40] or 'nothing'}", "ST, IL, LD, FBD or SFC")
    return None


def _in_order(node: Element) -> list[Element]:
    return sorted(elements(node, "Network", "Rung"), key=lambda network: number(network, "evaluationOrder") or 0)


@dataclass(slots=True)
class Reader:
    """Reads one network, whose output points have numbers of their own."""

    report: Report
    outputs: dict[str, Wire] = field(default_factory=dict)
    points: list[tuple[Pin, Element]] = field(default_factory=list)
    """Consuming points, to be connected when all outputs are known."""
    items: list[Item] = field(default_factory=list)
    identifiers: set[str] = field(default_factory=set)

    def network(self, node: Element) -> Network:
        for child in elements(node, *_OBJECTS):
            self._object(child)
        for pin, point in self.points:
            pin.wires = tuple(dict.fromkeys(self._wires(pin, point)))
        comments = text_of(element(node, "Documentation")).strip()
        texts = (f"(* {comments.replace('*)', '* )')} *)",) if comments else ()
        return Network(self.items, attribute(node, "label").strip(), line_of(node), texts)

    def _wires(self, pin: Pin, point: Element) -> list[Wire]:
        wires: list[Wire] = []
        for connection in elements(point, "Connection", "FeedbackConnection"):
            wire = self.outputs.get(attribute(connection, "refConnectionPointOutId").strip())
            variable = attribute(connection, "feedbackVariable").strip()
            if wire is None:
                number_ = attribute(connection, "refConnectionPointOutId")[:30]
                self.report.mistake(line_of(connection), f"The output point {number_} is not there")
            elif variable:
                # The variable takes the value in each cycle, and the consumer reads what it took in the previous one.
                line = line_of(connection)
                sink = Item(
                    Kind.SINK, f"feedback {len(self.items)}", line, variable, inputs=[Pin(line=line, wires=(wire,))]
                )
                self.items.append(sink)
                pin.expression = variable
            else:
                wires.append(wire)
        return wires

    def _object(self, node: Element) -> None:
        kind, line = _KINDS.get(type_of(node)), line_of(node)
        if kind is None:
            if type_of(node) != "unconnected":
                what = f"The object of type {type_of(node)[:40] or 'nothing'} is known only to the tool that wrote it"
                self.report.mistake(line, what, hint="Replace it by standard elements in the tool, and export again.")
            return
        item = Item(
            kind,
            self._unique(attribute(node, "globalId").strip() or f"of line {line}"),
            line,
            self._text(node, kind),
            is_negated=is_set(node, "negated") or self._is_negated_by_vendor(node),
            edge=_EDGES.get(word(node, "edge"), Edge.NONE),
            storage=_LATCHES.get(word(node, "latch"), Storage.NONE),
            order=self._order(node),
            x=number(element(node, "RelPosition"), "x") or 0.0,
            y=number(element(node, "RelPosition"), "y") or 0.0,
            inputs=[self._pin(point) for point in elements(node, "ConnectionPointIn")],
        )
        refuse_unknown(node, _VALUES, item, self.report)
        self.items.append(item)
        for point in elements(node, "ConnectionPointOut", "ConnectionPointOutAction"):
            self.outputs[attribute(point, "connectionPointOutId").strip()] = Wire(item.id)
        match kind:
            case Kind.BLOCK:
                self._block(node, item)
            case Kind.STEP:
                item.is_initial = is_set(node, "initialStep")
            case Kind.TRANSITION:
                self._transition(node, item)
            case Kind.ACTIONS:
                item.uses = [self._use(action) for action in elements(node, "Action", "ActionAssociation")]

    def _unique(self, identifier: str) -> str:
        """The identifier, with a number behind it if several elements have it."""
        unique = identifier if identifier not in self.identifiers else f"{identifier} #{len(self.items)}"
        self.identifiers.add(unique)
        return unique

    def _text(self, node: Element, kind: Kind) -> str:
        if kind is Kind.COMMENT:
            return text_of(element(node, "Content")).strip()
        return next((text.strip() for name in _TEXTS.get(kind, ()) if (text := attribute(node, name))), "")

    def _order(self, node: Element) -> int:
        """The evaluation priority that one vendor adds, from 0."""
        added = next((e for e in node.iter() if name_of(e) == "EvaluationPriority"), None)
        priority = number(added, "priorityInNetwork")
        return 0 if priority is None or priority < 0 else int(priority) + 1

    def _is_negated_by_vendor(self, node: Element) -> bool:
        added = element(node, "AddData")
        return added is not None and any(name_of(e) == "negated" and is_set(e, "value") for e in added.iter())

    def _pin(self, point: Element) -> Pin:
        pin = Pin(line=line_of(point))
        self.points.append((pin, point))
        return pin

    def _block(self, node: Element, item: Item) -> None:
        item.instance = attribute(node, "instanceName").strip()
        item.inputs = self._parameters(node, item, "InputVariables", "InputVariable")
        item.in_outs = self._parameters(node, item, "InOutVariables", "InOutVariable")
        item.outputs = self._parameters(node, item, "OutputVariables", "OutputVariable")
        if not item.text:
            self.report.mistake(item.line, "The block has no type")

    def _parameters(self, node: Element, item: Item, group: str, name: str) -> list[Pin]:
        pins: list[Pin] = []
        for variable in elements(element(node, group), name):
            point = element(variable, "ConnectionPointIn")
            pin = Pin(line=line_of(variable)) if point is None else self._pin(point)
            pin.name = attribute(variable, "parameterName").strip()
            refuse_unknown(variable, _VALUES, item, self.report)
            pin.is_negated = is_set(variable, "negated")
            pin.edge = _EDGES.get(word(variable, "edge"), Edge.NONE)
            for out in elements(variable, "ConnectionPointOut"):
                self.outputs[attribute(out, "connectionPointOutId").strip()] = Wire(item.id, pin.name)
            pins.append(pin)
        return pins

    def _transition(self, node: Element, item: Item) -> None:
        priority = number(node, "priority")
        item.priority = None if priority is None else int(priority)
        condition = element(node, "Condition")
        inner = next(iter(elements(condition, "Reference", "Inline", "ConnectionPointIn", "BodyContent")), None)
        if inner is None:
            return
        item.condition = Condition(line_of(inner), is_negated=is_set(condition, "negated"))
        match name_of(inner):
            case "Reference":
                item.condition.name = attribute(inner, "name").strip()
            case "ConnectionPointIn":
                item.condition.pin = self._pin(inner)
            case _:
                item.condition.body = next(iter(read_bodies(inner, self.report)), None)

    def _use(self, node: Element) -> Use:
        reference, inline = element(node, "Reference"), element(node, "Inline")
        name = attribute(reference, "name") or attribute(node, "actionName")
        body = None if inline is None else next(iter(read_bodies(inline, self.report)), None)
        return Use(line_of(node), attribute(node, "qualifier", "N"), attribute(node, "duration"), name.strip(), body)
