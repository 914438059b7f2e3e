"""Writes the Python function of one build of one routine.

A block that jumps to its own start becomes a Python loop, a branch within a block becomes an `if`, and all other jumps
find their block by a tree of comparisons.  Costs are charged where a block or an arm of a branch is left.
"""

from collections.abc import Generator, Iterator, Mapping, Sequence
from enum import IntEnum
from typing import Final, NamedTuple, TypeGuard, TypeVar

from fieldrig_devices.languages.blocks import Block, Choice, Node
from fieldrig_devices.languages.inlining import Inlining, moved
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
from fieldrig_devices.languages.registers import is_register, kept

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
    calls: tuple[tuple[int, int], ...] = ()
    """The inlined routines that the line belongs to, as their numbers and their instructions, outermost first."""
    spent: int = 0
    """The cost of the instructions before it that has not been charged when it runs."""


class Callee(NamedTuple):
    number: int
    frame_size: int


class Writer:
    def __init__(
        self,
        number: int,
        routines: Sequence[Routine],
        callees: Mapping[str, Callee],
        blocks: list[Block],
        build: Build,
        inlining: Inlining,
    ) -> None:
        self._number, self._callees, self._build, self._blocks = number, callees, build, blocks
        self._routines, self._inlining = routines, inlining
        routine = routines[number]
        if build is Build.STEPPED:
            self._blocks = [Block(pc, pc + 1, [pc]) for pc in range(len(routine.instructions))]

    def lines(self) -> list[Line]:
        lines = [Line(f"def routine_{self._number}(pc, n, frame, base):", 0), Line(f"{INDENT}while n > 0:", 0)]
        self._add_tree(lines, 0, len(self._blocks), INDENT * 2)
        lines.append(Line(f"{INDENT}return {SLICE}, pc, n", 0))
        return lines

    def _add_tree(self, lines: list[Line], first: int, end: int, indent: str) -> None:
        """Add the blocks from `first` to before `end`, with a binary search over `pc` in front of them."""
        if end - first == 1:
            lines += self._block(self._blocks[first], indent)
            return
        middle = (first + end) // 2
        lines.append(Line(f"{indent}if pc < {self._blocks[middle].first}:", 0))
        self._add_tree(lines, first, middle, indent + INDENT)
        lines.append(Line(f"{indent}else:", 0))
        self._add_tree(lines, middle, end, indent + INDENT)

    def _block(self, block: Block, indent: str) -> Iterator[Line]:
        part = _BlockWriter(self._number, self._build, self._routines, self._callees, block, self._inlining)
        lines = list(part.lines())
        texts: list[str | None] = [line.text for line in lines]
        loads = list[str]()
        if part.registers:
            loads, texts = kept([line.text for line in lines], part.registers, is_loop=part.is_loop)
        yield from (Line(indent + text, block.first) for text in loads)
        if part.is_loop:
            yield Line(f"{indent}while n > 0:", block.first)
            indent += INDENT
        for text, line in zip(texts, lines, strict=True):
            if text is not None:
                yield line._replace(text=indent + text)


class _BlockWriter:
    def __init__(
        self,
        number: int,
        build: Build,
        routines: Sequence[Routine],
        callees: Mapping[str, Callee],
        block: Block,
        inlining: Inlining,
    ) -> None:
        self._number, self._build, self._callees, self._block = number, build, callees, block
        self._routines, self._inlining = routines, inlining
        self._inlined = inlining.calls(number) if build is Build.FAST else {}
        self._instructions, self._frame_size = routines[number].instructions, routines[number].frame_size
        self.registers = self._registers() if build is Build.FAST else frozenset()
        """The cells that the lines of this block may keep in local variables, apart from those of inlined routines."""
        part = self._instructions[block.first : block.end]
        self.is_loop = any(getattr(instruction, "target", None) == block.first for instruction in part)

    def _registers(self) -> frozenset[str]:
        registers = self._routines[self._number].registers
        inlined = set[str]()
        for pc in range(self._block.first, self._block.end):
            if pc in self._inlined:
                call = self._instructions[pc]
                assert isinstance(call, Call)
                number = self._callees[call.routine].number
                body = self._inlining.body(number)
                assert body is not None
                inner = _BlockWriter(number, self._build, self._routines, self._callees, body, self._inlining)
                moved_ = (moved(text, self._frame_size, call.base) for text in inner.registers)
                inlined |= {text for text in moved_ if is_register(text)}
        return registers | inlined if inlined else registers

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
            yield from (Line(text, pc, spent=spent) for text in branch.python)
        before, spent = spent, spent + branch.cost
        charged = spent if charged is None else charged
        jump = self._instructions[choice.jump].cost if choice.jump is not None else 0
        arms = [(f"not ({branch.condition})", choice.through, jump), (branch.condition, choice.jumped, 0)]
        if not choice.through and not jump:
            arms.reverse()
        (condition, first, more), (_, second, other) = arms
        yield Line(f"{word} {condition}:", pc, spent=before)
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
                yield from (Line(text, pc, spent=spent) for text in python)
                return spent + cost
            case Branch(python=python, condition=condition, target=target, cost=cost, pause=pause):
                yield from (Line(text, pc, spent=spent) for text in python)
                yield Line(f"if {condition}:", pc, spent=spent)
                if pause and target <= pc:
                    yield Line(f"{INDENT}if {pause}:", pc)
                    yield Line(f"{INDENT * 2}return {WAIT}, {target}, {_rest(spent + cost)}", pc)
                yield from (Line(INDENT + text, pc) for text, *_ in self._leave(target, spent + cost, pc))
                return spent + cost
            case Jump(target=target, cost=cost):
                yield from self._leave(target, spent + cost, pc)
            case Switch():
                yield from self._switch(instruction, pc, spent)
            case Call() if pc in self._inlined:
                return (yield from self._inline(instruction, pc, spent))
            case Call():
                yield from self._call(instruction, pc, spent + instruction.cost)
                return 0
            case End(cost=cost):
                yield Line(f"return {END}, {pc}, {_rest(spent + cost)}", pc)
            case Pause(python=python, condition=condition, cost=cost):
                yield from (Line(text, pc, spent=spent) for text in python)
                yield Line(f"if {condition}:", pc, spent=spent)
                yield Line(f"{INDENT}return {WAIT}, {pc + 1}, {_rest(spent + cost)}", pc)
                return spent + cost
            case Hold(condition=condition, cost=cost):
                yield Line(f"if {condition}:", pc, spent=spent)
                yield Line(f"{INDENT}return {WAIT}, {pc}, {_rest(spent)}", pc)
                return spent + cost
        return None

    def _switch(self, switch: Switch, pc: int, spent: int) -> Iterator[Line]:
        yield from (Line(text, pc, spent=spent) for text in switch.python)
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

    def _inline(self, call: Call, pc: int, spent: int) -> Generator[Line, None, int]:
        """Yield the callee's instructions instead of a call."""
        number = self._callees[call.routine].number
        body = self._inlining.body(number)
        assert body is not None
        inner = _BlockWriter(number, self._build, self._routines, self._callees, body, self._inlining)
        lines = inner._nodes(body.nodes[:-1], spent + call.cost)
        while True:
            try:
                text, at, calls, uncharged = next(lines)
            except StopIteration as end:
                end_cost = self._routines[number].instructions[-1].cost
                return int(end.value) + end_cost
            yield Line(moved(text, self._frame_size, call.base), pc, ((number, at), *calls), uncharged)

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
            line = next(lines)
        except StopIteration as end:
            spent: Spent = end.value
            return spent
        yield line._replace(text=INDENT + line.text)


def _rest(spent: int) -> str:
    return f"n - {spent}" if spent else "n"


def _added(name: str, number: int) -> str:
    return f"{name} + {number}" if number else name
