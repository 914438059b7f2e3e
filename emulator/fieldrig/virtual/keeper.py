"""A rig in a process of its own: the keeper, a fork of this process before anything here has threads or sockets.

It serves a pipe, as a branch does, and a fork of it is the whole rig: so a rig that is served can be branched as well.
"""

import os
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Any

from fieldrig.config.rig_file import RigConfig
from fieldrig.virtual.branch import Branch, new_pipe
from fieldrig.virtual.branch_process import reply, serve
from fieldrig.virtual.may_branch import HAS_FORK
from fieldrig.virtual.served import Begun, News, Played, Recorded, ServedRig

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

NO_KEEPER = "a rig that is served from the process of its devices cannot go back in time"
NO_FORK = "this system cannot go back in time: that needs fork, which Linux has and Windows has not"
EACH = "a rig with `processes: each` cannot go back: its branches would share their devices"


class KeptRig(Branch):
    """The rig in its keeper, or a branch of it."""

    def play(self, until_ns: int | None, for_s: float) -> Played:
        """Run a slice, as `ServedRig.play` does."""
        played: Played = self._ask("play", until_ns, for_s)
        return played

    def news(self) -> News:
        news: News = self._ask("news")
        return news

    def hear(self, buses: Any) -> None:
        self._ask("hear", list(buses))

    def begin_recording(self, name: str, signals: Any, rhythm: Any) -> Begun:
        begun: Begun = self._ask("begin_recording", name, list(signals), rhythm)
        return begun

    def of_recording(self, name: str, call: str, *arguments: Any) -> Recorded:
        recorded: Recorded = self._ask("of_recording", name, call, *arguments)
        return recorded

    def forget_recording(self, name: str) -> None:
        self._ask("forget_recording", name)

    def process_facts(self, *, is_brief: bool) -> dict[str, float | None]:
        return dict(self.call(ServedRig.process_facts, is_brief=is_brief))

    def wait_until_built(self) -> None:
        """Wait for the rig.  RigError if a device cannot be built."""
        self._received()

    def block(self) -> None:
        """Wait for answers, also after an event loop has looked at the descriptor."""
        if hasattr(os, "set_blocking"):
            os.set_blocking(self.fileno(), True)


def why_no_way_back(config: RigConfig) -> str:
    """Return why a rig that is served cannot go back in time; empty if it can."""
    if not HAS_FORK:
        return NO_FORK
    return EACH if config.processes == "each" else ""


def keep(config: RigConfig) -> KeptRig:
    """Start a keeper, which begins to build the rig.  Call it before the first thread and before there is a loop."""
    ours, theirs = new_pipe()
    with theirs:
        try:
            pid = import_module("fieldrig.virtual.forked").fork(theirs, partial(_keep, config))
        except BaseException:
            ours.close()
            raise
    return KeptRig(ours, pid, 0)


def _keep(config: RigConfig, pipe: "Connection[Any, Any]") -> None:
    built: list[ServedRig] = []
    reply(pipe, lambda: built.append(ServedRig(config)), lambda: 0)
    for rig in built:
        rig.outlive_signals()
        serve(rig, pipe)
