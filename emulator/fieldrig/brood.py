"""All processes of a rig, as its supervisor holds them."""

import os
import signal
from collections.abc import Sequence
from functools import partial

from fieldrig.child import CAN_FORK, Child, command
from fieldrig.config import RigConfig
from fieldrig.exits import Exit
from fieldrig.host import run_process, start_log
from fieldrig.placement import ProcessPlan
from fieldrig.run_folder import RunFolder


class Brood:
    """Held by a leash: a pipe whose end, when this process is gone, ends them all."""

    def __init__(
        self,
        config: RigConfig,
        plans: dict[str, ProcessPlan],
        folder: RunFolder,
        *,
        overrides: Sequence[str] = (),
        is_realtime: bool = False,
    ) -> None:
        self._config, self._plans, self._is_realtime = config, plans, is_realtime
        self._leash, self._hand = os.pipe()
        self.children = {
            name: Child(command(config, plan, overrides, is_realtime), folder.folder / f"log/{name}.log", self._leash)
            for name, plan in plans.items()
        }

    def fork(self) -> None:
        """Start them all, where that can be done; before the first thread, and before there is a loop."""
        if CAN_FORK:
            for name, child in self.children.items():
                child.fork(partial(_work, self._config, self._plans[name], self._is_realtime))

    def close(self) -> None:
        """End at once what still runs."""
        os.close(self._hand)
        for child in self.children.values():
            child.forget_steps()
            if child.pid is not None:
                child.end(signal.SIGKILL)
                child.reap()
        os.close(self._leash)


def _work(config: RigConfig, plan: ProcessPlan, is_realtime: bool) -> Exit:
    start_log()
    return run_process(config, plan, is_supervised=True, is_realtime=is_realtime)
