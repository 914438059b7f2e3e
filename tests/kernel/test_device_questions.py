"""Questions that only one kind of device understands, in one process and in two, and through the control service."""

import asyncio
from pathlib import Path
from typing import Any

import pytest

from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.control.device_questions import answers
from fieldrig.errors import ControlError
from fieldrig.virtual.rig import Rig
from fieldrig.virtual.service import VirtualPoints

HERE = Path(__file__).parent
DICE: dict[str, Any] = {
    "time": "virtual",
    "buses": {"wires": {"kind": "wires.virtual"}},
    "devices": {"dice": {"kind": "rig_kinds:Dice", "links": {"wires": "wires"}}},
}


@pytest.mark.long
@pytest.mark.parametrize("processes", ["one", "each"])
def test_a_device_answers_at_the_present_instant(processes: str) -> None:
    with Rig(from_dict({**DICE, "processes": processes}, HERE)) as rig:
        rig.run_until(25 * MS)
        assert rig.answer("dice", "rethrow", {"times": 4}) == {"throws": 7, "now_ns": 25 * MS}
        assert rig.get("dice", "throws") == 7


@pytest.mark.long
@pytest.mark.parametrize("processes", ["one", "each"])
def test_a_refusal_says_what_was_expected(processes: str) -> None:
    with Rig(from_dict({**DICE, "processes": processes}, HERE)) as rig:
        with pytest.raises(ControlError) as refused:
            rig.answer("dice", "rethrow", {"times": "many"})
        assert (refused.value.what, refused.value.remedy) == ("dice: nothing to throw", "expected a number of times")


def test_the_control_service_passes_on_what_it_does_not_know_itself() -> None:
    with Rig(from_dict(DICE, HERE)) as rig:
        control = answers(VirtualPoints(rig, "dice"))

        async def answer(verb: str, message: Any) -> Any:
            return await control(verb, message)

        assert asyncio.run(answer("rethrow", {"times": 1}))["throws"] == 2
        with pytest.raises(ControlError, match="this device cannot answer dance"):
            asyncio.run(answer("dance", None))
        with pytest.raises(ControlError, match="a device cannot get"):
            asyncio.run(answer("get", 5))
