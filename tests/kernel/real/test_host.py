"""A process that asks to join its rig."""

import asyncio
from typing import Any, cast

import pytest

from fieldrig.config.rig_file import from_dict
from fieldrig.control.messages import Control, NoAnswerError
from fieldrig.real.host import Host
from fieldrig.real.placement import ProcessPlan


class EmptyRig:
    """A control service that there is no answer in; like Zenoh it takes no time that is negative."""

    def __init__(self) -> None:
        self.asked = 0

    async def ask(self, _path: str, _message: Any, timeout_s: float) -> Any:
        if timeout_s < 0:
            raise ValueError("negative timeout")
        self.asked += 1
        raise NoAnswerError("there is no answer", "")


@pytest.mark.parametrize("patience_s", [0.0, -5.0])
def test_process_that_slept_past_its_patience_asks_once_and_reports_that_no_rig_answers(patience_s: float) -> None:
    async def join() -> int:
        rig = EmptyRig()
        host = Host(from_dict({"time": "real"}), ProcessPlan("io", (), (), (), (), "restart"), patience_s)
        with pytest.raises(NoAnswerError):
            await host._join(cast(Control, rig))
        return rig.asked

    assert asyncio.run(join()) == 1
