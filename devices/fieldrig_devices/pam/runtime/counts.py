"""Check that [i] always is an item: objects that are used together have the same number of items (PAML-294)."""

from collections.abc import Iterator

from fieldrig_devices.languages.mistakes import Mistake
from fieldrig_devices.pam.language.items import Actions, BooleanEquation, Program, Task
from fieldrig_devices.pam.language.tokens import mistake
from fieldrig_devices.pam.language.tree import Node, Reduction, Reference, StartTask
from fieldrig_devices.pam.language.words import PREDECLARED
from fieldrig_devices.pam.runtime.layout import Layout
from fieldrig_devices.pam.runtime.walk import nodes


def check_counts(program: Program, layout: Layout) -> list[Mistake]:
    """Report objects that have fewer items than what uses them with [i]."""
    found: list[Mistake] = []
    for item in program.items:
        if isinstance(item, BooleanEquation | Actions | Task):
            found += _check(item, item.name, layout)
    return found


def _check(root: Node, owner: str, layout: Layout) -> Iterator[Mistake]:
    reductions = [node for node in nodes(root) if isinstance(node, Reduction)]
    inside = {id(part) for reduction in reductions for part in nodes(reduction.operand)}
    for node in nodes(root):
        if isinstance(node, Reference) and node.index == "i" and id(node) not in inside:
            yield from _compared(node, node.name, owner, layout)
        elif isinstance(node, StartTask) and node.sequence.is_indexed:
            yield from _compared(node, node.task, owner, layout)
    for reduction in reductions:
        present = [node for node in nodes(reduction.operand) if isinstance(node, Reference) and node.index == "i"]
        for node in present[1:]:
            yield from _compared(node, node.name, present[0].name, layout)


def _compared(node: Node, name: str, owner: str, layout: Layout) -> Iterator[Mistake]:
    own, wanted = layout.counts.get(name, 1), layout.counts[owner]
    if own < wanted and name not in PREDECLARED:
        yield mistake(node.place, f"{name} has {own} items, but {owner} has {wanted}", f"at least {wanted} items")
