"""A branch of a rig: a copy of its process that goes on from the same instant on its own.

A rig in virtual time has one thread and no socket, so a fork of its process (copy on write) is the whole rig.
"""

import os
import pickle
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from importlib import import_module
from multiprocessing import reduction
from types import TracebackType
from typing import TYPE_CHECKING, Any, Concatenate, Final, NamedTuple, ParamSpec, Protocol, Self, TypeVar, overload

from fieldrig.config.rig_file import RigConfig
from fieldrig.coverage import collecting
from fieldrig.device import Value
from fieldrig.errors import ArgumentError, RigError
from fieldrig.outside.untrusted import shown
from fieldrig.points.names import split_point, written_point
from fieldrig.storage.store import MemoryStore, Store
from fieldrig.system.exits import KILL
from fieldrig.system.threads import threads
from fieldrig.virtual.readings import Readings
from fieldrig.virtual.until import run_until_met, run_while_met

if TYPE_CHECKING:
    from multiprocessing.connection import Connection


T = TypeVar("T")
P = ParamSpec("P")

HAS_FORK: Final = hasattr(os, "fork")
ENDING_S: Final = 0.2
"""How long the system may take to end a thread that Python has joined: some microseconds, on a loaded host more."""
GONE: Final = (EOFError, ConnectionResetError, BrokenPipeError)


class Asked(NamedTuple):
    """A call from outside that changed a rig."""

    at_ns: int
    has_run: bool
    """True if the rig ran between the call before and this one."""
    call: str
    arguments: tuple[Any, ...]


class Branchable(Protocol):
    """The rig, as far as a branch needs it."""

    config: RigConfig
    _stores: dict[str, Store]
    _threads: set[int]

    @property
    def now_ns(self) -> int: ...

    @property
    def _is_playing(self) -> bool: ...

    def run_until(self, until_ns: int) -> bool: ...

    def _has_clients(self) -> bool: ...

    def _become_branch(self, seed: int | None) -> None: ...


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
            raise RigError("the process of the branch is gone", how) from cause
        except BaseException:  # such as Ctrl-C: the next answer would be that to another question
            self.close()
            raise
        if outcome == "failed":
            raise answer from (None if isinstance(answer, RigError) else BranchError(text))
        return answer


def check_may_branch(rig: Branchable) -> None:
    """RigError if a fork of this process would not be the whole rig, or would share something with it."""
    if not HAS_FORK:
        raise RigError("this system cannot branch a rig", "branches need fork, which Linux has and Windows has not")
    if rig.config.processes == "each":
        raise RigError(
            "a rig with `processes: each` cannot be branched: the branch would share its devices",
            'load it with the override "processes=one"',
        )
    if rig._is_playing:
        raise RigError("a rig cannot be branched in the middle of an instant", "a call of on_instant can branch it")
    if rig._has_clients():
        raise RigError("a rig with programs at its ports cannot be branched", "branch it before `virtual_time`")
    for name, store in rig._stores.items():
        if not isinstance(store, MemoryStore):
            raise RigError(
                f"a branch would write the memory of {name}, which is a {type(store).__name__}",
                "give the rig a MemoryStore(store.load())",
            )
    _check_threads(rig)


def _check_threads(rig: Branchable) -> None:
    give_up_s = time.monotonic() + ENDING_S
    while (newer := threads() - rig._threads) and not newer & _python_threads() and time.monotonic() < give_up_s:
        time.sleep(0.001)
    if newer:
        names = {thread.native_id: thread.name for thread in threading.enumerate()}
        told = ", ".join(sorted(names.get(number, "one outside Python") for number in newer))
        raise RigError(
            f"a rig cannot be branched while threads run that are younger than it: {told}",
            "a branch has no threads; end them, or start them before the rig is built",
        )


def _python_threads() -> set[int | None]:
    return {thread.native_id for thread in threading.enumerate()}


def branch_of(rig: Branchable, seed: int | None = None, first: Callable[[Any], Any] | None = None) -> Branch:
    """Return a branch of the rig, which has been checked.  It calls `first`, and answers it before any question."""
    ours, theirs = new_pipe()
    with theirs:
        try:
            pid = _start(rig, theirs, seed, first)
        except BaseException:
            ours.close()
            raise
    return Branch(ours, pid, rig.now_ns)


def new_pipe() -> tuple[Any, Any]:
    """Return both ends of a pipe."""
    from multiprocessing import Pipe

    return Pipe()


def _start(
    rig: Branchable, pipe: "Connection[Any, Any]", seed: int | None, first: Callable[[Any], Any] | None = None
) -> int:
    return int(_forked().fork(pipe, partial(_serve, rig, seed, first)))


def _forked() -> Any:
    """Return the module that forks, which Windows cannot import."""
    return import_module("fieldrig.virtual.forked")


def _serve(rig: Branchable, seed: int | None, first: Callable[[Any], Any] | None, pipe: "Connection[Any, Any]") -> None:
    """Answer in the branch until the pipe ends."""
    rig._become_branch(seed)
    with suppress(*GONE):
        if first is not None:
            reply(pipe, partial(first, rig), lambda: rig.now_ns)
        serve(rig, pipe)


def serve(rig: Branchable, pipe: "Connection[Any, Any]") -> None:
    """Answer questions about a rig until the pipe ends."""
    end_if_gone = _forked().end_if_gone
    with suppress(*GONE):
        while True:
            request = pipe.recv_bytes()
            end_if_gone(pipe.fileno())
            reply(pipe, partial(_answer, rig, pipe, request), lambda: rig.now_ns)


def reply(pipe: "Connection[Any, Any]", work: Callable[[], Any], now_ns: Callable[[], int]) -> None:
    """Send what `work()` returns or raises, with the instant of the rig."""
    answer: tuple[Any, ...]
    try:
        answer = ("done", work(), "", now_ns())
    except Exception as fault:  # noqa: BLE001  it is raised where the question came from
        answer = ("failed", *_portable(fault), now_ns())
    sys.stdout.flush()
    collecting.flush()  # before the answer, as a branch is killed when it is not needed any more
    try:
        data = reduction.ForkingPickler.dumps(answer)
    except (pickle.PicklingError, AttributeError, TypeError) as cause:
        wrong = ArgumentError(f"a result cannot leave the branch: {cause}", "expected data, such as numbers and texts")
        data = reduction.ForkingPickler.dumps(("failed", wrong, "", now_ns()))
    pipe.send_bytes(data)


def _answer(rig: Branchable, pipe: "Connection[Any, Any]", request: bytes) -> Any:
    verb, arguments = pickle.loads(request)
    if verb == "call":
        function, values, named = arguments
        return function(rig, *values, **named)
    if verb == "branch":
        return _branch_again(rig, pipe, *arguments)
    if verb == "repeat":
        return repeat(rig, *arguments)
    answer = getattr(rig, verb)(*arguments)
    return dict(answer) if isinstance(answer, Mapping) else answer


def repeat(rig: Branchable, asked: Sequence[Asked], until_ns: int) -> None:
    """Do again what was asked, each at its instant, and run to `until_ns`."""
    for at_ns, has_run, call, arguments in asked:
        if has_run:
            rig.run_until(at_ns)
        repeat_one(rig, call, arguments)
    rig.run_until(until_ns)


def repeat_one(rig: Branchable, call: str, arguments: tuple[Any, ...]) -> None:
    with suppress(RigError):  # it was refused the first time as well
        getattr(rig, call)(*arguments)


def _branch_again(rig: Branchable, pipe: Any, seed: int | None) -> int:
    from multiprocessing.connection import Connection

    if hasattr(signal, "SIGCHLD"):
        # Its branches belong to the process that asks: the system reaps them.
        signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    with Connection(reduction.recv_handle(pipe)) as given:
        check_may_branch(rig)
        return _start(rig, given, seed)


def _portable(fault: Exception) -> tuple[Exception, str]:
    """Return an error that can cross the pipe, and its traceback."""
    text = "".join(traceback.format_exception(fault))
    try:
        again = pickle.loads(pickle.dumps(fault))
    except Exception:  # noqa: BLE001  an error of anybody's own class
        return RigError(f"{type(fault).__name__}: {fault}", text), text
    return (again if type(again) is type(fault) else RigError(str(fault), text)), text


def _how_it_ended(pid: int) -> str:
    """Wait for the end of a process that ends, and return how it was."""
    try:
        _, status = os.waitpid(pid, 0)
    except ChildProcessError:  # in a branch that was branched, where the system reaps them
        return "it has ended"
    code = os.waitstatus_to_exitcode(status)
    return f"killed by {signal.Signals(-code).name}" if code < 0 else f"exit code {code}, its traceback is above"
