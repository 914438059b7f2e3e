"""A program as generated Python that returns by itself when its budget is used up, and resumes where it was.

A language lowers each of its routines to a list of instructions (`instructions`).  This file turns each list into one
Python function, `routine(pc, n, frame, base) -> (why, pc, n)`: `pc` is the next instruction, `n` the budget that is
left, `frame` where the routine's part of the task's stack begins, and `base` where the instance is that it works on.
All lasting state is in the tables that the code was given, so a routine that has returned is fully described by `pc`,
`frame` and `base`: it can be stored, compared, and resumed by another build of the same routine.  A call is a Python
call; if the called routine has to return before its end, each of its callers records where it was (`leave`) and returns
too, and the task resumes with that stack of places.

Each routine has three builds, made when they are first needed:

    FAST     can be entered at block starts only: jump targets, after calls and waits, and every `LONGEST` instructions.
             The budget is charged at the end of a block, so a slice may exceed it by less than a block (n < 0)
    WATCHED  the same, but stops in front of each instruction whose flag is set in its table of stops
    STEPPED  can be entered anywhere; for single steps, and to get from a breakpoint to the next block
"""

import marshal
import pickle
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import cache, lru_cache
from typing import Any, NamedTuple

from fieldrig import sandbox
from fieldrig_devices.languages.blocks import Block, blocks
from fieldrig_devices.languages.inlining import Inlining
from fieldrig_devices.languages.instructions import ForDebugging, Instruction, Routine
from fieldrig_devices.languages.writer import Build, Callee, Line, Writer

Function = Callable[[int, int, int, int], tuple[int, int, int]]
MOST_TEXTS = 8  # Python texts of routines that are kept; a program may catch one fault after the other
OWN_FUNCTIONS = ("leave", "enter")


class Activation(NamedTuple):
    """A place in a routine, with the frame and the base with which it goes on there."""

    routine: int
    pc: int
    frame: int
    base: int


class Left(NamedTuple):
    """A call that was in progress when the routines had to return: `caller` resumes at its place."""

    called: int
    frame: int
    base: int
    caller: Activation


class Texts:
    """The Python texts of the routines of one program, and their checked builds."""

    def __init__(
        self,
        routines: Sequence[Routine],
        numbers: Mapping[str, int],
        names: Collection[str],
        rules: sandbox.Rules | None,
    ) -> None:
        """`names` are those that the program's own Python may use, under `rules`."""
        self.routines = routines
        self._callees = {name: Callee(number, routines[number].frame_size) for name, number in numbers.items()}
        tables = {"limit", *(name for number in range(len(routines)) for name in self._tables_of(number))}
        self._names = frozenset(
            {*names, *OWN_FUNCTIONS, *tables, *(f"routine_{number}" for number in range(len(routines)))}
        )
        self._rules = sandbox.Values(rules.values | tables) if isinstance(rules, sandbox.Values) else rules
        self._inlining = Inlining(routines, numbers)
        self.blocks: Callable[[int, Build], list[Block]] = cache(self._blocks)
        self.lines: Callable[[int, Build], list[Line]] = lru_cache(MOST_TEXTS)(self._lines)
        self.leaders: Callable[[int, Build], frozenset[int]] = cache(self._leaders)
        self._ready: dict[int, ForDebugging] = {}

    def _debugging(self, number: int) -> ForDebugging | None:
        """Return what has been made in advance for breakpoints and single steps, also since the last call."""
        if number not in self._ready and (prepared := self.routines[number].debugging()) is not None:
            self._ready[number] = prepared
        return self._ready.get(number)

    def _blocks(self, number: int, build: Build) -> list[Block]:
        inlined = self._inlining.calls(number) if build is Build.FAST else {}
        routine = self.routines[number]
        return blocks(routine.instructions, inlined, {guard.target for guard in routine.guards})

    def _leaders(self, number: int, build: Build) -> frozenset[int]:
        if build is Build.FAST:
            known = self.routines[number].fast_leaders
        else:
            ready = self._debugging(number)
            known = ready.leaders if ready else frozenset()
        return known or frozenset(block.first for block in self.blocks(number, build))

    def in_advance(self, number: int, build: Build) -> bytes:
        """Return a build that was made in advance, or nothing."""
        if build is Build.FAST:
            return self.routines[number].fast
        ready = self._debugging(number)
        return b"" if ready is None else ready.watched if build is Build.WATCHED else ready.stepped

    def for_debugging(self, number: int) -> bytes:
        """Make what breakpoints and single steps need in advance."""
        watched, stepped = (self.compiled(number, build) for build in (Build.WATCHED, Build.STEPPED))
        return pickle.dumps(ForDebugging(watched, stepped, self.leaders(number, Build.WATCHED)))

    def _lines(self, number: int, build: Build) -> list[Line]:
        parts = self.blocks(number, build)
        return Writer(number, self.routines, self._callees, parts, build, self._inlining).lines()

    def source(self, number: int, build: Build) -> str:
        return "".join(f"{line.text}\n" for line in self.lines(number, build))

    def tables(self, number: int) -> dict[str, object]:
        """Return the tables that the routine uses besides the program's."""
        return {f"targets_{number}_{pc}": targets for pc, targets in self.routines[number].targets.items()}

    def _tables_of(self, number: int) -> tuple[str, ...]:
        return f"stops_{number}", *self.tables(number)

    def compiled(self, number: int, build: Build) -> bytes:
        """Return a checked build of one routine."""
        return marshal.dumps(sandbox.compiled(self.source(number, build), self._names, self._rules, file_name(number)))


def file_name(number: int) -> str:
    """Return what the traceback of generated code names as its file."""
    return f"<routine {number}>"


def prepare(
    routines: Mapping[str, Routine],
    names: Collection[str],
    rules: sandbox.Rules | None = None,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
    is_debugged: bool = False,
) -> None:
    """Make the FAST builds in advance, for example in another process than the one that runs them.

    With `is_debugged` the others as well, so that no breakpoint stops the process for the time of a compilation.
    """
    texts = Texts(list(routines.values()), {name: number for number, name in enumerate(routines)}, names, rules)
    steps = len(routines) * (2 if is_debugged else 1)
    for number, routine in enumerate(routines.values()):
        if not routine.fast:
            routine.fast = texts.compiled(number, Build.FAST)
            routine.fast_leaders = texts.leaders(number, Build.FAST)
        on_progress(number + 1, steps)
    for number, routine in enumerate(routines.values() if is_debugged else ()):
        routine.for_debugging = texts.for_debugging(number)
        on_progress(len(routines) + number + 1, steps)


class Code:
    """The routines of one program.  Its `python` may use `names`, `frame`, `base` and local variables."""

    def __init__(
        self,
        routines: Mapping[str, Sequence[Instruction] | Routine],
        names: Mapping[str, object],
        stack_size: int,
        rules: sandbox.Rules | None = None,
        faults: tuple[type[Exception], ...] = (),
        catch: Callable[[BaseException, int], bool] = lambda fault, cell: False,
    ) -> None:
        """`stack_size` is the size of a task's stack: the number of active routines where all frames have size 1.

        `faults` are exceptions that this program may raise by a mistake of its own, besides `faults.CAUGHT`.
        `catch` puts the number of a fault into a cell, for the guards of routines; it is false if none may have it.
        """
        self.catch = catch
        self.faults = faults
        self.routines = [routine if isinstance(routine, Routine) else Routine(routine) for routine in routines.values()]
        self.numbers = {name: number for number, name in enumerate(routines)}
        self.names_of_routines = list(routines)
        self.stack_size = stack_size
        self.limit = [0]
        """The end of the stack of the running task; set by the task."""
        self.left: list[Left] = []
        """Calls that were in progress when the last run ended, innermost first; the task clears the list."""
        self.entered = Activation(0, 0, 0, 0)
        """The routine that the task has to enter after a CALL."""
        self.called: set[int] = set()
        """The numbers of the routines that have been called."""
        self.stops = [[0] * len(routine.lines) for routine in self.routines]
        self.names = names
        self._texts = Texts(self.routines, self.numbers, names, rules)
        self._functions: dict[Build, list[Function]] = {}
        self._scopes: dict[Build, dict[str, Any]] = {}

    def functions(self, build: Build) -> list[Function]:
        """Return the functions of a build; each is compiled when it is first called."""
        if build not in self._functions:
            functions = [self._later(number, build) for number in range(len(self.routines))]
            self._functions[build] = functions
            self._scopes[build] = self._scope() | {
                f"routine_{number}": function for number, function in enumerate(functions)
            }
        return self._functions[build]

    def adopt(self, builds: Iterable[tuple[int, bytes | bytearray | memoryview]]) -> None:
        """Take what another process has made of routines for breakpoints and single steps, by their numbers."""
        for number, build in builds:
            self.routines[number].for_debugging = build

    def compile(self, build: Build = Build.FAST) -> None:
        """Compile all routines now, while nothing runs, and not when they are first called."""
        self.functions(build)
        for number in range(len(self.routines)):
            self._load(number, build)

    def close(self) -> None:
        """Forget all functions.  They refer to each other, and to the tables of the program, by their globals: what is
        not closed waits for a search for circular garbage, and with it the whole memory of the program.
        """
        for scope in self._scopes.values():
            scope.clear()
        self._scopes.clear()
        for functions in self._functions.values():
            functions.clear()
        self._functions.clear()

    def _scope(self) -> dict[str, Any]:
        def leave(called: int, at: int, on: int, caller: int, pc: int, frame: int, base: int) -> None:
            self.left.append(Left(called, at, on, Activation(caller, pc, frame, base)))

        def enter(number: int, frame: int, base: int) -> None:
            self.entered = Activation(number, 0, frame, base)

        return {**self.names, "leave": leave, "enter": enter, "limit": self.limit}

    def _later(self, number: int, build: Build) -> Function:
        """Return a function that compiles the routine at its first call, and then is no longer called."""
        return lambda pc, n, frame, base: self._load(number, build)(pc, n, frame, base)

    def _load(self, number: int, build: Build) -> Function:
        self.called.add(number)
        scope = self._scopes[build]
        scope |= {**self._texts.tables(number), f"stops_{number}": self.stops[number]}
        code = self._texts.in_advance(number, build) or self._texts.compiled(number, build)
        if build is Build.FAST:
            self.routines[number].fast = code  # another run time of the same program need not compile it again
        function = sandbox.bind(marshal.loads(code), scope)[f"routine_{number}"]
        self._functions[build][number] = function
        return function

    def lines(self, number: int, build: Build) -> list[Line]:
        """Return the Python text of a routine, with the instruction of each line."""
        return self._texts.lines(number, build)

    def source(self, build: Build) -> str:
        return "".join(self._texts.source(number, build) for number in range(len(self.routines)))

    def is_leader(self, routine: int, pc: int, build: Build) -> bool:
        """True if a build can be entered there."""
        return pc == 0 or pc in self._texts.leaders(routine, build)

    def line(self, routine: int, pc: int) -> int:
        """Return the source line of an instruction."""
        return self.routines[routine].lines[pc]

    def begins(self, routine: int, pc: int) -> tuple[int, bool]:
        """Return the source line of an instruction, and whether it is the first one of it."""
        lines = self.routines[routine].lines
        return lines[pc], pc == 0 or lines[pc - 1] != lines[pc]

    def stop_at(self, lines: set[int]) -> set[int]:
        """Replace all breakpoints by these source lines; return those lines that have an instruction to stop at."""
        stops = set()
        for number in range(len(self.routines)):
            stops |= self.stop_in(number, lines)
        return stops

    def stop_in(self, number: int, lines: Collection[int]) -> set[int]:
        """Replace the breakpoints of one routine, as `stop_at` does."""
        reached, before = set(), 0
        stops = self.stops[number]
        for pc, line in enumerate(self.routines[number].lines):
            stops[pc] = int(line in lines and line != before)  # stop once per line
            before = line
            if line in lines:
                reached.add(line)
        return reached
