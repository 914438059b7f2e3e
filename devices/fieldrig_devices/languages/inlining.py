"""Short routines whose instructions run instead of their calls, so that a call of a small block costs no Python call.

Only the FAST build does this.  A routine qualifies if it is one block with its END as the last instruction, and calls
at most others that qualify.  It cannot be interrupted then, so nothing ever resumes in the middle of it; a fault in it
still has its own place.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from typing import Final

from fieldrig_devices.languages.blocks import Block, Choice, Node, blocks
from fieldrig_devices.languages.instructions import Branch, Call, Do, End, Instruction, Routine

MOST: Final = 8  # instructions, with those of inlined calls
_QUOTES: Final = re.compile(r"""['\"]""")
_FRAME: Final = re.compile(r"\bframe \+ (\d+)\b|\bframe\b")
_BASE: Final = re.compile(r"\bbase \+ (\d+)\b|\bbase\b")
_NUMBER: Final = re.compile(r"(.*?)(?: \+ )?(\d+)")


class Inlining:
    """Finds the calls of a program that can be inlined."""

    def __init__(self, routines: Sequence[Routine], numbers: Mapping[str, int]) -> None:
        self._routines, self._numbers = routines, numbers
        self._known: dict[int, dict[int, int]] = {}
        self._in_circles: set[int] = set()
        """Routines that call themselves, through others perhaps; they are not inlined."""
        self.body: Callable[[int], Block | None] = cache(self._body)

    def calls(self, number: int) -> dict[int, int]:
        """Return the calls in a routine that are inlined, with the number of instructions that each adds.

        A row of calls may be longer than Python has room for, so the routines at its end come first.
        """
        path = {number: iter(self._short(number))} if number not in self._known else {}
        while path:
            last = next(reversed(path))
            called = next(path[last], None)
            if called is None:
                del path[last]
                self._known[last] = self._calls(last)
            elif called in path:
                self._in_circles.add(called)
            elif called not in self._known:
                path[called] = iter(self._short(called))
        return self._known[number]

    def _short(self, number: int) -> list[int]:
        """Return the short routines that a routine calls."""
        return [called for _, called in self._called(number) if len(self._routines[called].lines) <= MOST]

    def _called(self, number: int) -> Iterator[tuple[int, int]]:
        for pc, instruction in enumerate(self._routines[number].instructions):
            if isinstance(instruction, Call) and not instruction.is_checked:
                yield pc, self._numbers[instruction.routine]

    def _calls(self, number: int) -> dict[int, int]:
        return {pc: self._length(called) for pc, called in self._called(number) if self.body(called) is not None}

    def _length(self, number: int) -> int:
        return len(self._routines[number].lines) + sum(self.calls(number).values())

    def _body(self, number: int) -> Block | None:
        """Return the one block of a routine that can be inlined."""
        routine = self._routines[number]
        if number in self._in_circles or routine.guards:
            return None
        if len(routine.lines) > MOST or not all(map(_is_plain, routine.instructions[:-1])):
            return None
        calls = sum(isinstance(instruction, Call) for instruction in routine.instructions)
        if not isinstance(routine.instructions[-1], End) or len(self.calls(number)) != calls:
            return None
        if self._length(number) > MOST:
            return None
        parts = blocks(routine.instructions, self.calls(number))
        return parts[0] if len(parts) == 1 and not _leaves(routine.instructions, parts[0].nodes[:-1]) else None


def _is_plain(instruction: Instruction) -> bool:
    match instruction:
        case Do(python=python):
            return not any(map(_QUOTES.search, python))
        case Branch(python=python, condition=condition):
            return not any(map(_QUOTES.search, (*python, condition)))
    return not isinstance(instruction, End)


def _leaves(instructions: Sequence[Instruction], nodes: Sequence[Node]) -> bool:
    """True if anything jumps out of these nodes."""
    for node in nodes:
        if isinstance(node, Choice):
            if _leaves(instructions, node.through) or _leaves(instructions, node.jumped):
                return True
        elif not isinstance(instructions[node], Do | Call):
            return True
    return False


def moved(text: str, frame_size: int, base: str) -> str:
    """Return a callee's text as its caller has to say it: the frame follows the caller's, and `base` is given."""
    text = _FRAME.sub(lambda match: f"frame + {frame_size + int(match[1] or 0)}", text)
    return _BASE.sub(lambda match: added(base, int(match[1] or 0)), text)


def added(base: str, number: int) -> str:
    """Return the sum of an expression such as `base + 4` and a number."""
    match = _NUMBER.fullmatch(base)
    if match is None:
        return f"{base} + {number}" if number else base
    total = int(match[2]) + number
    return f"{match[1]} + {total}" if match[1] else str(total)
