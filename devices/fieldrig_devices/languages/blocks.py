"""Divides the instructions of a routine into blocks, and finds the branches within a block.

A block is entered at its first instruction, its leader, and nowhere else.  A branch whose arms fit into the block is a
`Choice`, which becomes an `if` of Python; any other jump leaves the block, and its target is a leader.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from types import MappingProxyType
from typing import Final

from fieldrig_devices.languages.instructions import Branch, Call, Do, Hold, Instruction, Jump, Pause, Switch

LONGEST = 32  # instructions in a block, and so the most by which a slice may exceed its budget; marks don't count
DEEPEST_CHOICE = 12  # CPython's parser allows 100 levels of indentation


_NOTHING: Final = Do(0, ())


@dataclass(slots=True)
class Choice:
    """The branch at `pc` with its arms: `jumped` runs if its condition holds, `through` if not."""

    pc: int
    through: "list[Node]"
    jumped: "list[Node]"
    end: int
    """The instruction after both arms."""
    jump: int | None = None
    """The jump from the end of `through` over the other arm, which needs no Python."""


Node = int | Choice
"""A part of a block: one instruction by its number, or a branch with both arms."""


@dataclass(slots=True)
class Block:
    first: int
    end: int
    nodes: list[Node]


def blocks(
    instructions: Sequence[Instruction],
    inlined: Mapping[int, int] = MappingProxyType({}),
    entries: Collection[int] = (),
) -> list[Block]:
    """Return the blocks of a routine in order.

    `inlined` are the calls that the callee's instructions replace, with the number of these: they need no
    leader behind them.  `entries` are further leaders, where a routine goes on after a fault.
    """
    leaders = _hard_leaders([one if pc not in inlined else _NOTHING for pc, one in enumerate(instructions)])
    leaders |= {entry for entry in entries if entry < len(instructions)}
    ends, lengths = _ends(instructions, inlined), _ends(instructions, {})
    while True:
        firm = sorted(leaders)
        made = []
        for first, end in zip(firm, [*firm[1:], len(instructions)], strict=True):
            made += list(_divided(first, end, _Reader(instructions, lengths).read(first, end, 0), ends))
        wanted = {target for block in made for target in _outside(instructions, block.nodes, block)}
        if wanted <= leaders:
            return made
        leaders |= wanted


def _hard_leaders(instructions: Sequence[Instruction]) -> set[int]:
    """Return the instructions that must begin a block: those where a routine resumes, or a loop begins."""
    leaders = {0}
    for pc, instruction in enumerate(instructions):
        match instruction:
            case Branch(target=target) | Jump(target=target) if target <= pc:
                leaders.add(target)
            case Call() | Pause():
                leaders.add(pc + 1)
            case Hold():
                leaders.add(pc)
            case Switch(targets=targets, otherwise=otherwise):
                leaders |= {pc + 1, otherwise, *targets.values()}
    return {pc for pc in leaders if pc < len(instructions)}


class _Reader:
    """Reads a run of instructions without a leader in between as nodes."""

    def __init__(self, instructions: Sequence[Instruction], lengths: Sequence[int]) -> None:
        self._instructions, self._lengths = instructions, lengths

    def _is_near(self, pc: int, target: int) -> bool:
        return self._lengths[target] - self._lengths[pc] <= LONGEST

    def read(self, first: int, end: int, depth: int) -> list[Node]:
        nodes: list[Node] = []
        pc = first
        while pc < end:
            choice = self._choice(pc, end, depth)
            nodes.append(pc if choice is None else choice)
            pc = pc + 1 if choice is None else choice.end
        return nodes

    def _choice(self, pc: int, end: int, depth: int) -> Choice | None:
        branch = self._instructions[pc]
        if not isinstance(branch, Branch) or not pc < branch.target <= end or depth == DEEPEST_CHOICE:
            return None
        target = branch.target
        last = self._instructions[target - 1]
        has_other = isinstance(last, Jump) and target - 1 > pc and target < last.target <= end
        if isinstance(last, Jump) and has_other and self._is_near(pc, last.target):
            through = self.read(pc + 1, target - 1, depth + 1)
            # An arm that is one choice again becomes `elif`, which is not nested more deeply.
            is_chain = isinstance(self._instructions[target], Branch)
            jumped = self.read(target, last.target, depth + (not is_chain))
            return Choice(pc, through, jumped, last.target, target - 1)
        if not self._is_near(pc, target):
            return None
        return Choice(pc, self.read(pc + 1, target, depth + 1), [], target)


def _ends(instructions: Sequence[Instruction], inlined: Mapping[int, int]) -> list[int]:
    """Return how many instructions are in front of each one, and of the end, with those that replace calls."""
    return [0, *accumulate(length_of(one) + inlined.get(pc, 0) for pc, one in enumerate(instructions))]


def length_of(instruction: Instruction) -> int:
    """Return 1, or 0 for a mark of coverage: a program with marks has the blocks that it has without them."""
    return int(not isinstance(instruction, Do) or instruction.cost > 0)


def _divided(first: int, end: int, nodes: list[Node], ends: Sequence[int]) -> Iterator[Block]:
    """Yield blocks of at most LONGEST instructions."""
    start, part, length = first, list[Node](), 0
    for node in nodes:
        pc, after = (node, node + 1) if isinstance(node, int) else (node.pc, node.end)
        own = ends[after] - ends[pc]
        if part and length + own > LONGEST:
            yield Block(start, pc, part)
            start, part, length = pc, [], 0
        part.append(node)
        length += own
    yield Block(start, end, part)


def _outside(instructions: Sequence[Instruction], nodes: list[Node], block: Block) -> Iterator[int]:
    """Yield where the jumps lead that are no choices, and where the block ends."""
    if block.end < len(instructions):
        yield block.end
    for node in nodes:
        if isinstance(node, Choice):
            yield from _outside(instructions, node.through, block)
            yield from _outside(instructions, node.jumped, block)
            continue
        instruction = instructions[node]
        if isinstance(instruction, Branch | Jump):
            yield instruction.target
        elif isinstance(instruction, Switch):
            yield from (instruction.otherwise, *instruction.targets.values())
