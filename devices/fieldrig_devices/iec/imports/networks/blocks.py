"""Blocks of a network: instances, functions, operators and boxes with code, with EN and ENO, and their outputs."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.literal_only import takes_its_type_from_outside
from fieldrig_devices.iec.check.untyped import Untyped
from fieldrig_devices.iec.imports.networks import functions
from fieldrig_devices.iec.imports.networks.declarations import BOOL
from fieldrig_devices.iec.imports.networks.flow import HIGHEST
from fieldrig_devices.iec.imports.networks.foreseeing import Foreseeing
from fieldrig_devices.iec.imports.networks.graph import Edge, Item, Kind, Pin, Storage, Wire
from fieldrig_devices.iec.imports.networks.results import type_of, whole_type_of
from fieldrig_devices.iec.imports.networks.terms import conditional, is_true, negated, position_of
from fieldrig_devices.iec.program import Expression


class Kept(NamedTuple):
    """The type of a variable for a result."""

    type: tree.TypeSpec
    narrow: tree.TypeSpec | None = None
    """The type of the result, if arithmetic has given it more bits and the variable holds them all."""


@dataclass(slots=True)
class Blocks(Foreseeing):
    """One network, with its blocks."""

    enos: dict[str, tree.Name] = field(default_factory=dict)
    """Hidden variables for the ENO of blocks whose body may set it."""

    def block(self, item: Item) -> None:
        is_declared = self.kinds.parameter(item.text, "EN") is not None
        enable: tree.Expression | None = None
        arguments: list[tuple[Pin, tree.Expression | None]] = []
        for pin in item.pins():
            value = self.input(pin, item) if pin.wires or pin.expression else None
            if pin.name.casefold() == "en" and not is_declared:
                enable = None if value is None or is_true(value) else value
            else:
                arguments.append((pin, value))
        if enable is not None:
            enable = self.shared(Wire(item.id, "ENO"), "Enable", enable, BOOL, item)
        if self._may_set_eno(item):
            self.enos[item.id] = self.hidden.add("Ok", BOOL, item.line, f"ENO of the {item}")
        if item.code:
            self._guarded(enable, self._code(item), item)
        elif item.instance:
            self._instance(item, enable, arguments)
        else:
            self._function(item, enable, arguments)
        if item.id in self.enos:
            self.values[Wire(item.id, "ENO")] = self.enos[item.id]
        self._write_eno(item)

    def _may_set_eno(self, item: Item) -> bool:
        """True if ENO is used and is perhaps not EN: in edition 3 the code of a block may set it, and a division."""
        if not self.fragments.dialect.has_enable or item.code:
            return False
        is_division = functions.OPERATORS.get(item.text.casefold()) in functions.DIVISIONS
        if not is_division and (functions.is_standard(item.text) or self.kinds.is_library_block(item.text)):
            return False
        is_written = any(pin.expression and pin.name.casefold() == "eno" for pin in item.outputs)
        return is_written or any(wire.pin.casefold() == "eno" for _, _, wire in self.consumers.get(item.id, ()))

    def _write_eno(self, item: Item) -> None:
        """Assign ENO to a variable that is written at the output itself."""
        for pin in item.outputs:
            target = self.fragments.place(pin.expression, pin.line) if pin.expression else None
            if target is not None and pin.name.casefold() == "eno":
                value = self._eno(item)
                self.put(tree.Assign(target, negated(value) if pin.is_negated else value, position=position_of(item)))

    def _eno(self, item: Item) -> tree.Expression:
        """Return the value of ENO: that of EN, what the code has set, or an output that is declared with this name."""
        eno = self.values.get(Wire(item.id, "ENO"))
        own = None
        if eno is None and item.instance and self.kinds.parameter(item.text, "ENO") is not None:
            own = self.fragments.place(item.instance, item.line)
        return eno or (_true(item) if own is None else tree.Member(own, "ENO", position=position_of(item)))

    def _guarded(self, enable: tree.Expression | None, statements: list[tree.AnyStatement], item: Item) -> None:
        if enable is None or not statements:
            self.out += statements
            return
        guarded = conditional(enable, statements, item.line)
        if item.id in self.enos:
            never = tree.Literal(tree.LiteralKind.BOOL, False, "FALSE", position=position_of(item))
            guarded.otherwise = (tree.Assign(self.enos[item.id], never, position=position_of(item)),)
        self.put(guarded)

    def _eno_argument(self, item: Item) -> list[tree.Argument]:
        if item.id not in self.enos:
            return []
        return [tree.Argument(self.enos[item.id], "ENO", is_output=True, position=position_of(item))]

    def _code(self, item: Item) -> list[tree.AnyStatement]:
        body = self.fragments.body(item.code, item.code_line, "ST")
        return list(body.statements) if isinstance(body, tree.StBody) else []

    def _instance(
        self, item: Item, enable: tree.Expression | None, arguments: list[tuple[Pin, tree.Expression | None]]
    ) -> None:
        called = self.fragments.place(item.instance, item.line)
        if called is None:
            return
        given = [
            tree.Argument(value, pin.name, position=tree.Position(pin.line, 1))
            for pin, value in arguments
            if value is not None
        ]
        call = tree.Call(called, (*given, *self._eno_argument(item)), position=position_of(item))
        self._guarded(
            enable, [tree.CallStatement(call, position=position_of(item)), *self._written(item, called)], item
        )

    def _written(self, item: Item, called: tree.Expression) -> list[tree.AnyStatement]:
        """Variables that are written at the outputs of an instance themselves, without an element of their own."""
        written: list[tree.AnyStatement] = []
        for pin in item.outputs:
            target = self.fragments.place(pin.expression, pin.line) if pin.expression else None
            if target is not None and pin.name.casefold() != "eno":
                value: tree.Expression = tree.Member(called, pin.name, position=position_of(item))
                value = negated(value) if pin.is_negated else value
                written.append(tree.Assign(target, value, position=tree.Position(pin.line, 1)))
        return written

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
            call, enable = tree.Binary("AND", enable, call, position=position_of(item)), None
        if result.expression:
            self._written_result(item, enable, call, result)
        elif self._is_inline(item, wire, enable, extra, call):
            self.values[wire] = negated(call) if result.is_negated else call
        elif (sink := self._only_sink(item)) is not None and enable is not None:
            self.started.add(sink.id)
            self.written.add(sink.id)
            target = self.fragments.place(sink.text, sink.line)
            value = negated(call) if result.is_negated != sink.is_negated else call
            if target is not None:
                self._guarded(enable, [tree.Assign(target, value, position=position_of(sink))], item)
        else:
            self._kept_result(item, wire, enable, call, result)

    def _call_statement(self, item: Item, call: tree.Expression, result: Pin | None) -> list[tree.AnyStatement]:
        if isinstance(call, tree.Call):
            return [tree.CallStatement(call, position=position_of(item))]
        return []

    def _consumers(self, item: Item) -> list[tuple[Item, Pin]]:
        """Return the consumers of a block, besides those of ENO."""
        consumers = self.consumers.get(item.id, [])
        return [(other, pin) for other, pin, wire in consumers if wire.pin.casefold() != "eno"]

    def _call(
        self, item: Item, arguments: list[tuple[Pin, tree.Expression | None]], extra: list[Pin]
    ) -> tree.Expression | None:
        """The call of a function, or the operation of an operator."""
        name, position = item.text, position_of(item)
        given = [value for _, value in arguments if value is not None]
        operator = functions.OPERATORS.get(name.casefold())
        unary = name.casefold() in ("not", "move")
        if operator or unary:
            if len(given) < (1 if unary else 2) or len(given) < len(arguments):
                self.mistake(item.line, f"An input of the {item} is not connected")
                return None
            if operator and len(given) > HIGHEST and operator not in ("AND", "OR", "XOR"):
                self.mistake(item.line, f"The {item} has {len(given)} inputs", f"at most {HIGHEST}")
                return None
            if operator and item.id in self.enos:
                division = tree.Name(functions.DIVISIONS[operator], position=position)
                passed = [tree.Argument(value, position=value.position) for value in given]
                return tree.Call(division, (*passed, *self._eno_argument(item)), position=position)
            if operator:
                return functions.operation(operator, given, position)
            return negated(given[0]) if name.casefold() == "not" else given[0]
        called = self.fragments.place(name, item.line)
        if called is None:
            return None
        is_named = bool(extra) or len(given) < len(arguments)
        passed = [
            tree.Argument(value, pin.name if is_named else "", position=tree.Position(pin.line, 1))
            for pin, value in arguments
            if value is not None
        ]
        for pin in extra:
            variable = self._extra_output(item, pin)
            if variable is not None:
                passed.append(tree.Argument(variable, pin.name, is_output=True, position=tree.Position(pin.line, 1)))
        return tree.Call(called, (*passed, *self._eno_argument(item)), position=position)

    def _extra_output(self, item: Item, pin: Pin) -> tree.Expression | None:
        """The variable that takes a further output of a function."""
        if pin.expression:
            return self.fragments.place(pin.expression, pin.line)
        wire = Wire(item.id, pin.name)
        of = self.kinds.parameter(item.text, pin.name) or self.wanted(item, pin.name)
        if of is None:
            self._unknown(item, pin)
            return None
        name = self.hidden.add("Output", of, item.line, f"output {pin.name} of the {item}")
        self.values[wire] = negated(name) if pin.is_negated else name
        return name

    def _is_inline(
        self, item: Item, wire: Wire, enable: tree.Expression | None, extra: list[Pin], call: tree.Expression
    ) -> bool:
        """True if the call can stand where its result is used."""
        is_low = functions.height(call) <= HIGHEST
        is_alone = enable is None and not extra and item.id not in self.enos
        return is_low and is_alone and len(self._consumers(item)) <= 1 and wire not in self.loops

    def _only_sink(self, item: Item) -> Item | None:
        """The one plain variable that takes the result."""
        consumers = self._consumers(item)
        sink = consumers[0][0] if len(consumers) == 1 else None
        if sink is None or sink.kind is not Kind.SINK or sink.id in self.finished or len(sink.inputs[0].wires) != 1:
            return None
        return sink if sink.storage is Storage.NONE and sink.edge is Edge.NONE else None

    def _written_result(self, item: Item, enable: tree.Expression | None, call: tree.Expression, result: Pin) -> None:
        target = self.fragments.place(result.expression, result.line)
        if target is None:
            return
        value = negated(call) if result.is_negated else call
        self._guarded(enable, [tree.Assign(target, value, position=position_of(item))], item)
        self.values[Wire(item.id, result.name)] = target

    def _kept_result(
        self, item: Item, wire: Wire, enable: tree.Expression | None, call: tree.Expression, result: Pin
    ) -> None:
        kept, loop = self._kept_as(item, result, call), self.loops.get(wire)
        is_whole = kept is not None and kept.narrow is not None
        name = loop if loop is not None and not is_whole else self._variable_for(item, result, kept)
        if name is None:
            return
        statements: list[tree.AnyStatement] = [tree.Assign(name, call, position=position_of(item))]
        if loop is not None and loop is not name:  # what comes back is cut, and what follows is not
            statements.append(tree.Assign(loop, name, position=position_of(item)))
        if kept is not None:
            statements += self._in_other_types(item, call, result, kept)
        self._guarded(enable, statements, item)
        self.values[wire] = negated(name) if result.is_negated else name

    def _in_other_types(
        self, item: Item, call: tree.Expression, result: Pin, kept: Kept
    ) -> Iterator[tree.AnyStatement]:
        """Calculate a result again where TRUNC or a function of literals has another type for a consumer."""
        if not functions.is_standard(item.text):
            return
        made = list[tuple[Kept, tree.Name]]()
        for other, pin, wire in self.consumers.get(item.id, ()):
            if wire.pin.casefold() == "eno":
                continue
            wanted = self.wanted_by(other, pin)
            if wanted is None and (type(self.kinds.value(call)) is Untyped or takes_its_type_from_outside(call)):
                wanted = self.beside(other, pin, item)
            of = self._kept_for(item, wanted, call)
            if of is None or of == kept:
                continue
            name = next((name for known, name in made if known == of), None)
            if name is None:
                name = self.hidden.add("Result", of.type, item.line, f"result of the {item}", of.narrow)
                made.append((of, name))
                yield tree.Assign(name, call, position=position_of(item))
            self.own[wire, other.id] = negated(name) if result.is_negated else name

    def _variable_for(self, item: Item, pin: Pin, kept: Kept | None) -> tree.Name | None:
        if kept is None:
            self._unknown(item, pin)
            return None
        return self.hidden.add("Result", kept.type, item.line, f"result of the {item}", kept.narrow)

    def _kept_as(self, item: Item, pin: Pin, call: tree.Expression | None) -> Kept | None:
        """Return the type in which a result is kept, None for an unknown one.  `call` is None for a loop."""
        return self._kept_for(item, self.wanted(item, pin.name), call)

    def _kept_for(self, item: Item, wanted: tree.TypeSpec | None, call: tree.Expression | None) -> Kept | None:
        value = self.kinds.value(call, wanted) if call is not None else self.foreseen(item, wanted)
        of = self.kinds.of_function(item.text)
        if of is None and value is not None:
            of = self.kinds.spec(type_of(value, self.kinds.type(wanted)))
            if of is not None and not self._is_same_in(of, value, call):
                return Kept(wanted or of)
            whole = whole_type_of(value)
            wide = self.kinds.spec(whole) if whole is not None else None
            if of is not None and wide is not None and self._is_same_in(wide, value, call):
                return Kept(wide, of)
        of = of or self.kinds.of_standard(item.text) or wanted
        return Kept(of) if of is not None else None

    def _is_same_in(self, kind: tree.TypeSpec, value: Expression, call: tree.Expression | None) -> bool:
        """Return whether a call has the same type and bits if it is assigned to a variable of this type.

        `MIN(40000, -1)` is 40000 where a UINT is wanted, and -1 for a DINT; a consumer gets what a text gives it.
        """
        kept = self.kinds.value(call, kind) if call is not None else value
        if kept is None or type(value) is Untyped:
            return True
        return (kept.type, whole_type_of(kept)) == (value.type, whole_type_of(value))

    def _unknown(self, item: Item, pin: Pin) -> None:
        self.mistake(
            item.line,
            f"The type of output {pin.name or 1} of the {item} is unknown, and its value is kept",
            hint="Connect the output to a variable, and use the variable.",
        )

    def output(self, item: Item, wire: Wire) -> tree.Expression | None:
        """The value of an output of a block, which is executed before if it is not part of a loop."""
        is_later = self.is_later(item)
        if not is_later:
            self.execute(item)
        pin = self._output_pin(item, wire)
        if pin is None:
            return None
        full = Wire(item.id, "ENO" if pin.name.casefold() == "eno" else pin.name)
        if full.pin == "ENO":
            return self._eno(item)
        if full in self.values:
            return self.values[full]
        if pin in item.in_outs:
            return self.input(pin, item) if pin.wires or pin.expression else None
        if item.instance:
            called = self.fragments.place(item.instance, item.line)
            if called is None:
                return None
            value = tree.Member(called, pin.name, position=position_of(item))
            return negated(value) if pin.is_negated else value
        if is_later or item.id not in self.finished:
            return self._previous(item, pin, full)
        return None  # its own message has been given

    def _previous(self, item: Item, pin: Pin, wire: Wire) -> tree.Expression | None:
        """The result of a function in the previous cycle, for a loop."""
        if not self.hidden.has_memory:
            self.mistake(item.line, f"The {item} is part of a loop, and a function has no memory for it")
            return None
        if wire not in self.loops:
            kept = self._kept_as(item, pin, None)
            name = self._variable_for(item, pin, Kept(kept.narrow or kept.type) if kept is not None else None)
            if name is None:
                return None
            self.loops[wire] = name
        return negated(self.loops[wire]) if pin.is_negated else self.loops[wire]

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
        self.mistake(item.line, f"The {item} has no output {wire.pin[:30]}")
        return None


def _true(item: Item) -> tree.Literal:
    return tree.Literal(tree.LiteralKind.BOOL, True, "TRUE", position=position_of(item))
