"""Networks of ladder diagram and function block diagram become statements.

Source: PacDrive manual 4.4 (lines 1844 to 1913), PD-380; IEC 61131-3 for edges, and for what the manual's figures show.

- An element is executed where its first consumer needs it; the rest follows in the order of `order.in_order`.
- Power that several elements consume is calculated once, in a hidden variable.
- A wire that closes a loop carries the value of the previous cycle.
- A block with EN is executed only while EN is TRUE.  ENO is EN.  A variable at its output then keeps its value, as in
  CoDeSys V2.3; the result of a comparison is FALSE, because power does not flow through it.
- A rising edge is TRUE for one execution.  The first execution after the start compares with FALSE.
"""

from dataclasses import dataclass, field
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.imports.fragments import Fragments
from fieldrig_devices.iec.imports.networks import functions
from fieldrig_devices.iec.imports.networks.graph import Edge, Item, Kind, Network, Pin, Storage, Wire
from fieldrig_devices.iec.imports.networks.hidden import Hidden
from fieldrig_devices.iec.imports.networks.kinds import BOOL, Kinds, consumer_type
from fieldrig_devices.iec.imports.networks.order import in_order, join_connectors

IN_A_ROW: Final = 90
"""Elements that may depend on one another, one behind the other."""
HIGHEST: Final = 40
"""Levels of an expression; the value of a longer row is put into a hidden variable.  The parser allows 64."""

_ACTORS: Final = (Kind.SINK, Kind.THROUGH, Kind.COIL, Kind.BLOCK, Kind.LABEL, Kind.JUMP, Kind.RETURN)
_PASSIVE: Final = (Kind.RIGHT_RAIL, Kind.CONNECTOR)
"""Elements that take a wire without consuming its value."""


def translate(
    networks: list[Network], fragments: Fragments, hidden: Hidden, kinds: Kinds
) -> tuple[tree.AnyStatement, ...]:
    """The statements of the networks of one body."""
    statements: list[tree.AnyStatement] = []
    comments: tuple[str, ...] = ()
    for network in networks:
        hidden.network += 1
        with fragments.report.inside(f"network {hidden.network}"):
            found = Translation(network, fragments, hidden, kinds).statements()
        comments += network.comments + _comments(network)
        if found:
            found[0].comments = (*comments, *found[0].comments)
            comments = ()
        statements += found
    return tuple(statements)


def _comments(network: Network) -> tuple[str, ...]:
    texts = (item.text.strip() for item in network.items if item.kind in (Kind.COMMENT, Kind.TITLE))
    return tuple(f"(* {text.replace('(*', '( *').replace('*)', '* )')} *)" for text in texts if text)


@dataclass(slots=True)
class Translation:
    """One network."""

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
                self._mistake(item.line, f"Element {item.id} is there twice", "a unique identifier")
            self.items[item.id] = item
            if item.kind not in _PASSIVE:
                for pin in _consuming(item):
                    for wire in pin.wires:
                        self.consumers.setdefault(wire.source, []).append((item, pin, wire))

    def statements(self) -> list[tree.AnyStatement]:
        if self.network.label and self.fragments.is_name(self.network.label, self.network.line, "a label"):
            self._put(tree.Label(self.network.label, place=tree.Place(self.network.line, 1)))
        ordered = [item for item in in_order(self.network.items) if item.kind in _ACTORS]
        # A function is executed where its result is needed; what is left then has no result that anything needs.
        for item in (*(i for i in ordered if not self._is_demanded(i)), *ordered):
            self.order = item.order
            self.execute(item)
        for item in self.network.items:
            if item.kind is Kind.CONTACT and item.id not in self.consumers:
                self.fragments.report.note(item.line, f"The {item} leads to nothing")
        return self.out

    def _is_demanded(self, item: Item) -> bool:
        return item.kind is Kind.BLOCK and not item.instance and item.id in self.consumers

    def pure(self, pin: Pin, owner: Item) -> tree.Expression | None:
        """The value at a pin as an expression alone, for the condition of a transition; None with a message."""
        value = self.input(pin, owner)
        if self.out:
            self.out.clear()
            self._mistake(
                owner.line,
                f"The condition of the {owner} needs blocks or edges",
                "contacts, variables and functions",
                "Put the network into an action of the step, and test a variable that it sets.",
            )
            return None
        return value

    # ---- execution

    def execute(self, item: Item) -> None:
        if item.id in self.started:
            return
        self.started.add(item.id)
        match item.kind:
            case Kind.SINK | Kind.COIL:
                self._assign(item)
            case Kind.THROUGH if any(pin.wires for pin in item.inputs):
                self._assign(item)
            case Kind.BLOCK:
                self._block(item)
            case Kind.LABEL if self.fragments.is_name(item.text, item.line, "a label"):
                self._put(tree.Label(item.text, place=_place(item)))
            case Kind.JUMP if self.fragments.is_name(item.text, item.line, "a label"):
                self._leave(item, tree.Jump(item.text, place=_place(item)))
            case Kind.RETURN:
                self._leave(item, tree.Return(place=_place(item)))
        self.finished.add(item.id)

    def _leave(self, item: Item, statement: tree.AnyStatement) -> None:
        if not any(pin.wires or pin.expression for pin in item.inputs):
            self._put(statement)
            return
        condition = self.power(item)
        if condition is None:
            return
        if item.is_negated:
            condition = _negated(condition)
        self._put(statement if _is_true(condition) else _if(condition, [statement], item.line))

    def _assign(self, item: Item) -> None:
        target = self.fragments.place(item.text, item.line)
        value = self.power(item)
        if target is None or value is None or item.id in self.written:
            return
        if item.is_negated:
            value = _negated(value)
        value = self._edge(value, item.edge, item)
        if item.storage is Storage.NONE:
            self._put(tree.Assign(target, value, place=_place(item)))
            return
        constant = tree.Literal(tree.LiteralKind.BOOL, item.storage is Storage.SET, place=_place(item))
        self._put(_if(value, [tree.Assign(target, constant, place=_place(item))], item.line))

    # ---- values

    def power(self, item: Item) -> tree.Expression | None:
        """Return what arrives at a contact, coil, variable, jump or return: several wires are parallel branches."""
        found = [value for pin in item.inputs if (value := self.input(pin, item)) is not None]
        if not any(pin.wires or pin.expression for pin in item.inputs):
            self._mistake(item.line, f"The input of the {item} is not connected", "a wire from an element or a rail")
        return _any(found, item.line) if found else None

    def input(self, pin: Pin, owner: Item) -> tree.Expression | None:
        """The value at a pin, with its negation and edge; None without a wire, or with a message."""
        if self.depth >= IN_A_ROW and not self.is_given_up:
            self.is_given_up = True
            self._mistake(owner.line, f"The {owner} has more than {IN_A_ROW} elements in a row in front of it")
        if self.is_given_up:
            return None
        self.depth += 1
        try:
            if pin.expression and not pin.wires:
                value = self.fragments.expression(pin.expression, pin.line)
            else:
                values = [found for wire in pin.wires if (found := self.value(wire, owner)) is not None]
                value = _any(values, pin.line) if values else None
        finally:
            self.depth -= 1
        if value is None:
            return None
        if pin.is_negated:
            value = _negated(value)
        return self._edge(value, pin.edge, owner)

    def value(self, wire: Wire, owner: Item) -> tree.Expression | None:
        """Return what flows through the wire."""
        item = self.items.get(wire.source)
        if item is None:
            self._mistake(owner.line, f"The {owner} is connected to element {wire.source[:30]}, which is not there")
            return None
        if wire in self.values:
            return self.values[wire]
        match item.kind:
            case Kind.LEFT_RAIL:
                return tree.Literal(tree.LiteralKind.BOOL, True, "TRUE", place=_place(item))
            case Kind.SOURCE:
                return self._source(item)
            case Kind.CONTACT | Kind.COIL:
                return self._power(item)
            case Kind.THROUGH | Kind.SINK:
                return self._through(item)
            case Kind.BLOCK:
                return self._output(item, wire)
            case Kind.STEP:
                return tree.Member(tree.Name(item.text, place=_place(item)), "x", place=_place(item))
            case Kind.CONTINUATION:
                self._mistake(item.line, f"The {item} has no connector", f"a connector with the name {item.text[:30]}")
            case _:
                self._mistake(owner.line, f"The {owner} cannot be connected to a {item.kind.value}")
        return None

    def _source(self, item: Item) -> tree.Expression | None:
        value = self.fragments.expression(item.text, item.line)
        if value is None:
            return None
        return self._edge(_negated(value) if item.is_negated else value, item.edge, item)

    def _through(self, item: Item) -> tree.Expression | None:
        if not self._is_later(item):
            self.execute(item)
        value = self.fragments.expression(item.text, item.line)
        return _negated(value) if value is not None and item.is_negated_behind else value

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
                self._mistake(item.line, f"The {item} is part of a loop of contacts", "a loop through a variable")
                return None
            self.execute(item)
        if item.id in self.started and item.kind is Kind.CONTACT:
            self._mistake(item.line, f"The {item} is part of a loop of contacts", "a loop through a variable")
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
            return self._shared(Wire(item.id), "Power", power, BOOL, item)
        return power

    def _contact(self, item: Item, power: tree.Expression) -> tree.Expression | None:
        operand = self.fragments.expression(item.text, item.line)
        if operand is None:
            return None
        if item.is_negated:
            operand = _negated(operand)
        operand = self._edge(operand, item.edge, item)
        return operand if _is_true(power) else tree.Binary("AND", power, operand, place=_place(item))

    def _edge(self, value: tree.Expression, edge: Edge, item: Item) -> tree.Expression:
        if edge is Edge.NONE:
            return value
        if not self.hidden.has_memory:
            self._mistake(item.line, f"The {item} has an edge, and a function has no memory for it")
            return value
        now = value
        if not isinstance(value, tree.Name):
            now = self.hidden.add("Now", BOOL, item.line, f"now, at the {item}")
            self._put(tree.Assign(now, value, place=_place(item)))
        old = self.hidden.add("Before", BOOL, item.line, f"one cycle ago, at the {item}")
        pulse = self.hidden.add("Edge", BOOL, item.line, f"{edge.name.lower()} edge at the {item}")
        first, second = (now, old) if edge is Edge.RISING else (old, now)
        both = tree.Binary("AND", first, _negated(second), place=_place(item))
        self._put(tree.Assign(pulse, both, place=_place(item)))
        self._put(tree.Assign(old, now, place=_place(item)))
        return pulse

    def _shared(self, wire: Wire, what: str, value: tree.Expression, of: tree.TypeSpec, item: Item) -> tree.Name:
        name = self.hidden.add(what, of, item.line, f"behind the {item}")
        self._put(tree.Assign(name, value, place=_place(item)))
        self.values[wire] = name
        return name

    # ---- blocks

    def _block(self, item: Item) -> None:
        is_declared = self.kinds.parameter(item.text, "EN") is not None
        enable: tree.Expression | None = None
        arguments: list[tuple[Pin, tree.Expression | None]] = []
        for pin in item.pins():
            value = self.input(pin, item) if pin.wires or pin.expression else None
            if pin.name.casefold() == "en" and not is_declared:
                enable = None if value is None or _is_true(value) else value
            else:
                arguments.append((pin, value))
        if enable is not None:
            enable = self._shared(Wire(item.id, "ENO"), "Enable", enable, BOOL, item)
        if item.code:
            self._guarded(enable, self._code(item), item)
        elif item.instance:
            self._instance(item, enable, arguments)
        else:
            self._function(item, enable, arguments)

    def _guarded(self, enable: tree.Expression | None, statements: list[tree.AnyStatement], item: Item) -> None:
        if enable is None or not statements:
            self.out += statements
        else:
            self._put(_if(enable, statements, item.line))

    def _code(self, item: Item) -> list[tree.AnyStatement]:
        body = self.fragments.body(item.code, item.code_line, "ST")
        return list(body.statements) if isinstance(body, tree.StBody) else []

    def _instance(
        self, item: Item, enable: tree.Expression | None, arguments: list[tuple[Pin, tree.Expression | None]]
    ) -> None:
        called = self.fragments.place(item.instance, item.line)
        if called is None:
            return
        given = tuple(
            tree.Argument(value, pin.name, place=tree.Place(pin.line, 1))
            for pin, value in arguments
            if value is not None
        )
        call = tree.Call(called, given, place=_place(item))
        self._guarded(enable, [tree.CallStatement(call, place=_place(item)), *self._written(item, called)], item)

    def _written(self, item: Item, called: tree.Expression) -> list[tree.AnyStatement]:
        """Variables that are written at the outputs of an instance themselves, without an element of their own."""
        found: list[tree.AnyStatement] = []
        for pin in item.outputs:
            target = self.fragments.place(pin.expression, pin.line) if pin.expression else None
            if target is not None:
                value: tree.Expression = tree.Member(called, pin.name, place=_place(item))
                value = _negated(value) if pin.is_negated else value
                found.append(tree.Assign(target, value, place=tree.Place(pin.line, 1)))
        return found

    def _function(
        self, item: Item, enable: tree.Expression | None, arguments: list[tuple[Pin, tree.Expression | None]]
    ) -> None:
        outputs = [pin for pin in item.outputs if pin.name.casefold() != "eno"]
        result = outputs[0] if outputs and not item.is_statement else None
        extra = outputs[1:] if result else outputs
        call = self._call(item, arguments, extra)
        if call is None:
            return
        if result is None or not (self._consumers(item) or any(pin.expression for pin in outputs)):
            if not functions.is_standard(item.text):
                self._guarded(enable, self._call_statement(item, call, result), item)
            return
        wire = Wire(item.id, result.name)
        if isinstance(call, tree.Binary) and call.operator in functions.COMPARISONS and enable is not None:
            call, enable = tree.Binary("AND", enable, call, place=_place(item)), None
        if result.expression:
            self._written_result(item, enable, call, result)
        elif self._is_inline(item, wire, enable, extra, call):
            self.values[wire] = _negated(call) if result.is_negated else call
        elif (sink := self._only_sink(item)) is not None and enable is not None:
            self.started.add(sink.id)
            self.written.add(sink.id)
            target = self.fragments.place(sink.text, sink.line)
            value = _negated(call) if result.is_negated != sink.is_negated else call
            if target is not None:
                self._guarded(enable, [tree.Assign(target, value, place=_place(sink))], item)
        else:
            self._kept_result(item, wire, enable, call, result)

    def _call_statement(self, item: Item, call: tree.Expression, result: Pin | None) -> list[tree.AnyStatement]:
        if isinstance(call, tree.Call):
            return [tree.CallStatement(call, place=_place(item))]
        return []

    def _consumers(self, item: Item) -> list[tuple[Item, Pin]]:
        """Return the consumers of a block, besides those of ENO."""
        found = self.consumers.get(item.id, [])
        return [(other, pin) for other, pin, wire in found if wire.pin.casefold() != "eno"]

    def _call(
        self, item: Item, arguments: list[tuple[Pin, tree.Expression | None]], extra: list[Pin]
    ) -> tree.Expression | None:
        """The call of a function, or the operation of an operator."""
        name, place = item.text, _place(item)
        given = [value for _, value in arguments if value is not None]
        operator = functions.OPERATORS.get(name.casefold())
        unary = name.casefold() in ("not", "move")
        if operator or unary:
            if len(given) < (1 if unary else 2) or len(given) < len(arguments):
                self._mistake(item.line, f"An input of the {item} is not connected")
                return None
            if operator and len(given) > HIGHEST and operator not in ("AND", "OR", "XOR"):
                self._mistake(item.line, f"The {item} has {len(given)} inputs", f"at most {HIGHEST}")
                return None
            if operator:
                return functions.operation(operator, given, place)
            return _negated(given[0]) if name.casefold() == "not" else given[0]
        called = self.fragments.place(name, item.line)
        if called is None:
            return None
        is_named = bool(extra) or len(given) < len(arguments)
        passed = [
            tree.Argument(value, pin.name if is_named else "", place=tree.Place(pin.line, 1))
            for pin, value in arguments
            if value is not None
        ]
        for pin in extra:
            variable = self._extra_output(item, pin)
            if variable is not None:
                passed.append(tree.Argument(variable, pin.name, is_output=True, place=tree.Place(pin.line, 1)))
        return tree.Call(called, tuple(passed), place=place)

    def _extra_output(self, item: Item, pin: Pin) -> tree.Expression | None:
        """The variable that takes a further output of a function."""
        if pin.expression:
            return self.fragments.place(pin.expression, pin.line)
        wire = Wire(item.id, pin.name)
        of = self.kinds.parameter(item.text, pin.name) or self._wanted(item, pin.name)
        if of is None:
            self._unknown(item, pin)
            return None
        name = self.hidden.add("Output", of, item.line, f"output {pin.name} of the {item}")
        self.values[wire] = _negated(name) if pin.is_negated else name
        return name

    def _is_inline(
        self, item: Item, wire: Wire, enable: tree.Expression | None, extra: list[Pin], call: tree.Expression
    ) -> bool:
        """True if the call can stand where its result is used."""
        is_low = functions.height(call) <= HIGHEST
        return is_low and enable is None and not extra and len(self._consumers(item)) <= 1 and wire not in self.loops

    def _only_sink(self, item: Item) -> Item | None:
        """The one plain variable that takes the result."""
        found = self._consumers(item)
        sink = found[0][0] if len(found) == 1 else None
        if sink is None or sink.kind is not Kind.SINK or sink.id in self.finished or len(sink.inputs[0].wires) != 1:
            return None
        return sink if sink.storage is Storage.NONE and sink.edge is Edge.NONE else None

    def _written_result(self, item: Item, enable: tree.Expression | None, call: tree.Expression, result: Pin) -> None:
        target = self.fragments.place(result.expression, result.line)
        if target is None:
            return
        value = _negated(call) if result.is_negated else call
        self._guarded(enable, [tree.Assign(target, value, place=_place(item))], item)
        self.values[Wire(item.id, result.name)] = target

    def _kept_result(
        self, item: Item, wire: Wire, enable: tree.Expression | None, call: tree.Expression, result: Pin
    ) -> None:
        name = self.loops.get(wire) or self._variable_for(item, result, call)
        if name is None:
            return
        self._guarded(enable, [tree.Assign(name, call, place=_place(item))], item)
        self.values[wire] = _negated(name) if result.is_negated else name

    def _variable_for(self, item: Item, pin: Pin, call: tree.Expression | None) -> tree.Name | None:
        of = self.kinds.of_function(item.text) or self.kinds.of(call) or self._wanted(item, pin.name)
        if of is None:
            self._unknown(item, pin)
            return None
        return self.hidden.add("Result", of, item.line, f"result of the {item}")

    def _unknown(self, item: Item, pin: Pin) -> None:
        self._mistake(
            item.line,
            f"The type of output {pin.name or 1} of the {item} is unknown in this file, and its value is kept",
            hint="Connect the output to a variable, and use the variable.",
        )

    def _wanted(self, item: Item, pin: str) -> tree.TypeSpec | None:
        """The type that a consumer of this output has."""
        for other, consumer, wire in self.consumers.get(item.id, ()):
            if wire.pin not in ("", pin):
                continue
            operand = self.fragments.expression(other.text, other.line) if other.kind is Kind.SINK else None
            if (of := consumer_type(self.kinds, other, consumer, operand)) is not None:
                return of
        return None

    def _output(self, item: Item, wire: Wire) -> tree.Expression | None:
        """The value of an output of a block, which is executed before if it is not part of a loop."""
        is_later = self._is_later(item)
        if not is_later:
            self.execute(item)
        pin = self._output_pin(item, wire)
        if pin is None:
            return None
        full = Wire(item.id, "ENO" if pin.name.casefold() == "eno" else pin.name)
        if full in self.values:
            return self.values[full]
        if full.pin == "ENO":
            return tree.Literal(tree.LiteralKind.BOOL, True, "TRUE", place=_place(item))
        if pin in item.in_outs:
            return self.input(pin, item) if pin.wires or pin.expression else None
        if item.instance:
            called = self.fragments.place(item.instance, item.line)
            if called is None:
                return None
            value = tree.Member(called, pin.name, place=_place(item))
            return _negated(value) if pin.is_negated else value
        if is_later or item.id not in self.finished:
            return self._previous(item, pin, full)
        return None  # its own message has been given

    def _previous(self, item: Item, pin: Pin, wire: Wire) -> tree.Expression | None:
        """The result of a function in the previous cycle, for a loop."""
        if not self.hidden.has_memory:
            self._mistake(item.line, f"The {item} is part of a loop, and a function has no memory for it")
            return None
        if wire not in self.loops:
            name = self._variable_for(item, pin, self._example(item))
            if name is None:
                return None
            self.loops[wire] = name
        return _negated(self.loops[wire]) if pin.is_negated else self.loops[wire]

    def _example(self, item: Item) -> tree.Expression | None:
        """The first operand of a function that has a declared type."""
        for pin in item.inputs:
            for wire in pin.wires:
                source = self.items.get(wire.source)
                if source is not None and source.kind in (Kind.SOURCE, Kind.THROUGH):
                    value = self.fragments.expression(source.text, source.line)
                    if self.kinds.of(value) is not None and not isinstance(value, tree.Literal):
                        return value
        return None

    def _output_pin(self, item: Item, wire: Wire) -> Pin | None:
        known = [*item.outputs, *item.in_outs]
        named = next((pin for pin in known if pin.name.casefold() == wire.pin.casefold()), None)
        if named is not None:
            return named
        if wire.pin.casefold() == "eno" or item.code:
            return Pin("ENO")
        first = next((pin for pin in item.outputs if pin.name.casefold() != "eno"), None)
        if not wire.pin:
            return first or Pin("ENO")
        if not item.instance and first is not None and len(item.outputs) <= 2:
            return first  # the result of a function has different names in different tools
        if item.instance:
            return Pin(wire.pin, item.line)  # some tools list only the outputs that are connected
        self._mistake(item.line, f"The {item} has no output {wire.pin[:30]}")
        return None

    def _is_later(self, item: Item) -> bool:
        """True if the author has put the element behind the one that is executed now."""
        return bool(item.order and self.order and item.order > self.order)

    def _put(self, statement: tree.AnyStatement) -> None:
        self.out.append(statement)

    def _mistake(self, line: int, what: str, expected: str = "", hint: str = "") -> None:
        self.fragments.report.mistake(line, what, expected, hint)


def _consuming(item: Item) -> list[Pin]:
    """The pins that take values, the condition of a transition among them."""
    condition = item.condition.pin if item.condition else None
    return [*item.pins(), *([condition] if condition else [])]


def _place(item: Item) -> tree.Place:
    return tree.Place(item.line, 1)


def _is_true(value: tree.Expression) -> bool:
    return isinstance(value, tree.Literal) and value.value is True


def _negated(value: tree.Expression) -> tree.Expression:
    return tree.Unary("NOT", value, place=value.place)


def _any(values: list[tree.Expression], line: int) -> tree.Expression:
    """The parallel connection of branches."""
    if any(_is_true(value) for value in values):
        return next(value for value in values if _is_true(value))
    return functions.balanced("OR", values, tree.Place(line, 1))


def _if(condition: tree.Expression, body: list[tree.AnyStatement], line: int) -> tree.If:
    place = tree.Place(line, 1)
    return tree.If((tree.Branch(condition, tuple(body), place=place),), place=place)
