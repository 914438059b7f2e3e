"""Instructions with labels, which become numbers when a routine is complete."""

from collections.abc import Callable, Sequence

from fieldrig_devices.iec.costs import Costs
from fieldrig_devices.iec.lower.emitter import Emitter
from fieldrig_devices.languages.instructions import Branch, Call, Do, End, Guard, Hold, Instruction, Jump, Switch

Label = int


class Assembler:
    def __init__(self, costs: Costs) -> None:
        self._costs = costs
        self._made: list[Callable[[dict[Label, int]], Instruction]] = []
        self._labels: dict[Label, int] = {}
        self._next = 0
        self._guards: list[tuple[int, int, Label, int]] = []
        self._is_deep = True
        self.calls: dict[str, None] = {}
        """The routines that are called, in the order of the text: that of a set would differ from run to run."""
        self.line = 0
        """The source line of what is added."""
        self.cost = 0
        """Costs of all instructions, for the model of the size of the code."""

    def label(self) -> Label:
        self._next += 1
        return self._next

    def labels(self, count: int) -> list[Label]:
        return [self.label() for _ in range(count)]

    def place(self, label: Label) -> None:
        self._labels[label] = len(self._made)

    def emitter(self) -> Emitter:
        return Emitter(self._costs)

    def _scaled(self, cost_ns: int) -> int:
        self.cost += cost_ns
        return self._costs.scaled(cost_ns)

    def _add(self, instruction: Instruction) -> None:
        self._made.append(lambda labels: instruction)

    def do(self, emitter: Emitter) -> None:
        if emitter.lines:
            self._add(Do(self.line, tuple(emitter.lines), self._scaled(emitter.cost)))

    def mark(self, *python: str) -> None:
        """Add what takes the program no time."""
        self._add(Do(self.line, python, 0))

    def branch(self, emitter: Emitter, condition: str, target: Label) -> None:
        line, python = self.line, tuple(emitter.lines)
        cost = self._scaled(emitter.cost + self._costs.jump_ns)
        self._made.append(lambda labels: Branch(line, python, condition, labels[target], cost))

    def jump(self, target: Label, *, is_free: bool = False) -> None:
        """Add a jump; one that the program does not have is free."""
        line, cost = self.line, 0 if is_free else self._scaled(self._costs.jump_ns)
        self._made.append(lambda labels: Jump(line, labels[target], cost))

    def switch(self, emitter: Emitter, selector: str, targets: dict[int, Label], otherwise: Label) -> None:
        line, python = self.line, tuple(emitter.lines)
        cost = self._scaled(emitter.cost + 2 * self._costs.jump_ns)
        self._made.append(
            lambda labels: Switch(
                line, python, selector, {value: labels[one] for value, one in targets.items()}, labels[otherwise], cost
            )
        )

    def call(self, routine: str, base: str) -> None:
        line, cost = self.line, self._scaled(self._costs.call_ns)
        self.calls[routine] = None
        self._made.append(lambda labels: Call(line, routine, base, cost, self._is_deep))

    def guard(self, add: Callable[[], None], handler: Label, cell: int) -> None:
        """Add instructions; a fault in them goes on at the handler, with its number in a cell of the frame."""
        first = len(self._made)
        add()
        self._guards.append((first, len(self._made), handler, cell))

    def guards(self) -> tuple[Guard, ...]:
        """Return the guards, the inner ones first."""
        return tuple(Guard(first, end, self._labels[handler], cell) for first, end, handler, cell in self._guards)

    def hold(self, condition: str) -> None:
        self._add(Hold(self.line, condition, self._costs.scaled(0)))

    def end(self) -> None:
        self._add(End(self.line, self._scaled(self._costs.end_ns)))

    def finished(self, *, is_deep: bool) -> Sequence[Instruction]:
        """Return the instructions; calls look whether the stack has room if `is_deep`."""
        self._is_deep = is_deep
        return [make(self._labels) for make in self._made]
