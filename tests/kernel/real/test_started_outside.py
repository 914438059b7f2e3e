"""A rig whose processes are started from outside, such as containers: what its tools may ask for."""

import asyncio
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any, cast

import pytest

from fieldrig.config.rig_file import from_dict
from fieldrig.control.messages import Control
from fieldrig.errors import ControlError
from fieldrig.real.placement import placement
from fieldrig.real.started_outside import AttendedRig
from fieldrig.system.exits import Exit

HERE = Path(__file__).parents[1]


class Line:
    """Takes the place of the control messages: it keeps the questions to the processes."""

    def __init__(self) -> None:
        self.answer: Callable[[str, Any], Coroutine[Any, Any, Any]]
        self.asked: list[tuple[str, Any]] = []

    def serve(self, _path: str, answer: Any) -> None:
        self.answer = answer

    def listen_to(self, _path: str, _handler: Any) -> None:
        """Hear nothing."""

    def watch_life(self, _path: str, _handler: Any) -> None:
        """See nothing."""

    def publish(self, _path: str, _message: Any) -> None:
        """Tell no listener."""

    async def ask(self, path: str, message: Any, _timeout_s: float) -> Any:
        self.asked.append((path, message))
        return {}


def test_a_device_is_restarted_where_it_is_and_a_process_only_by_who_started_it() -> None:
    config = from_dict(
        {
            "time": "real",
            "buses": {"w": {"kind": "wires.hub"}},
            "devices": {"one": {"kind": "rig_kinds:Adder", "process": "rack", "links": {"wires": "w"}}},
        },
        HERE,
    )
    line = Line()

    async def work() -> None:
        rig = AttendedRig(config, placement(config), cast(Control, line), lambda _event: None)
        running = asyncio.create_task(rig.run())
        await asyncio.sleep(0)
        assert await line.answer("restart", {"name": "one"}) == {"device": "one"}
        for name in ("rack", "w"):
            with pytest.raises(
                ControlError, match=f"this rig cannot restart {name}\n  expected a device; a process is"
            ):
                await line.answer("restart", {"name": name})
        with pytest.raises(ControlError, match="no process, device or bus 'tow'"):
            await line.answer("restart", {"name": "tow"})
        await line.answer("stop", None)
        assert await running == Exit.OK

    asyncio.run(work())
    assert line.asked == [("process/rack/restart", {"device": "one"})]
