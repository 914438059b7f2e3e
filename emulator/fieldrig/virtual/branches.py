"""A scenario in many branches of a rig, each with its own seed."""

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Any, Protocol, TypeVar

from fieldrig.config.rig_file import RigConfig
from fieldrig.device import Value
from fieldrig.errors import ArgumentError, RigError
from fieldrig.outside.untrusted import shown
from fieldrig.virtual.branch import Branch, branch_of
from fieldrig.virtual.may_branch import Branchable, check_may_branch

T = TypeVar("T")


class Readable(Protocol):
    config: RigConfig

    def values(self, device: str) -> dict[str, Value]: ...


def run_branches(rig: Branchable, scenario: Callable[[Any, int], T], seeds: Iterable[int], workers: int) -> list[T]:
    """Return what `scenario(rig, seed)` returns in a branch for each seed, `workers` of them at a time.

    RigError with the seeds for which it failed, when all have ended.
    """
    if not callable(scenario):
        raise ArgumentError(
            f"branches cannot call {shown(scenario)}", "expected a function that takes a rig and a seed"
        )
    if type(workers) is not int or workers < 1:
        raise ArgumentError(f"branches cannot have {shown(workers)} workers", "expected at least 1")
    order = _whole(seeds)
    check_may_branch(rig)
    done: dict[int, T] = {}
    failed: dict[int, Exception] = {}
    running: dict[Any, tuple[int, Branch]] = {}
    waiting = list(enumerate(order))[::-1]
    try:
        while waiting or running:
            while waiting and len(running) < workers:
                place, seed = waiting.pop()
                branch = branch_of(rig, seed, partial(_played, scenario, seed))
                running[branch._pipe] = place, branch
            _take(running, done, failed)
    finally:
        for _, branch in running.values():
            branch.close()
    if failed:
        raise _told({order[place]: failed[place] for place in sorted(failed)})
    return [done[place] for place in sorted(done)]


def warm(rig: Readable) -> None:
    """Have a rig make what it keeps from the first question on, so that not each of its branches makes it.

    A device makes its points when they are first read; a CANopen node has thousands.
    """
    for device in rig.config.devices:
        rig.values(device)


def outliving(rig: Branchable) -> Branch:
    """Return a branch that does not end with its rig; the caller closes it.  RigError as of `Rig.branch`."""
    check_may_branch(rig)
    return branch_of(rig)


def one_by_one(rig: Branchable, work: Iterable[Callable[[Any], T]]) -> Iterator[T | RigError]:
    """Yield what each call returns in a branch of its own, in order; a RigError that it raises is yielded as well.

    The next branch begins while the system ends the last one, which takes as long as a short test.
    """
    check_may_branch(rig)
    last: Branch | None = None
    present: Branch | None = None
    try:
        for call in work:
            last, present = present, branch_of(rig, None, call)
            if last is not None:
                last.close()
            yield _result_of(present)
    finally:
        for branch in (last, present):
            if branch is not None:
                branch.close()


def _result_of(branch: Branch) -> Any:
    try:
        return branch._received()
    except RigError as wrong:
        return wrong


def _played(scenario: Callable[[Any, int], T], seed: int, rig: Branchable) -> T:
    return scenario(rig, seed)


def _take(running: dict[Any, tuple[int, Branch]], done: dict[int, T], failed: dict[int, Exception]) -> None:
    """Wait until a branch has ended, and take its result."""
    from multiprocessing.connection import wait

    for pipe in wait(list(running)):
        place, branch = running.pop(pipe)
        with branch:
            try:
                done[place] = branch._received()
            except Exception as fault:  # noqa: BLE001  its seed comes with it
                failed[place] = fault


def _told(failed: dict[int, Exception]) -> RigError:
    first, *_ = failed.values()
    seeds = ", ".join(map(str, failed))
    wrong = RigError(f"the scenario failed with the seed{'s' if len(failed) > 1 else ''} {seeds}", str(first))
    wrong.__cause__ = first
    return wrong


def _whole(seeds: Iterable[int]) -> list[int]:
    try:
        order = list(seeds)
    except TypeError:
        raise ArgumentError(f"seeds cannot be {shown(seeds)}", "expected whole numbers, such as range(100)") from None
    for seed in order:
        check_seed(seed)
    return order


def check_seed(seed: object) -> None:
    """ArgumentError for what is no whole number."""
    if type(seed) is not int:
        raise ArgumentError(f"a seed cannot be {shown(seed)}", "expected a whole number")
