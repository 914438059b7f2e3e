"""Objects without a machine: values in memory, for an application that runs alone and for tests.

An input has the value that it is given from outside, an output the value that the program wrote.  Every inquiry has an
answer that can be set; `ready` is true until then, and all others are false or 0.  Orders are recorded, and do nothing.
"""

from collections import defaultdict
from collections.abc import Callable, Sequence
from typing import Any, Final

from fieldrig_devices.pam.language.functions import INQUIRIES, VALUES
from fieldrig_devices.pam.language.items import Declaration
from fieldrig_devices.pam.language.objects import KINDS
from fieldrig_devices.pam.language.tree import Number
from fieldrig_devices.pam.language.words import PREDECLARED
from fieldrig_devices.pam.runtime.compiler import Compiled
from fieldrig_devices.pam.runtime.item import Item, Kernel, Pending, RoutineRef, Value
from fieldrig_devices.pam.runtime.layout import START

LONGEST_RECORD: Final = 1_000
"""Orders that are remembered."""
_NOT_OBJECTS: Final = ("BOOLEAN", "ACTIONS", "TASK")


class MemoryItem:
    """One item of an object."""

    def __init__(self, kind: str, on_change: Callable[[], None], on_order: Callable[[str], None]) -> None:
        self.kind, self._on_change, self._on_order = kind, on_change, on_order
        self._value: Value = START[VALUES[kind]] if kind in VALUES else 0
        self.answers: dict[str, Value | Pending] = {"ready": True}
        """The answers to inquiries by their names."""
        self.parameters: dict[str, Any] = {}

    def value(self) -> Value:
        return self._value

    def set_value(self, value: Value) -> None:
        self.hold(value)
        self._on_order(f"<- {value}")

    def hold(self, value: Value) -> None:
        """Have another value, as an input has from outside."""
        if value != self._value:
            self._value = value
            self._on_change()

    def ask(self, function: str, arguments: Sequence[Any]) -> Value | Pending:
        if function in self.answers:
            return self.answers[function]
        if function == "value":
            return self._value
        forms = INQUIRIES[self.kind][function]
        answer = next(form.answer for form in forms if len(form.arguments) == len(arguments))
        return START[answer or "flag"]

    def answer(self, function: str, value: Value | Pending) -> None:
        """Have another answer to an inquiry."""
        self.answers[function] = value
        self._on_change()

    def do(self, function: str, arguments: Sequence[Any]) -> None:
        self._on_order(f"<- {function}({', '.join(map(str, arguments))})" if arguments else f"<- {function}")
        if function in ("set", "reset", "invert") and self.kind in VALUES:
            self.hold({"set": True, "reset": False}.get(function, not self._value))

    def parameter(self, name: str) -> Value:
        value = self.parameters.get(name, 0.0)
        return value if isinstance(value, bool | int | float) else 0.0

    def set_parameter(self, name: str, value: "Value | str | RoutineRef | Item") -> None:
        self.parameters[name] = value
        shown = f"{value.routine or 'NONE'}" if isinstance(value, RoutineRef) else str(value)
        self._on_order(f":{name} <- {shown}")
        self._on_change()


class MemoryObjects:
    """All objects of an application that are not of the language itself."""

    def __init__(self, program: Compiled, kernel: Kernel) -> None:
        layout = program.layout
        self.kernel = kernel
        """The run time that is informed of changes."""
        self.items: dict[str, Sequence[MemoryItem]] = {}
        self.orders: list[str] = []
        """The latest orders of the program, such as `AXI_Belt <- stop`."""
        self.missing: dict[str, set[int]] = defaultdict(set)
        """The components of each nodes group that are not there."""
        self.on_cycle: list[Callable[[], None]] = []
        """Called at the beginning of each basic cycle."""
        kinds = {name: kind for name, kind in layout.kinds.items() if kind not in _NOT_OBJECTS}
        for name, kind in {**kinds, **{kind: kind for kind in PREDECLARED.values()}}.items():
            if name not in layout.cells:
                count = layout.counts.get(name, 1)
                self.items[name] = [self._item(name, kind, number, count) for number in range(count)]
        for item in program.program.items:
            if isinstance(item, Declaration):
                self._declare(item)

    def _item(self, name: str, kind: str, number: int, count: int) -> MemoryItem:
        shown = name if count == 1 else f"{name}[{number + 1}]"

        def on_order(what: str) -> None:
            self.orders.append(f"{shown}{what}" if what[0] == ":" else f"{shown} {what}")
            del self.orders[:-LONGEST_RECORD]

        return MemoryItem(kind, lambda: self.kernel.touched(name), on_order)

    def _declare(self, declaration: Declaration) -> None:
        rules = KINDS.get(declaration.kind, {})
        for item in self.items.get(declaration.name, ()):
            for parameter in declaration.parameters:
                value = parameter.values[0] if parameter.values else None
                if isinstance(value, Number):
                    is_integer = rules[parameter.name].holds[0] == "integer"
                    item.parameters[parameter.name] = value.value if is_integer else float(value.value)

    def is_active(self, name: str, index: int) -> bool:
        return index not in self.missing[name]

    def connect(self, blocks: Sequence[Item]) -> None:
        self.orders.append(f"a pipe of {len(blocks)} blocks")

    def take(self) -> None:
        for on_cycle in self.on_cycle:
            on_cycle()

    def flow(self) -> None:
        """Do nothing: no pipe flows without a machine."""

    def give(self) -> None:
        """Do nothing: outputs are not connected."""
