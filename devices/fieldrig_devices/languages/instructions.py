"""The instructions that a language lowers its routines to: Python that runs through, jumps, calls, and places to wait.

`resumable` turns a list of them into Python functions.  `line` is the source line, and `cost` is what an instruction
takes from the budget of a slice, in any unit: a language may count instructions or nanoseconds.  `python` may use the
names that the code was given, `frame` and `base` of the routine, and local variables of its own that only have to last
until the end of the instruction.
"""

import pickle
from collections.abc import Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Do:
    """An instruction that runs `python` and continues with the next one."""

    line: int
    python: tuple[str, ...]
    cost: int = 1


@dataclass(frozen=True, slots=True)
class Branch:
    """An instruction that runs `python` and then jumps if `condition` holds."""

    line: int
    python: tuple[str, ...]
    condition: str
    target: int
    cost: int = 1


@dataclass(frozen=True, slots=True)
class Jump:
    line: int
    target: int
    cost: int = 1


@dataclass(frozen=True, slots=True)
class Switch:
    """An instruction that runs `python` and jumps to `targets[selector]`, or to `otherwise` if there is none."""

    line: int
    python: tuple[str, ...]
    selector: str
    targets: Mapping[int, int]
    otherwise: int
    cost: int = 1


@dataclass(frozen=True, slots=True)
class Call:
    """A call of a routine, whose frame follows the caller's.

    `base` is an expression for the callee's base, without a side effect: a name, a number, or a sum of them.
    """

    line: int
    routine: str
    base: str = "base"
    cost: int = 1
    is_checked: bool = True
    """False if it is known that the stack cannot overflow here."""


@dataclass(frozen=True, slots=True)
class End:
    line: int
    cost: int = 1


@dataclass(frozen=True, slots=True)
class Pause:
    """An instruction that runs `python`, then ends the slice if `condition` holds; the next one starts after it."""

    line: int
    python: tuple[str, ...]
    condition: str
    cost: int = 1


@dataclass(frozen=True, slots=True)
class Hold:
    """An instruction that ends the slice while `condition` holds; the next slice evaluates it again."""

    line: int
    condition: str
    cost: int = 1


Instruction = Do | Branch | Jump | Switch | Call | End | Pause | Hold


class Routine:
    """The instructions of one routine, and the size of its frame on the stack of the task.

    The instructions of a routine that came from another process stay packed until they are needed for debugging, so
    that loading a large program takes little time.
    """

    def __init__(self, instructions: Sequence[Instruction], frame_size: int = 1) -> None:
        self.frame_size = frame_size
        self.lines = tuple(instruction.line for instruction in instructions)
        self.fast = b""
        """The FAST build, if it has been made in advance."""
        self._instructions: tuple[Instruction, ...] | None = tuple(instructions)
        self._packed = b""

    @property
    def instructions(self) -> tuple[Instruction, ...]:
        if self._instructions is None:
            self._instructions = pickle.loads(self._packed)
        return self._instructions

    def __getstate__(self) -> tuple[int, tuple[int, ...], bytes, bytes]:
        packed = self._packed or pickle.dumps(self._instructions)
        return self.frame_size, self.lines, self.fast, packed

    def __setstate__(self, state: tuple[int, tuple[int, ...], bytes, bytes]) -> None:
        self.frame_size, self.lines, self.fast, self._packed = state
        self._instructions = None
