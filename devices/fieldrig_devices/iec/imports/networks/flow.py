"""The values that flow through a network: power behind contacts and coils, edges, and what is calculated once."""

from dataclasses import dataclass, field
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.imports.fragments import Fragments
from fieldrig_devices.iec.imports.networks import functions
from fieldrig_devices.iec.imports.networks.declarations import BOOL
from fieldrig_devices.iec.imports.networks.graph import Edge, Item, Kind, Network, Pin, Wire
from fieldrig_devices.iec.imports.networks.hidden import Hidden
from fieldrig_devices.iec.imports.networks.kinds import Kinds
from fieldrig_devices.iec.imports.networks.order import join_connectors
from fieldrig_devices.iec.imports.networks.terms import consuming, is_true, negated, parallel, position_of

IN_A_ROW: Final = 90
"""Elements that may depend on one another, one behind the other."""
HIGHEST: Final = 40
"""Levels of an expression; the value of a longer row is put into a hidden variable.  The parser allows 64."""
_PASSIVE: Final = (Kind.RIGHT_RAIL, Kind.CONNECTOR)
"""Elements that take a wire without consuming its value."""


@dataclass(slots=True)
class Flow:
    """One network, with the values that flow through it."""

    network: Network
    fragments: Fragments
    hidden: Hidden
    kinds: Kinds
    out: list[tree.AnyStatement] = field(default_factory=list)
    items: dict[str, Item] = field(default_factory=dict)
    consumers: dict[str, list[tuple[Item, Pin, Wire]]] = field(default_factory=dict)
    """The consumers of the outputs of an element; right rails do not count."""
    values: dict[Wire, tree.Expression] = field(default_factory=dict)
    """Values that are calculated once."""
    own: dict[tuple[Wire, str], tree.Expression] = field(default_factory=dict)
    """Values of these for the consumers, by their identifiers, that want the result in another type than the first."""
    started: set[str] = field(default_factory=set)
    finished: set[str] = field(default_factory=set)
    written: set[str] = field(default_factory=set)
    """Variables that a block with EN has written in its condition."""
    loops: dict[Wire, tree.Name] = field(default_factory=dict)
    """Hidden variables for values of the previous cycle."""
    depth: int = 0
    failed: set[str] = field(default_factory=set)
    """Contacts and coils whose power has a mistake in front of it, so that it is looked for once only."""
    is_given_up: bool = False
    """True after a message that the network is too deep, so that nothing is tried again."""
    order: int = 0
    """The order that the author has set for the element that is executed."""

    def __post_init__(self) -> None:
        join_connectors(self.network.items)
        for item in self.network.items:
            if item.id in self.items:
                self.mistake(item.line, f"Element {item.id} is there twice", "a unique identifier")
            self.items[item.id] = item
            if item.kind not in _PASSIVE:
                for pin in consuming(item):
                    for wire in pin.wires:
                        self.consumers.setdefault(wire.source, []).append((item, pin, wire))

    def execute(self, item: Item) -> None:
        """Execute an element, once."""
        raise NotImplementedError

    def output(self, item: Item, wire: Wire) -> tree.Expression | None:
        """Return the value of an output of a block."""
        raise NotImplementedError

    # ---- values

    def power(self, item: Item) -> tree.Expression | None:
        """Return what arrives at a contact, coil, variable, jump or return: several wires are parallel branches."""
        powers = [value for pin in item.inputs if (value := self.input(pin, item)) is not None]
        if not any(pin.wires or pin.expression for pin in item.inputs):
            self.mistake(item.line, f"The input of the {item} is not connected", "a wire from an element or a rail")
        return parallel(powers, item.line) if powers else None

    def input(self, pin: Pin, owner: Item) -> tree.Expression | None:
        """The value at a pin, with its negation and edge; None without a wire, or with a message."""
        if self.depth >= IN_A_ROW and not self.is_given_up:
            self.is_given_up = True
            self.mistake(owner.line, f"The {owner} has more than {IN_A_ROW} elements in a row in front of it")
        if self.is_given_up:
            return None
        self.depth += 1
        try:
            if pin.expression and not pin.wires:
                value = self.fragments.expression(pin.expression, pin.line)
            else:
                values = [wired for wire in pin.wires if (wired := self.value(wire, owner)) is not None]
                value = parallel(values, pin.line) if values else None
        finally:
            self.depth -= 1
        if value is None:
            return None
        if pin.is_negated:
            value = negated(value)
        return self.edge(value, pin.edge, owner)

    def value(self, wire: Wire, owner: Item) -> tree.Expression | None:
        """Return what flows through the wire."""
        item = self.items.get(wire.source)
        if item is None:
            self.mistake(owner.line, f"The {owner} is connected to element {wire.source[:30]}, which is not there")
            return None
        known = self.own.get((wire, owner.id)) or self.values.get(wire)
        if known is not None:
            return known
        match item.kind:
            case Kind.LEFT_RAIL:
                return tree.Literal(tree.LiteralKind.BOOL, True, "TRUE", position=position_of(item))
            case Kind.SOURCE:
                return self._source(item)
            case Kind.CONTACT | Kind.COIL:
                return self._power(item)
            case Kind.THROUGH | Kind.SINK:
                return self._through(item)
            case Kind.BLOCK:
                return self.output(item, wire)
            case Kind.STEP:
                return tree.Member(tree.Name(item.text, position=position_of(item)), "x", position=position_of(item))
            case Kind.CONTINUATION:
                self.mistake(item.line, f"The {item} has no connector", f"a connector with the name {item.text[:30]}")
            case _:
                self.mistake(owner.line, f"The {owner} cannot be connected to a {item.kind.value}")
        return None

    def _source(self, item: Item) -> tree.Expression | None:
        value = self.fragments.expression(item.text, item.line)
        if value is None:
            return None
        return self.edge(negated(value) if item.is_negated else value, item.edge, item)

    def _through(self, item: Item) -> tree.Expression | None:
        if not self.is_later(item):
            self.execute(item)
        value = self.fragments.expression(item.text, item.line)
        return negated(value) if value is not None and item.is_negated_behind else value

    def _power(self, item: Item) -> tree.Expression | None:
        """The power behind a contact or coil; calculated once if several elements consume it."""
        if Wire(item.id) in self.values:
            return self.values[Wire(item.id)]
        power = None if item.id in self.failed else self._new_power(item)
        if power is None:
            self.failed.add(item.id)
        return power

    def _new_power(self, item: Item) -> tree.Expression | None:
        if item.kind is Kind.COIL and item.id not in self.finished:
            if item.id in self.started:
                self.mistake(item.line, f"The {item} is part of a loop of contacts", "a loop through a variable")
                return None
            self.execute(item)
        if item.id in self.started and item.kind is Kind.CONTACT:
            self.mistake(item.line, f"The {item} is part of a loop of contacts", "a loop through a variable")
            return None
        if item.kind is Kind.CONTACT:
            self.started.add(item.id)
        power = self.power(item)
        if power is not None and item.kind is Kind.CONTACT:
            power = self._contact(item, power)
        if item.kind is Kind.CONTACT:
            self.started.discard(item.id)
        if power is None:
            return None
        is_shared = len(self.consumers.get(item.id, ())) > 1 and not isinstance(power, tree.Literal)
        if is_shared or functions.height(power) > HIGHEST:
            return self.shared(Wire(item.id), "Power", power, BOOL, item)
        return power

    def _contact(self, item: Item, power: tree.Expression) -> tree.Expression | None:
        operand = self.fragments.expression(item.text, item.line)
        if operand is None:
            return None
        if item.is_negated:
            operand = negated(operand)
        operand = self.edge(operand, item.edge, item)
        return operand if is_true(power) else tree.Binary("AND", power, operand, position=position_of(item))

    def edge(self, value: tree.Expression, edge: Edge, item: Item) -> tree.Expression:
        if edge is Edge.NONE:
            return value
        if not self.hidden.has_memory:
            self.mistake(item.line, f"The {item} has an edge, and a function has no memory for it")
            return value
        now = value
        if not isinstance(value, tree.Name):
            now = self.hidden.add("Now", BOOL, item.line, f"now, at the {item}")
            self.put(tree.Assign(now, value, position=position_of(item)))
        old = self.hidden.add("Before", BOOL, item.line, f"one cycle ago, at the {item}")
        pulse = self.hidden.add("Edge", BOOL, item.line, f"{edge.name.lower()} edge at the {item}")
        first, second = (now, old) if edge is Edge.RISING else (old, now)
        both = tree.Binary("AND", first, negated(second), position=position_of(item))
        self.put(tree.Assign(pulse, both, position=position_of(item)))
        self.put(tree.Assign(old, now, position=position_of(item)))
        return pulse

    def shared(self, wire: Wire, what: str, value: tree.Expression, node: tree.TypeSpec, item: Item) -> tree.Name:
        name = self.hidden.add(what, node, item.line, f"behind the {item}")
        self.put(tree.Assign(name, value, position=position_of(item)))
        self.values[wire] = name
        return name

    def is_later(self, item: Item) -> bool:
        """True if the author has put the element behind the one that is executed now."""
        return bool(item.order and self.order and item.order > self.order)

    def put(self, statement: tree.AnyStatement) -> None:
        self.out.append(statement)

    def mistake(self, line: int, what: str, expected: str = "", hint: str = "") -> None:
        self.fragments.report.mistake(line, what, expected, hint)
