"""The instructions that a language lowers its routines to: Python that runs through, jumps, calls, and places to wait.

`resumable` turns a list of them into Python functions.  `line` is the source line, and `cost` is what an instruction
takes from the budget of a slice, in any unit: a language may count instructions or nanoseconds.  `python` may use the
names that the code was given, `frame` and `base` of the routine, and local variables of its own that only have to last
until the end of the instruction.
"""

import pickle
from array import array
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple


@dataclass(frozen=True, slots=True)
class Do:
    """An instruction that runs `python` and continues with the next one."""

    line: int
    python: tuple[str, ...]
    cost: int = 1


@dataclass(frozen=True, slots=True)
class Branch:
    """An instruction that runs `python` and then jumps if `condition` holds.

    A jump back also ends the slice if `pause` holds; the next slice starts at the target.
    """

    line: int
    python: tuple[str, ...]
    condition: str
    target: int
    cost: int = 1
    pause: str = ""


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


class Guard(NamedTuple):
    """The instructions from `first` to before `end`: a fault in them goes on at `target`."""

    first: int
    end: int
    target: int
    cell: int
    """The place in the frame that gets the number of the fault."""


Instruction = Do | Branch | Jump | Switch | Call | End | Pause | Hold


class ForDebugging(NamedTuple):
    """The builds and leaders of one routine that breakpoints and single steps need, made in advance."""

    watched: bytes
    stepped: bytes
    leaders: frozenset[int]


class Routine:
    """The instructions of one routine, and the size of its frame on the stack of the task.

    The instructions of a routine that came from another process stay packed until they are needed for debugging, so
    that loading a large program takes little time.  Its builds are left out of the pickled bytes, so that nothing
    copies them (`fieldrig.loop.background`).
    """

    def __init__(
        self,
        instructions: Sequence[Instruction],
        frame_size: int = 1,
        registers: frozenset[str] = frozenset(),
        guards: tuple[Guard, ...] = (),
    ) -> None:
        """`registers` are the cells that blocks may keep in local variables (`registers`)."""
        self.frame_size = frame_size
        self.guards = guards
        """The instructions whose faults are caught, the inner ones first."""
        self.lines = tuple(instruction.line for instruction in instructions)
        self.fast = b""
        """The FAST build, if it has been made in advance; and where it can be entered."""
        self.fast_leaders: frozenset[int] = frozenset()
        self.for_debugging: bytes | bytearray | memoryview = b""
        """A pickled `ForDebugging`, if it has been made in advance."""
        self.targets = {
            pc: instruction.targets for pc, instruction in enumerate(instructions) if isinstance(instruction, Switch)
        }
        """The table of each Switch."""
        self._content: tuple[tuple[Instruction, ...], frozenset[str]] | None = tuple(instructions), registers
        self._packed = b""

    def postpone(self, packed: bytes) -> None:
        """Take the instructions and registers in pickled form, and unpickle them when they are needed."""
        self._packed, self._content = packed, None

    @property
    def instructions(self) -> tuple[Instruction, ...]:
        return self._unpacked()[0]

    @property
    def registers(self) -> frozenset[str]:
        return self._unpacked()[1]

    def _unpacked(self) -> tuple[tuple[Instruction, ...], frozenset[str]]:
        if self._content is None:
            self._content = pickle.loads(self._packed)
        return self._content

    def debugging(self) -> ForDebugging | None:
        """Return what has been made in advance for breakpoints and single steps."""
        return pickle.loads(self.for_debugging) if self.for_debugging else None

    def __reduce_ex__(self, protocol: Any) -> tuple[Any, ...]:
        packed = self._packed or pickle.dumps(self._content)
        lines = array("q", self.lines).tobytes()
        large = (self.fast, self.for_debugging, packed, lines)
        parts = tuple(bytes(part) if protocol < 5 else pickle.PickleBuffer(part) for part in large)
        return _unpickled, ((self.frame_size, self.guards), self.targets, self.fast_leaders, *parts)


def _unpickled(
    frame: tuple[int, tuple[Guard, ...]],
    targets: dict[int, Mapping[int, int]],
    fast_leaders: frozenset[int],
    fast: bytes,
    for_debugging: bytes,
    packed: bytes,
    lines: bytes,
) -> Routine:
    frame_size, guards = frame
    routine = Routine((), frame_size, guards=guards)
    numbers = array("q")
    numbers.frombytes(lines)
    routine.lines, routine.targets, routine.fast_leaders = tuple(numbers), targets, fast_leaders
    routine.fast, routine.for_debugging = fast, for_debugging
    routine.postpone(packed)
    return routine
