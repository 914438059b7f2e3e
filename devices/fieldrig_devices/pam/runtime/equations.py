"""Boolean equations: evaluated once in a basic cycle, if something that they depend on has changed (PAML-247)."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from heapq import heappop, heappush

from fieldrig_devices.pam.runtime.item import Item
from fieldrig_devices.pam.runtime.kernel import ProgramKernel
from fieldrig_devices.pam.runtime.lower.formulas import Formula
from fieldrig_devices.pam.runtime.lower.lowered import EquationCode


class _Equation:
    """One item of an equation, with the outputs that follow it (PAML-241)."""

    def __init__(self, formula: Formula, item: int, cell: int, outputs: Sequence[Item]) -> None:
        self.formula, self.item, self.cell, self.outputs = formula, item, cell, outputs

    def follow(self, *, value: bool) -> None:
        for output in self.outputs:
            output.set_value(value)


class Equations:
    def __init__(
        self, kernel: ProgramKernel, codes: Iterable[EquationCode], items: Mapping[str, Sequence[Item]]
    ) -> None:
        self._kernel = kernel
        self._equations: list[_Equation] = []
        for code in codes:
            for item in kernel.active(code.name):
                outputs: Sequence[Item] = ()
                if code.linked_output is not None:
                    linked = items[code.linked_output]
                    outputs = (linked[item],) if code.is_multiple and len(linked) > 1 else linked
                self._equations.append(_Equation(code.formula, item, code.first + item, outputs))
        self._changed: list[int] = []
        self._polled = [number for number, each in enumerate(self._equations) if each.formula.is_polled]

    @property
    def has_linked_outputs(self) -> bool:
        return any(equation.outputs for equation in self._equations)

    def begin(self) -> None:
        """Give each equation its first value, and its outputs as well."""
        for number, equation in enumerate(self._equations):
            truth = self._kernel.watches.value(equation.formula, equation.item)
            self._kernel.cells[equation.cell] = bool(truth)
            equation.follow(value=bool(truth))
            self._kernel.watches.add(equation.formula, equation.item, self._marking(number))

    def _marking(self, number: int) -> Callable[[], None]:
        return lambda: heappush(self._changed, number)

    def evaluate(self) -> None:
        """Evaluate what may have changed, in the order of the declarations."""
        for number in self._polled:
            heappush(self._changed, number)
        while self._changed:
            number = heappop(self._changed)
            while self._changed and self._changed[0] == number:
                heappop(self._changed)
            equation = self._equations[number]
            truth = self._kernel.watches.value(equation.formula, equation.item)
            if truth is not None and self._kernel.cells[equation.cell] != truth:
                self._kernel.poke(equation.cell, bool(truth))
                equation.follow(value=bool(truth))
