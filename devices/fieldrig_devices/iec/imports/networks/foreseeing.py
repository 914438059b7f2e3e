"""Which type a result of a network will have, before the block that it comes from is executed.

A wire that closes a loop needs a variable before its value is known, and a literal takes the type of its consumer.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.untyped import Untyped
from fieldrig_devices.iec.imports.networks import functions
from fieldrig_devices.iec.imports.networks.declarations import BOOL
from fieldrig_devices.iec.imports.networks.flow import Flow
from fieldrig_devices.iec.imports.networks.graph import Item, Kind, Pin, Wire
from fieldrig_devices.iec.imports.networks.kinds import consumer_type
from fieldrig_devices.iec.program import Expression

Seen = dict[str, Expression | None]
"""The values that were found for the blocks that were looked at; None while one is looked at."""


@dataclass(slots=True)
class Foreseeing(Flow):
    """One network, with the types of what is not executed yet."""

    def foreseen(self, item: Item, wanted: tree.TypeSpec | None = None) -> Expression | None:
        """Return a value of the type that a function will have, by its arguments.

        An argument that comes back through a loop has the type of another one.
        """
        return self._foreseen(item, wanted, {})

    def _foreseen(self, item: Item, wanted: tree.TypeSpec | None, seen: Seen) -> Expression | None:
        """Work the functions in front of it out first, without a call in a call: a network may be deep."""
        waiting = [(item, False)]
        while waiting:
            function, is_ready = waiting.pop()
            if is_ready:
                seen[function.id] = self._of_arguments(function, wanted if function is item else None, seen)
            elif function.id not in seen:
                seen[function.id] = None
                waiting.append((function, True))
                waiting += [(source, False) for source in self._functions_before(function)]
        return seen[item.id]

    def _functions_before(self, item: Item) -> Iterator[Item]:
        for pin in item.pins():
            for wire in pin.wires:
                source = self.items.get(wire.source)
                if source is not None and source.kind is Kind.BLOCK and not source.instance and wire not in self.values:
                    yield source

    def _of_arguments(self, item: Item, wanted: tree.TypeSpec | None, seen: Seen) -> Expression | None:
        given = [self._at(pin, seen) for pin in item.pins() if pin.name.casefold() != "en"]
        known = [value for value in given if value is not None]
        for stand_in in (*known, self.kinds.value_of(wanted)):
            filled = [value or stand_in for value in given]
            whole = [value for value in filled if value is not None]
            if len(whole) == len(given) and (kind := self.kinds.result(item.text, whole, wanted)) is not None:
                return kind
        return None

    def _at(self, pin: Pin, seen: Seen) -> Expression | None:
        if pin.expression and not pin.wires:
            return self.kinds.value(self.fragments.expression(pin.expression, pin.line))
        kinds = (self._behind(wire, seen) for wire in pin.wires)
        return next((value for value in kinds if value is not None), None)

    def _behind(self, wire: Wire, seen: Seen) -> Expression | None:
        source = self.items.get(wire.source)
        if wire in self.values:
            return self.kinds.value(self.values[wire])
        match source:
            case Item(kind=Kind.SOURCE | Kind.THROUGH | Kind.SINK, text=text, line=line):
                return self.kinds.value(self.fragments.expression(text, line))
            case Item(kind=Kind.CONTACT | Kind.COIL | Kind.LEFT_RAIL):
                return self.kinds.value_of(BOOL)
            case Item(kind=Kind.BLOCK, instance=instance, text=text) if instance:
                return self.kinds.value_of(self.kinds.parameter(text, wire.pin))
            case Item(kind=Kind.BLOCK) if source.id not in seen:
                return self._foreseen(source, None, seen)
            case Item(kind=Kind.BLOCK):
                return seen[source.id]
        return None

    def wanted(self, item: Item, pin: str) -> tree.TypeSpec | None:
        """The type that a consumer of this output has."""
        consumers = [(other, at) for other, at, wire in self.consumers.get(item.id, ()) if wire.pin in ("", pin)]
        for other, at in consumers:
            if (of := self.wanted_by(other, at)) is not None:
                return of
        beside = (self.beside(other, at, item) for other, at in consumers)
        return next((of for of in beside if of is not None), None)

    def wanted_by(self, consumer: Item, pin: Pin) -> tree.TypeSpec | None:
        """Return the type that this consumer of a wire has; None for a function that takes several types."""
        operand = self.fragments.expression(consumer.text, consumer.line) if consumer.kind is Kind.SINK else None
        return consumer_type(self.kinds, consumer, pin, operand)

    def beside(self, consumer: Item, pin: Pin, item: Item) -> tree.TypeSpec | None:
        """Return the type of another operand of a function that takes a result of this block."""
        if consumer.kind is not Kind.BLOCK or consumer.instance or not functions.is_standard(consumer.text):
            return None
        others = (other for other in consumer.pins() if other is not pin and other.name.casefold() not in ("en", "g"))
        kinds = (self._at(other, {item.id: None, consumer.id: None}) for other in others)
        return next((self.kinds.spec(value.type) for value in kinds if value and type(value) is not Untyped), None)
