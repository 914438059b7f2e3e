"""A rig in real time whose processes are started from outside, such as containers: start order and status only."""

import asyncio
from collections.abc import Callable, Mapping
from typing import Any

from fieldrig.config.rig_file import RigConfig
from fieldrig.control.messages import Control
from fieldrig.control.question_words import asked
from fieldrig.errors import ControlError
from fieldrig.real.placement import ProcessPlan
from fieldrig.real.roster import Report, Roster
from fieldrig.system.exits import Exit


class AttendedRig:
    def __init__(self, config: RigConfig, plans: dict[str, ProcessPlan], control: Control, report: Report) -> None:
        self.roster = Roster(config, plans, control, report)
        self._ended: asyncio.Future[Exit] = asyncio.get_running_loop().create_future()

    @property
    def beside(self) -> Callable[[], Mapping[str, Any]]:
        """The function that returns the facts about what runs beside the rig, for `status`."""
        return self.roster.beside

    @beside.setter
    def beside(self, facts: Callable[[], Mapping[str, Any]]) -> None:
        self.roster.beside = facts

    async def run(self) -> Exit:
        self.roster.serve(stop=self._on_stop_asked, restart=self._on_restart_asked)
        self.roster.watch()
        code = await self._ended
        self.roster.stop()
        return code

    def end(self) -> None:
        """End this service only; the processes belong to the user who started them."""
        if not self._ended.done():
            self._ended.set_result(Exit.OK)

    async def _on_stop_asked(self, _message: Any) -> None:
        self.end()

    async def _on_restart_asked(self, message: Any) -> dict[str, str]:
        """Switch a device off and on; a process belongs to who started it."""
        match message:
            case {"name": str(name)} if name in self.roster.member_of(name).plan.devices:
                await self.roster.power_cycle(name)
                return {"device": name}
        raise ControlError(
            f"this rig cannot {asked('restart', message)}",
            "expected a device; a process is started again where it was started, such as by docker compose restart",
        )
