"""A branch of a rig: a copy of its process that goes on from the same instant on its own.

A rig in virtual time has one thread and no socket, so a fork of its process (copy on write) is the whole rig.
"""

import os
import pickle
import signal
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from multiprocessing import reduction
from types import TracebackType
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, Protocol, Self, TypeVar, overload

from fieldrig.device import Value
from fieldrig.errors import ArgumentError, GoneError, RigError
from fieldrig.outside.untrusted import shown
from fieldrig.points.names import split_point, written_point
from fieldrig.system.exits import KILL
from fieldrig.virtual.branch_process import GONE, Asked, start
from fieldrig.virtual.may_branch import Branchable
from fieldrig.virtual.readings import Readings
from fieldrig.virtual.until import run_until_met, run_while_met

if TYPE_CHECKING:
    from multiprocessing.connection import Connection


T = TypeVar("T")
P = ParamSpec("P")


class Parking(Protocol):
    """A rig or a branch of which checkpoints are taken."""

    @property
    def now_ns(self) -> int: ...

    def _parked(self) -> "Branch": ...


class BranchError(Exception):
    """The traceback of an error in a branch, as the cause of the error that is raised in this process."""

    def __str__(self) -> str:
        return f"in the branch:\n{self.args[0]}"


class Branch:
    """A copy of a rig that goes on from the same instant in a process of its own; a `with` statement ends it.

    It has the calls of a `Rig` that can cross a pipe.  The rig itself stays as it is.
    """

    def __init__(self, pipe: "Connection[Any, Any]", pid: int, now_ns: int, is_child: bool = True) -> None:
        self._pipe, self.pid, self.now_ns, self._is_child = pipe, pid, now_ns, is_child
        self._owner = os.getpid()
        self.is_closed = False
        self._readings: Readings | None = None

    def next_ns(self) -> int | None:
        """Return the instant at which something happens next; None if nothing ever will."""
        next_ns: int | None = self._ask("next_ns")
        return next_ns

    def step(self) -> bool:
        """Go to the next instant at which something happens, and let it happen.  False if nothing ever will."""
        return bool(self._ask("step"))

    def run_until(self, until_ns: int) -> None:
        """Let everything happen up to and including `until_ns`."""
        self._ask("run_until", until_ns)

    def run_for(self, duration_ns: int) -> None:
        """Let everything happen that happens in the next `duration_ns`, such as `10 * MS`."""
        self._ask("run_for", duration_ns)

    def until(self, condition: Callable[[], T], within: int) -> T:
        """Run until `condition()` is true, as `Rig.until` does.  It is called here, and reads the branch."""
        return run_until_met(self, condition, within, lambda readings: self._looked_at(condition, readings))

    def stays(self, condition: Callable[[], object], during: int, until: Callable[[], object] | None = None) -> None:
        """Run while `condition()` is true, as `Rig.stays` does.  Both functions are called here."""
        run_while_met(self, condition, during, self._looked_at, until)

    def never(self, condition: Callable[[], object], during: int) -> None:
        """Run for `during` without `condition()`, as `Rig.never` does.  It is called here."""
        run_while_met(self, condition, during, self._looked_at, is_wanted=False)

    def keys(self, device: str) -> dict[str, str]:
        """Return the keys of a device's points, each with its unit."""
        return dict(self._ask("keys", device))

    def facts(self, device: str) -> dict[str, dict[str, Any]]:
        """Return unit, description and other facts of each point of a device, by key."""
        return dict(self._ask("facts", device))

    def values(self, device: str, keys: Iterable[str] | None = None) -> dict[str, Value]:
        """Return the values of these points of a device at the present instant; None stands for all of them."""
        return dict(self._ask("values", device, None if keys is None else list(keys)))

    def front(self, device: str) -> dict[str, Any]:
        """Return what a person sees and operates in front of a device."""
        return dict(self._ask("front", device))

    def get(self, point: str, key: str | None = None) -> Value:
        """Return the value of a point at the present instant: `get("tank/level")`, or `get("tank", "level")`."""
        device, key = split_point(point, key)
        value: Value = self._ask("get", device, key)
        if self._readings is not None:
            self._readings.note(device, key, self.now_ns, value)
        return value

    @overload
    def set(self, point: str, value: Value, /) -> None: ...

    @overload
    def set(self, device: str, key: str, value: Value, /) -> None: ...

    def set(self, point: str, *key_and_value: Value) -> None:
        """Write a point at the present instant: `set("tank/level", 1.25)`, or `set("tank", "level", 1.25)`."""
        self._ask("set", *written_point(point, *key_and_value))

    def answer(self, device: str, question: str, message: Any) -> Any:
        """Return the answer of a device to a question of its kind.  ControlError if the device refuses."""
        return self._ask("answer", device, question, message)

    def statistics(self, bus: str) -> dict[str, float]:
        """Return frames, load and other figures of a bus, by name."""
        return dict(self._ask("statistics", bus))

    def signals(self, bus: str) -> dict[str, dict[str, Any]]:
        """Return the facts of each signal of a bus that has a value, such as a wire, by its name."""
        return dict(self._ask("signals", bus))

    def conditions(self, bus: str) -> Mapping[str, str]:
        """Return the states of a bus that are reported to a person, by a name of their own."""
        return dict(self._ask("conditions", bus))

    def add_fault(self, where: str, fault: Mapping[str, Any]) -> int:
        """Add a fault of a bus or a device from now on, and return its number."""
        return int(self._ask("add_fault", where, fault))

    def clear_fault(self, where: str, number: int) -> None:
        """Remove a fault of a bus or a device."""
        self._ask("clear_fault", where, number)

    def faults(self, where: str) -> Mapping[int, Mapping[str, Any]]:
        """Return the faults of a bus or a device that were added and not cleared, by number."""
        return dict(self._ask("faults", where))

    def restart(self, device: str) -> None:
        """Switch a device off and on again at the present instant."""
        self._ask("restart", device)

    def trace_hash(self) -> str:
        """Return the hash of `Rig.trace_hash`, which goes on in the branch."""
        return str(self._ask("trace_hash"))

    def call(self, function: Callable[Concatenate[Any, P], T], *arguments: P.args, **named: P.kwargs) -> T:
        """Return what `function(rig, ...)` returns in the branch, where `rig` is its `Rig` with all calls.

        Function, arguments and result cross a pipe, so the function is one of a module, no lambda.
        """
        if not callable(function):
            raise ArgumentError(f"call cannot take {shown(function)}", "expected a function that takes a rig")
        result: T = self._ask("call", function, arguments, named)
        return result

    def start(self, function: Callable[Concatenate[Any, P], Any], *arguments: P.args, **named: P.kwargs) -> None:
        """Begin `call`, and return at once; `result` waits for its end, and nothing else can be asked before that."""
        if not callable(function):
            raise ArgumentError(f"start cannot take {shown(function)}", "expected a function that takes a rig")
        self._send("call", (function, arguments, named))

    def result(self) -> Any:
        """Return the result of the call that `start` has begun."""
        return self._received()

    def fileno(self) -> int:
        """Return the file descriptor that can be read when a call that was started has ended, for `select`."""
        return self._pipe.fileno()

    def branch(self, seed: int | None = None) -> Self:
        """Return a branch of this branch; without `seed` its random numbers go on as in this one."""
        ours, theirs = new_pipe()
        with theirs:
            try:
                pid = self._ask("branch", seed, given=theirs)
            except BaseException:
                ours.close()
                raise
        return type(self)(ours, pid, self.now_ns, is_child=False)

    def _parked(self) -> Self:
        """Return a branch for a checkpoint."""
        return self.branch()

    def _repeat(self, asked: Sequence[Asked], until_ns: int) -> None:
        """Repeat what was asked of the rig after this checkpoint, and run to an instant."""
        self._ask("repeat", list(asked), until_ns)

    def close(self) -> None:
        """End the process, whatever it does.  Closing twice does no harm."""
        if self.is_closed:
            return
        self.is_closed = True
        self._pipe.close()  # it ends by itself then, also in the middle of its work
        if self._is_child and self._owner == os.getpid():  # in a branch of its rig it is not
            with suppress(ProcessLookupError):
                os.kill(self.pid, KILL)
            _how_it_ended(self.pid)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None, tb: TracebackType | None) -> None:
        self.close()

    def _looked_at(self, condition: Callable[[], T], readings: Readings) -> T:
        self._readings = readings
        try:
            return condition()
        finally:
            self._readings = None

    def _ask(self, verb: str, *arguments: Any, given: "Connection[Any, Any] | None" = None) -> Any:
        self._send(verb, arguments, given)
        return self._received()

    def _send(self, verb: str, arguments: tuple[Any, ...], given: "Connection[Any, Any] | None" = None) -> None:
        if self.is_closed:
            raise RigError("the branch is closed", "use it inside its `with` statement, or branch the rig again")
        try:
            request = reduction.ForkingPickler.dumps((verb, arguments))
        except (pickle.PicklingError, AttributeError, TypeError) as cause:
            raise ArgumentError(
                f"{verb} cannot send {shown(arguments)} to a branch",
                f"expected functions of a module and data: {cause}",
            ) from None
        pipe: Any = self._pipe
        try:
            pipe.send_bytes(request)
            if given is not None:
                reduction.send_handle(pipe, given.fileno(), self.pid)
        except GONE:
            pass  # what follows tells how it ended

    def _received(self) -> Any:
        """Return the next answer, or raise the next error, of the branch."""
        try:
            outcome, answer, text, self.now_ns = self._pipe.recv()
        except GONE as cause:
            self.is_closed = True
            self._pipe.close()
            how = _how_it_ended(self.pid) if self._is_child else "it has ended"
            raise GoneError("the process of the branch is gone", how) from cause
        except BaseException:  # such as Ctrl-C: the next answer would be that to another question
            self.close()
            raise
        if outcome == "failed":
            raise answer from (None if isinstance(answer, RigError) else BranchError(text))
        return answer


def branch_of(rig: Branchable, seed: int | None = None, first: Callable[[Any], Any] | None = None) -> Branch:
    """Return a branch of the rig, which has been checked.  It calls `first`, and answers it before any question."""
    ours, theirs = new_pipe()
    with theirs:
        try:
            pid = start(rig, theirs, seed, first)
        except BaseException:
            ours.close()
            raise
    return Branch(ours, pid, rig.now_ns)


def new_pipe() -> tuple[Any, Any]:
    """Return both ends of a pipe."""
    from multiprocessing import Pipe

    return Pipe()


def _how_it_ended(pid: int) -> str:
    """Wait for the end of a process that ends, and return how it was."""
    try:
        _, status = os.waitpid(pid, 0)
    except ChildProcessError:  # in a branch that was branched, where the system reaps them
        return "it has ended"
    code = os.waitstatus_to_exitcode(status)
    return f"killed by {signal.Signals(-code).name}" if code < 0 else f"exit code {code}, its traceback is above"
