"""A program as generated Python that returns by itself when its budget is used up, and resumes where it was.

A language lowers each of its routines to a list of instructions: Python lines that run through (`Do`), jumps, calls,
and places where it waits.  This file turns each list into one Python function, `routine(pc, n, depth) -> (why, pc, n)`:
`pc` is the next instruction, `n` the number of instructions that it may still run.  All lasting state is in the tables
that the code was given, so a routine that has returned is fully described by its `pc`: it can be stored, compared, and
resumed by another build of the same routine.  A call is a Python call; if the called routine has to return before its
end, each of its callers records where it was (`leave`) and returns too, and the task resumes with that stack of places.

Each routine has three builds, made when they are first needed:

    FAST     can be entered at block starts only: jump targets, after calls and waits, and every `LONGEST` instructions.
             The budget is charged at the end of a block, so a slice may exceed it by less than a block (n < 0)
    WATCHED  the same, but stops in front of each instruction whose flag is set in its table of stops
    STEPPED  can be entered anywhere; for single steps, and to get from a breakpoint to the next block

A block that jumps to its own start becomes a Python loop; other jumps find their block by a tree of comparisons.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Final, NamedTuple

from fieldrig import sandbox

LONGEST = 32  # instructions in a block, and so the most by which a slice may exceed its budget
INDENT = "    "


# Why a routine returned.  These are plain integers because they are compared after every call and return.
SLICE: Final = 0  # the budget is used up
CALL: Final = 1  # the instruction at pc is a call; its target is in `calls`
END: Final = 2
WAIT: Final = 3  # at a Pause or Hold: resume at pc in another slice
STOP: Final = 4  # in front of an instruction with a breakpoint


@dataclass(frozen=True, slots=True)
class Do:
    """An instruction that runs `python` and continues with the next one."""

    line: int
    python: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Branch:
    """An instruction that runs `python` and then jumps if `condition` holds."""

    line: int
    python: tuple[str, ...]
    condition: str
    target: int


@dataclass(frozen=True, slots=True)
class Jump:
    line: int
    target: int


@dataclass(frozen=True, slots=True)
class Call:
    line: int
    routine: str


@dataclass(frozen=True, slots=True)
class End:
    line: int


@dataclass(frozen=True, slots=True)
class Pause:
    """An instruction that runs `python`, then ends the slice if `condition` holds; the next one starts after it."""

    line: int
    python: tuple[str, ...]
    condition: str


@dataclass(frozen=True, slots=True)
class Hold:
    """An instruction that ends the slice while `condition` holds; the next slice evaluates it again."""

    line: int
    condition: str


Instruction = Do | Branch | Jump | Call | End | Pause | Hold
Function = Callable[[int, int, int], tuple[int, int, int]]


class Left(NamedTuple):
    """A call that was in progress when the routines had to return: `caller` resumes at `pc`."""

    called: int
    caller: int
    pc: int


class Build(IntEnum):
    FAST = 0
    WATCHED = 1
    STEPPED = 2


class Code:
    """The routines of one program.  `python` may use `names` and the local variables t0, t1, ..., and nothing else."""

    def __init__(
        self, routines: Mapping[str, Sequence[Instruction]], names: Mapping[str, object], deepest: int
    ) -> None:
        """`deepest` is the greatest number of nested calls."""
        self.deepest = deepest
        self.routines = [tuple(instructions) for instructions in routines.values()]
        self.numbers = {name: number for number, name in enumerate(routines)}
        self.calls = [
            {
                pc: self.numbers[instruction.routine]
                for pc, instruction in enumerate(instructions)
                if isinstance(instruction, Call)
            }
            for instructions in self.routines
        ]
        self.leaders = [frozenset(leaders(instructions)) for instructions in self.routines]
        self.stops = [[0] * len(instructions) for instructions in self.routines]
        self.left: list[Left] = []
        """Calls that were in progress when the last run ended, innermost first; the task clears the list."""
        own = {"leave": lambda called, caller, pc: self.left.append(Left(called, caller, pc))}
        self.names = {**names, **own, **{f"stops_{number}": stops for number, stops in enumerate(self.stops)}}
        self._built: dict[Build, list[Function]] = {}

    def functions(self, build: Build) -> list[Function]:
        if build not in self._built:
            functions = sandbox.load(self.source(build), self.names)
            self._built[build] = [functions[f"routine_{number}"] for number in range(len(self.routines))]
        return self._built[build]

    def source(self, build: Build) -> str:
        parts = (_Writer(self, number, build).lines() for number in range(len(self.routines)))
        return "\n".join(line for part in parts for line in part) + "\n"

    def line(self, routine: int, pc: int) -> int:
        """Return the source line of an instruction."""
        return self.routines[routine][pc].line

    def stop_at(self, lines: set[int]) -> set[int]:
        """Replace all breakpoints by these source lines; return those lines that have an instruction to stop at."""
        found = set()
        for instructions, stops in zip(self.routines, self.stops, strict=True):
            before = 0
            for pc, instruction in enumerate(instructions):
                stops[pc] = int(instruction.line in lines and instruction.line != before)  # stop once per line
                before = instruction.line
                found |= {instruction.line} & lines
        return found


def leaders(instructions: Sequence[Instruction]) -> list[int]:
    """Return the instructions at which blocks begin, in order."""
    found = {0}
    for pc, instruction in enumerate(instructions):
        if isinstance(instruction, Branch | Jump):
            found.add(instruction.target)
        if isinstance(instruction, Call | Pause | Jump):
            found.add(pc + 1)
        if isinstance(instruction, Hold):
            found.add(pc)
    firm = sorted(pc for pc in found if pc < len(instructions))
    ends = [*firm[1:], len(instructions)]
    return [pc for first, end in zip(firm, ends, strict=True) for pc in range(first, end, LONGEST)]


class _Writer:
    """Writes the Python source of one build of one routine."""

    def __init__(self, code: Code, number: int, build: Build) -> None:
        self._code, self._number, self._build = code, number, build
        self._instructions = code.routines[number]
        entries = range(len(self._instructions)) if build is Build.STEPPED else code.leaders[number]
        self._leaders = sorted(entries)

    def lines(self) -> Iterator[str]:
        yield f"def routine_{self._number}(pc, n, depth):"
        yield f"{INDENT}while n > 0:"
        yield from self._tree(0, len(self._leaders), INDENT * 2)
        yield f"{INDENT}return {SLICE}, pc, n"

    def _tree(self, first: int, end: int, indent: str) -> Iterator[str]:
        """Yield the blocks from `first` to before `end`, with a binary search over `pc` in front of them."""
        if end - first == 1:
            yield from self._block(first, indent)
            return
        middle = (first + end) // 2
        yield f"{indent}if pc < {self._leaders[middle]}:"
        yield from self._tree(first, middle, indent + INDENT)
        yield f"{indent}else:"
        yield from self._tree(middle, end, indent + INDENT)

    def _block(self, index: int, indent: str) -> Iterator[str]:
        first = self._leaders[index]
        end = self._leaders[index + 1] if index + 1 < len(self._leaders) else len(self._instructions)
        is_loop = any(getattr(instruction, "target", None) == first for instruction in self._instructions[first:end])
        if is_loop:
            yield f"{indent}while n > 0:"
            indent += INDENT
        for pc in range(first, end):
            yield from (indent + line for line in self._instruction(pc, first, is_loop))
        last = self._instructions[end - 1]
        if not isinstance(last, Jump | End) and not (isinstance(last, Call) and self._build is Build.STEPPED):
            count = 0 if isinstance(last, Call) else end - first  # the call has charged all of them
            yield from (indent + line for line in self._leave(end, count, first, is_loop))

    def _instruction(self, pc: int, first: int, is_loop: bool) -> Iterator[str]:
        before = pc - first  # instructions of this block that have already run; each costs one
        if self._build is Build.WATCHED:
            yield f"if stops_{self._number}[{pc}]:"
            yield f"{INDENT}return {STOP}, {pc}, n - {before}"
        match self._instructions[pc]:
            case Do(python=python):
                yield from python
            case Branch(python=python, condition=condition, target=target):
                yield from python
                yield f"if {condition}:"
                yield from (INDENT + line for line in self._leave(target, before + 1, first, is_loop))
            case Jump(target=target):
                yield from self._leave(target, before + 1, first, is_loop)
            case Call():
                yield from self._call(pc, before + 1)
            case End():
                yield f"return {END}, {pc}, n - {before + 1}"
            case Pause(python=python, condition=condition):
                yield from python
                yield f"if {condition}:"
                yield f"{INDENT}return {WAIT}, {pc + 1}, n - {before + 1}"
            case Hold(condition=condition):
                yield f"if {condition}:"
                yield f"{INDENT}return {WAIT}, {pc}, n - {before}"

    def _call(self, pc: int, count: int) -> Iterator[str]:
        """Yield a Python call; in the STEPPED build, and where the nesting is too deep, return to the task instead."""
        if self._build is Build.STEPPED:
            yield f"return {CALL}, {pc}, n - {count}"
            return
        called = self._code.calls[self._number][pc]
        yield f"if depth >= {self._code.deepest}:"
        yield f"{INDENT}return {CALL}, {pc}, n - {count}"
        yield f"why, at, n = routine_{called}(0, n - {count}, depth + 1)"
        yield f"if why != {END}:"
        yield f"{INDENT}leave({called}, {self._number}, {pc + 1})"
        yield f"{INDENT}return why, at, n"

    def _leave(self, target: int, count: int, first: int, is_loop: bool) -> Iterator[str]:
        if count:
            yield f"n -= {count}"
        if is_loop and target == first:
            yield "continue"
            return
        yield f"pc = {target}"
        yield "break" if is_loop else "continue"
