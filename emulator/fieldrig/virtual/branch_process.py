"""The process of a branch: it answers the questions of `branch.Branch`, which come through a pipe."""

import pickle
import signal
import sys
import traceback
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from importlib import import_module
from multiprocessing import reduction
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from fieldrig.coverage import collecting
from fieldrig.errors import ArgumentError, RigError
from fieldrig.virtual.may_branch import Branchable, check_may_branch

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

GONE: Final = (EOFError, ConnectionResetError, BrokenPipeError)
"""The errors of a pipe whose other end is gone."""


class Asked(NamedTuple):
    """A call from outside that changed a rig."""

    at_ns: int
    has_run: bool
    """True if the rig ran between the call before and this one."""
    call: str
    arguments: tuple[Any, ...]


def start(
    rig: Branchable, pipe: "Connection[Any, Any]", seed: int | None, first: Callable[[Any], Any] | None = None
) -> int:
    """Start a branch of a rig that may branch, and return its process id.

    It calls `first`, answers that, and then answers questions.
    """
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
        return start(rig, given, seed)


def _portable(fault: Exception) -> tuple[Exception, str]:
    """Return an error that can cross the pipe, and its traceback."""
    text = "".join(traceback.format_exception(fault))
    try:
        again = pickle.loads(pickle.dumps(fault))
    except Exception:  # noqa: BLE001  an error of anybody's own class
        return RigError(f"{type(fault).__name__}: {fault}", text), text
    return (again if type(again) is type(fault) else RigError(str(fault), text)), text
