"""Which process runs what, and what waits for what."""

from pathlib import Path
from typing import Any

import pytest

from fieldrig.config.rig_file import from_dict
from fieldrig.errors import RigError
from fieldrig.real.placement import ProcessPlan, placement
from fieldrig_bus.wires import WiresHub, WiresHubSettings

HERE = Path(__file__).parents[1]


class Alone(WiresHub):
    own_process = True

    def __init__(self, name: str, settings: WiresHubSettings) -> None:
        super().__init__(name, settings)


def placed(devices: dict[str, dict[str, Any]], **bus: Any) -> dict[str, ProcessPlan]:
    return placement(
        from_dict(
            {
                "time": "real",
                "buses": {"w": {"kind": "wires.hub", **bus}},
                "devices": {
                    name: {"kind": "rig_kinds:Adder", "links": {"wires": "w"}, **entry}
                    for name, entry in devices.items()
                },
            },
            HERE,
        )
    )


def test_every_device_has_a_process_and_so_has_a_bus_that_several_share() -> None:
    assert placed({"one": {}, "two": {}}) == {
        "w": ProcessPlan("w", buses=("w",), devices=(), attaches=(), after=(), on_exit="restart"),
        "one": ProcessPlan("one", buses=(), devices=("one",), attaches=("w",), after=(), on_exit="restart"),
        "two": ProcessPlan("two", buses=(), devices=("two",), attaches=("w",), after=(), on_exit="restart"),
    }


def test_a_bus_lives_with_its_devices_if_they_share_a_process() -> None:
    rack = {"process": "rack"}
    assert placed({"one": rack, "two": rack}) == {
        "rack": ProcessPlan("rack", ("w",), ("one", "two"), attaches=(), after=(), on_exit="restart")
    }
    assert list(placed({"one": {}})) == ["one"]


def test_a_kind_of_bus_may_insist_on_a_process_of_its_own() -> None:
    plans = placed({"one": {}}, kind=f"{__name__}:Alone")
    assert plans["w"].buses == ("w",)
    assert plans["one"].attaches == ("w",)


def test_an_entry_says_where_its_bus_runs() -> None:
    plans = placed({"one": {}, "two": {}}, process="two")
    assert plans["two"].buses == ("w",)
    assert plans["one"].attaches == ("two",)
    assert plans["two"].attaches == ()


def test_devices_start_after_those_they_name() -> None:
    plans = placed({"one": {"after": "two"}, "two": {}})
    assert list(plans) == ["w", "two", "one"]
    assert plans["one"].after == ("two",)


def test_a_process_keeps_to_the_order_of_its_devices() -> None:
    rack = {"process": "rack"}
    assert placed({"one": {**rack, "after": "two"}, "two": rack})["rack"].devices == ("two", "one")


def test_processes_that_would_wait_for_each_other_are_refused() -> None:
    rack = {"process": "rack"}
    with pytest.raises(RigError, match="wait for each other: rack, two"):
        placed({"one": rack, "two": {"after": "one"}, "three": {**rack, "after": "two"}})


@pytest.mark.parametrize(
    ("first", "second", "together"),
    [("restart", "stop", "stop"), ("ignore", "restart", "restart"), ("ignore", "ignore", "ignore")],
)
def test_the_strictest_setting_of_a_process_counts(first: str, second: str, together: str) -> None:
    devices = {"one": {"process": "rack", "on_exit": first}, "two": {"process": "rack", "on_exit": second}}
    assert placed(devices)["rack"].on_exit == together
