"""The child processes of a rig, as its supervisor runs them."""

import os
from collections.abc import Sequence
from functools import partial

from fieldrig.config.rig_file import RigConfig
from fieldrig.points.values import counted
from fieldrig.real.child import CAN_FORK, Child, command, not_started
from fieldrig.real.host import run_process, start_log
from fieldrig.real.placement import ProcessPlan
from fieldrig.system.exits import Exit
from fieldrig.system.run_folder import RunFolder


class Children:
    """All children of one supervisor.  Each ends when the pipe that the supervisor keeps open is closed."""

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
        self._pipe, self._own_end = os.pipe()
        self.by_name = {
            name: Child(command(config, plan, overrides, is_realtime), folder.folder / f"log/{name}.log", self._pipe)
            for name, plan in plans.items()
        }

    def fork(self) -> None:
        """Fork all children where the system can.  Call it before the first thread and before there is a loop.

        RigError if the system has no descriptor, process or memory for one.
        """
        if not CAN_FORK:
            return
        count = counted(len(self.by_name), "process", "processes")
        for name, child in self.by_name.items():
            try:
                child.fork(partial(_work, self._config, self._plans[name], self._is_realtime))
            except OSError as cause:
                raise not_started(cause, name, f"the rig takes {count}") from cause

    def close(self) -> None:
        """Kill the children that still run, and release the pipe."""
        os.close(self._own_end)
        for child in self.by_name.values():
            child.forget_steps()
            child.kill()
        os.close(self._pipe)


def _work(config: RigConfig, plan: ProcessPlan, is_realtime: bool) -> Exit:
    start_log()
    return run_process(config, plan, is_supervised=True, is_realtime=is_realtime)
