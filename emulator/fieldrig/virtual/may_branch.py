"""The check that a fork of this process would be the whole rig, and share nothing with it."""

import os
import threading
import time
from typing import Final, Protocol

from fieldrig.config.rig_file import RigConfig
from fieldrig.errors import RigError
from fieldrig.storage.store import MemoryStore, Store
from fieldrig.system.threads import threads

HAS_FORK: Final = hasattr(os, "fork")
ENDING_S: Final = 0.2
"""How long the system may take to end a thread that Python has joined: some microseconds, on a loaded host more."""


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
