"""A fault of a bus without a model that one end refuses: no end keeps it, for a command and for the page."""

from typing import Any

import pytest
from in_loop import in_loop

from fieldrig.control.fault_asking import about_faults, ask
from fieldrig.control.messages import NoAnswerError
from fieldrig.errors import ControlError
from fieldrig_page.faults import Faults

STATUS = {
    "rig": "r", "processes": {}, "buses": {"air": {"kind": "wires.zenoh"}}, "devices": {"a": {}, "b": {}},
}  # fmt: skip
NOT_HERE = "1000 faults wait for points of b"


class Ends:
    """A rig whose bus `air` has an end at `a`, which takes the fault, and one at `b`, which has too many."""

    def __init__(self) -> None:
        self.cleared: list[str] = []

    def ask(self, path: str, _message: Any = None) -> Any:
        match path.split("/"):
            case ["rig", "status"]:
                return STATUS
            case ["device", "b", "get"]:
                return {"x": 0}
            case ["device", "b", "keys"]:
                return {"x": {"unit": ""}}
            case ["end", "air", "a", "add_fault"]:
                return {"number": 1}
            case ["end", "air", "b", "add_fault"]:
                raise ControlError(NOT_HERE)
            case ["end", "air", device, "clear_fault"]:
                self.cleared.append(device)
                return {"cleared": [1]}
        raise NoAnswerError("none")

    def ask_all(self, path: str, _message: Any = None) -> dict[str, Any]:
        return {"a": 0, "b": 0} if path.endswith("/given") else {"a": {}, "b": {}}


class LaterEnds(Ends):
    """The same by an event loop."""

    async def ask(self, path: str, _message: Any = None) -> Any:
        return super().ask(path)

    async def ask_all(self, path: str, _message: Any = None) -> dict[str, Any]:  # type: ignore[override]
        return super().ask_all(path)


FAULT = {"what": "drop_out", "when": "b/x > 1"}


def test_a_command_takes_a_fault_back() -> None:
    ends: Any = Ends()
    with pytest.raises(ControlError, match=NOT_HERE):
        ask(ends, about_faults("air", "add_fault", {"fault": FAULT}))
    assert ends.cleared == ["a"]


@in_loop
async def test_the_page_takes_a_fault_back() -> None:
    ends: Any = LaterEnds()
    with pytest.raises(ControlError, match=NOT_HERE):
        await Faults(ends).add("air", FAULT)
    assert ends.cleared == ["a"]
