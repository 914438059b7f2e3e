"""Writes the Python function of one build of one routine.

A block that jumps to its own start becomes a Python loop, a branch within a block becomes an `if`, and all other jumps
find their block by a tree of comparisons.  Costs are charged where a block or an arm of a branch is left.
"""

import re
from collections.abc import Generator, Iterator, Mapping
from enum import IntEnum
from typing import Final, NamedTuple, TypeGuard, TypeVar

from fieldrig_devices.languages.blocks import Block, Choice, Node
from fieldrig_devices.languages.instructions import (
    Branch,
    Call,
    Do,
    End,
    Hold,
    Jump,
    Pause,
    Routine,
    Switch,
)

INDENT = "    "
Spent = TypeVar("Spent")

# Why a routine returned.  These are plain integers because they are compared after every call and return.
SLICE: Final = 0  # the budget is used up
CALL: Final = 1  # the instruction at pc is a call that the task has to make; its target is in `entered`
END: Final = 2
WAIT: Final = 3  # at a Pause or Hold: resume at pc in another slice
STOP: Final = 4  # in front of an instruction with a breakpoint
DEEP: Final = 5  # a call for which the stack has no room


class Build(IntEnum):
    FAST = 0
    WATCHED = 1
    STEPPED = 2


class Line(NamedTuple):
    """A line of Python, and the instruction that it belongs to."""

    text: str
    pc: int


class Callee(NamedTuple):
    number: int
    frame_size: int


class Writer:
    def __init__(
        self, number: int, routine: Routine, callees: Mapping[str, Callee], blocks: list[Block], build: Build
    ) -> None:
        self._number, self._callees, self._build, self._blocks = number, callees, build, blocks
        self._routine = routine
        if build is Build.STEPPED:
            self._blocks = [Block(pc, pc + 1, [pc]) for pc in range(len(routine.instructions))]

    def lines(self) -> Iterator[Line]:
        yield Line(f"def routine_{self._number}(pc, n, frame, base):", 0)
        yield Line(f"{INDENT}while n > 0:", 0)
        yield from self._tree(0, len(self._blocks), INDENT * 2)
        yield Line(f"{INDENT}return {SLICE}, pc, n", 0)

    def _tree(self, first: int, end: int, indent: str) -> Iterator[Line]:
        """Yield the blocks from `first` to before `end`, with a binary search over `pc` in front of them."""
        if end - first == 1:
            yield from self._block(self._blocks[first], indent)
            return
        middle = (first + end) // 2
        yield Line(f"{indent}if pc < {self._blocks[middle].first}:", 0)
        yield from self._tree(first, middle, indent + INDENT)
        yield Line(f"{indent}else:", 0)
        yield from self._tree(middle, end, indent + INDENT)

    def _block(self, block: Block, indent: str) -> Iterator[Line]:
        part = _BlockWriter(self._number, self._build, self._routine, self._callees, block)
        if part.is_loop:
            yield Line(f"{indent}while n > 0:", block.first)
            indent += INDENT
        for text, pc in part.lines():
            yield Line(indent + text, pc)


class _BlockWriter:
    def __init__(
        self, number: int, build: Build, routine: Routine, callees: Mapping[str, Callee], block: Block
    ) -> None:
        self._number, self._build, self._callees, self._block = number, build, callees, block
        self._instructions, self._frame_size = routine.instructions, routine.frame_size
        part = self._instructions[block.first : block.end]
        self.is_loop = any(getattr(instruction, "target", None) == block.first for instruction in part)

    def lines(self) -> Iterator[Line]:
        spent = yield from self._nodes(self._block.nodes, 0)
        if spent is not None:
            last = self._block.end - 1
            if not (isinstance(self._instructions[last], Call) and self._build is Build.STEPPED):
                yield from self._leave(self._block.end, spent, last)

    def _nodes(self, nodes: list[Node], spent: int) -> Generator[Line, None, int | None]:
        """Yield the lines of these nodes; return what they cost, with `spent`, or None if they don't run to their end.

        `spent` is the cost of the instructions before that has not been charged yet.
        """
        for node in nodes:
            if isinstance(node, Choice):
                spent = yield from self._choice(node, spent)
                continue
            total = yield from self._instruction(node, spent)
            if total is None:  # nothing gets to what follows
                return None
            spent = total
        return spent

    def _stop(self, pc: int, spent: int) -> Iterator[Line]:
        if self._build is Build.WATCHED:
            yield Line(f"if stops_{self._number}[{pc}]:", pc)
            yield Line(f"{INDENT}return {STOP}, {pc}, {_rest(spent)}", pc)

    def _choice(
        self, choice: Choice, spent: int, word: str = "if", charged: int | None = None
    ) -> Generator[Line, None, int]:
        """Yield a branch and its arms.  What an arm costs beyond `charged` it charges itself."""
        pc = choice.pc
        branch = self._instructions[pc]
        assert isinstance(branch, Branch)
        if word == "if":
            yield from self._stop(pc, spent)
            yield from (Line(text, pc) for text in branch.python)
        spent += branch.cost
        charged = spent if charged is None else charged
        jump = self._instructions[choice.jump].cost if choice.jump is not None else 0
        arms = [(f"not ({branch.condition})", choice.through, jump), (branch.condition, choice.jumped, 0)]
        if not choice.through and not jump:
            arms.reverse()
        (condition, first, more), (_, second, other) = arms
        yield Line(f"{word} {condition}:", pc)
        yield from self._arm(first, spent, charged - more, pc)
        if len(second) == 1 and self._can_chain(second[0]):
            yield from self._choice(second[0], spent, "elif", charged)
        elif second or spent != charged:
            yield Line("else:", pc)
            yield from self._arm(second, spent, charged - other, pc)
        return charged

    def _can_chain(self, node: Node) -> TypeGuard[Choice]:
        """True for a branch that can be an `elif`, which runs nothing in front of its condition."""
        if self._build is Build.WATCHED or not isinstance(node, Choice):
            return False
        return not getattr(self._instructions[node.pc], "python", ())

    def _arm(self, nodes: list[Node], spent: int, charged: int, pc: int) -> Iterator[Line]:
        total = yield from _indented(self._nodes(nodes, spent))
        if total is not None and total != charged:
            yield Line(f"{INDENT}n -= {total - charged}", pc)
        elif not nodes:
            yield Line(f"{INDENT}pass", pc)

    def _instruction(self, pc: int, spent: int) -> Generator[Line, None, int | None]:
        yield from self._stop(pc, spent)
        instruction = self._instructions[pc]
        match instruction:
            case Do(python=python, cost=cost):
                yield from (Line(text, pc) for text in python)
                return spent + cost
            case Branch(python=python, condition=condition, target=target, cost=cost):
                yield from (Line(text, pc) for text in python)
                yield Line(f"if {condition}:", pc)
                yield from (Line(INDENT + text, pc) for text, _ in self._leave(target, spent + cost, pc))
                return spent + cost
            case Jump(target=target, cost=cost):
                yield from self._leave(target, spent + cost, pc)
            case Switch():
                yield from self._switch(instruction, pc, spent)
            case Call():
                yield from self._call(instruction, pc, spent + instruction.cost)
                return 0
            case End(cost=cost):
                yield Line(f"return {END}, {pc}, {_rest(spent + cost)}", pc)
            case Pause(python=python, condition=condition, cost=cost):
                yield from (Line(text, pc) for text in python)
                yield Line(f"if {condition}:", pc)
                yield Line(f"{INDENT}return {WAIT}, {pc + 1}, {_rest(spent + cost)}", pc)
                return spent + cost
            case Hold(condition=condition, cost=cost):
                yield Line(f"if {condition}:", pc)
                yield Line(f"{INDENT}return {WAIT}, {pc}, {_rest(spent)}", pc)
                return spent + cost
        return None

    def _switch(self, switch: Switch, pc: int, spent: int) -> Iterator[Line]:
        yield from (Line(text, pc) for text in switch.python)
        yield Line(f"n -= {spent + switch.cost}", pc)
        yield Line(f"at = {switch.selector}", pc)
        table = f"targets_{self._number}_{pc}"
        yield Line(f"pc = {table}[at] if at in {table} else {switch.otherwise}", pc)
        yield Line("break" if self.is_loop else "continue", pc)

    def _call(self, call: Call, pc: int, spent: int) -> Iterator[Line]:
        """Yield a Python call; in the STEPPED build, and where the stack has no room, return to the task instead."""
        number, size = self._callees[call.routine]
        frame = _added("frame", self._frame_size)
        if call.is_checked:
            yield Line(f"if {_added('frame', self._frame_size + size)} > limit[0]:", pc)
            yield Line(f"{INDENT}return {DEEP}, {pc}, {_rest(spent)}", pc)
        if self._build is Build.STEPPED:
            yield Line(f"enter({number}, {frame}, {call.base})", pc)
            yield Line(f"return {CALL}, {pc}, {_rest(spent)}", pc)
            return
        yield Line(f"why, at, n = routine_{number}(0, {_rest(spent)}, {frame}, {call.base})", pc)
        yield Line(f"if why != {END}:", pc)
        yield Line(f"{INDENT}leave({number}, {frame}, {call.base}, {self._number}, {pc + 1}, frame, base)", pc)
        yield Line(f"{INDENT}return why, at, n", pc)

    def _leave(self, target: int, spent: int, pc: int) -> Iterator[Line]:
        if spent:
            yield Line(f"n -= {spent}", pc)
        if self.is_loop and target == self._block.first:
            yield Line("continue", pc)
            return
        yield Line(f"pc = {target}", pc)
        yield Line("break" if self.is_loop else "continue", pc)


def _indented(lines: Generator[Line, None, Spent]) -> Generator[Line, None, Spent]:
    """Yield the lines one level deeper; return what their generator returns."""
    while True:
        try:
            text, pc = next(lines)
        except StopIteration as end:
            spent: Spent = end.value
            return spent
        yield Line(INDENT + text, pc)


def _rest(spent: int) -> str:
    return f"n - {spent}" if spent else "n"


def _added(name: str, number: int) -> str:
    return f"{name} + {number}" if number else name


_SUM = re.compile(r"\bbase \+ (\d+)\b|\bbase\b")


def at_fixed_base(text: str, base: int) -> str:
    """Return generated text in which `base` is a number."""
    return _SUM.sub(lambda match: str(base + int(match[1] or 0)), text)
