"""Makes the functions by which generated code uses objects, from the items that an application has."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from fieldrig_devices.pam.language.words import PREDECLARED
from fieldrig_devices.pam.runtime.item import Item, Pending, RoutineRef, Value
from fieldrig_devices.pam.runtime.kernel import ProgramKernel
from fieldrig_devices.pam.runtime.lower.uses import Argument, Fixed, Use, Verb
from fieldrig_devices.pam.runtime.watches import UnansweredError

Function = Callable[..., Any]
UNANSWERED = "07..E021"
"""The message for an answer that is needed at once and is not there (PAML-266)."""


class Binding:
    def __init__(
        self, kernel: ProgramKernel, items: Mapping[str, Sequence[Item]], formulas: Sequence[Callable[[int], Any]]
    ) -> None:
        """`formulas` are the functions of the formulas by their numbers; they may be added later."""
        self._kernel, self._items, self._formulas = kernel, items, formulas

    def of(self, uses: Mapping[str, Use]) -> dict[str, Function]:
        """Return the functions of these uses by their names."""
        return {name: _MAKERS[use.verb](self, use) for name, use in uses.items()}

    def items(self, name: str) -> Sequence[Item]:
        return self._items[name] if name in self._items else self._items[PREDECLARED[name]]

    def _addressed(self, use: Use) -> list[Item]:
        """Return the items of [all]: those of components that are there (G-46)."""
        items = self.items(use.name)
        return [items[number] for number in self._kernel.active(use.name)]

    def _one(self, use: Use) -> Item:
        return self.items(use.name)[0]

    # ---- values and orders

    def value(self, use: Use) -> Function:
        if use.index is None:
            return self._one(use).value
        items = self.items(use.name)
        return lambda base: items[base].value()

    def set(self, use: Use) -> Function:
        return self._order(use, lambda item: item.set_value)

    def get(self, use: Use) -> Function:
        if use.index is None:
            return partial(self._one(use).parameter, use.word)
        items = self.items(use.name)
        return lambda base: items[base].parameter(use.word)

    def do(self, use: Use) -> Function:
        if use.arguments.count(None) == len(use.arguments):
            return self._order(use, lambda item: lambda *values: item.do(use.word, values))

        def order(item: Item) -> Function:
            return lambda *values: item.do(use.word, self._arguments(use.arguments, values))

        return self._order(use, order)

    def put(self, use: Use) -> Function:
        def order(item: Item) -> Function:
            if use.routine is not None:
                name = use.routine
                return lambda *values: item.set_parameter(use.word, RoutineRef(name, values))
            return lambda *values: item.set_parameter(use.word, self._arguments(use.arguments, values)[0])

        return self._order(use, order)

    def connect(self, use: Use) -> Function:
        blocks = self._arguments(use.arguments, ())
        return partial(self._kernel.connect, blocks)

    def _order(self, use: Use, order: Callable[[Item], Function]) -> Function:
        """Return a function that gives an order to the item, or to each of them."""
        if use.index is None:
            return order(self._one(use))
        if use.index == "i":
            each = [order(item) for item in self.items(use.name)]
            return lambda base, *values: each[base](*values)
        all_of_them = [order(item) for item in self._addressed(use)]

        def give(*values: Value) -> None:
            for give_one in all_of_them:
                give_one(*values)

        return give

    def _arguments(self, arguments: Sequence[Argument], values: Sequence[Value]) -> list[Any]:
        """Return the arguments of a function; [i] as an argument is the item for which the program runs."""
        computed = iter(values)
        given: list[Any] = []
        for argument in arguments:
            if argument is None:
                given.append(next(computed))
            elif isinstance(argument, Fixed):
                given.append(argument.value)
            else:
                items = self.items(argument.name)
                number = self._kernel.processor.present_item if argument.index == "i" else 0
                given += items if argument.index == "all" else [items[number]]
        return given

    # ---- inquiries

    def _asking(self, use: Use) -> Callable[[int, Sequence[Value]], Value | Pending]:
        """Return a function of the item's number and the arguments."""
        items, function = self.items(use.name), use.word
        return lambda base, values: items[base].ask(function, values)

    def ask(self, use: Use) -> Function:
        if use.index is None:
            item, function = self._one(use), use.word
            if not use.arguments:
                return partial(item.ask, function, ())
            return lambda *values: item.ask(function, values)
        asked = self._asking(use)
        return lambda base, *values: asked(base, values)

    def poll(self, use: Use) -> Function:
        asked, waiting = self._asking(use), dict[int, Pending]()

        def poll(base: int = 0) -> Value:
            answer: Value | Pending = waiting.pop(base) if base in waiting else asked(base, ())
            if not isinstance(answer, Pending):
                return answer
            if answer.value is None:
                waiting[base] = answer
                raise UnansweredError
            return answer.value

        return poll

    def now(self, use: Use) -> Function:
        asked, last, kernel = self._asking(use), dict[int, Value](), self._kernel

        def now(base: int = 0) -> Value:
            answer = asked(base, ())
            value = answer.value if isinstance(answer, Pending) else answer
            if value is None:
                kernel.report(UNANSWERED)
                return last.get(base, 0)
            last[base] = value
            return value

        return now

    def later(self, use: Use) -> Function:
        asked, kernel = self._asking(use), self._kernel
        if use.index is None:
            return lambda slot: kernel.later(slot, asked(0, ()))
        return lambda base, slot: kernel.later(slot, asked(base, ()))

    # ---- reductions

    def any(self, use: Use) -> Function:
        items, formulas, number = self._kernel.active(use.name), self._formulas, int(use.word)
        return lambda: any(formulas[number](item) for item in items)

    def all(self, use: Use) -> Function:
        items, formulas, number = self._kernel.active(use.name), self._formulas, int(use.word)
        return lambda: all(formulas[number](item) for item in items)


_MAKERS: Mapping[Verb, Callable[[Binding, Use], Function]] = {
    Verb.VALUE: Binding.value,
    Verb.SET: Binding.set,
    Verb.ASK: Binding.ask,
    Verb.POLL: Binding.poll,
    Verb.NOW: Binding.now,
    Verb.LATER: Binding.later,
    Verb.DO: Binding.do,
    Verb.GET: Binding.get,
    Verb.PUT: Binding.put,
    Verb.CONNECT: Binding.connect,
    Verb.ANY: Binding.any,
    Verb.ALL: Binding.all,
}
