"""The labels of one CASE."""

from bisect import bisect_left, bisect_right
from collections.abc import Sequence

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.expressions import Expressions
from fieldrig_devices.iec.types import Type


class CaseLabels:
    """The labels of one CASE: constants that should occur once."""

    def __init__(self, expressions: Expressions, kind: Type | None) -> None:
        self._expressions, self._context = expressions, expressions.context
        self._kind = kind
        self._ranges: list[tuple[int, int]] = []
        """The labels so far, in order and without those that they have in common."""

    def ranges(self, nodes: Sequence[tree.Expression | tree.Range]) -> tuple[tuple[int, int], ...]:
        checked = [self._range(node) for node in nodes]
        return tuple(part for part in checked if part is not None)

    def _range(self, node: tree.Expression | tree.Range) -> tuple[int, int] | None:
        parts = (node.low, node.high) if isinstance(node, tree.Range) else (node, node)
        low = self._value(parts[0])
        high = self._value(parts[1]) if isinstance(node, tree.Range) else low
        if low is None or high is None:
            return None
        if low > high:
            self._context.say(node, f"the range {low}..{high} is empty", "the lower value first")
            return None
        self._note_repeated(node, low, high)
        return low, high

    def _value(self, node: tree.Expression) -> int | None:
        if self._kind is None:
            return self._expressions.constant_integer(node)
        constant = self._expressions.constant_as(node, self._kind)
        return int(constant.value) if constant is not None else None

    def _note_repeated(self, node: tree.Node, low: int, high: int) -> None:
        first = bisect_left(self._ranges, low, key=lambda known: known[1])
        last = bisect_right(self._ranges, high, key=lambda known: known[0])
        if first < last:
            shown = str(low) if low == high else f"{low}..{high}"
            self._tell_repeated(node, f"the label {shown} occurs twice in this CASE")
            low, high = min(low, self._ranges[first][0]), max(high, self._ranges[last - 1][1])
        self._ranges[first:last] = [(low, high)]

    def _tell_repeated(self, node: tree.Node, what: str) -> None:
        if self._context.project.dialect.allows_repeated_labels:
            self._context.note(node, what, "only the first branch runs")
        else:
            self._context.say(node, what, "each value once")
