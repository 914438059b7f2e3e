"""The stations of a ring in a rig file: the same rules for all kinds."""

import re
from pathlib import Path
from typing import Any

import pytest

from fieldrig.config.rig_file import from_dict
from fieldrig.errors import ConfigError
from fieldrig_bus.ring.transport.shm_carrier import is_available

KINDS = {
    "ring.virtual": "virtual",
    "ring.zenoh": "real",
    **({"ring.shm": "real"} if is_available() else {}),
}
DRIVES = ("belt", "lift", "knife")


def rig(kind: str, **settings: Any) -> dict[str, Any]:
    """A controller, three drives, and a drive that is on another ring."""
    links = {"max4": "ring0", **dict.fromkeys(DRIVES, "ring0"), "crane": "ring1"}
    devices: dict[str, dict[str, Any]] = {
        name: {"kind": "max4" if name == "max4" else "mc4", "links": {"ring": ring}} for name, ring in links.items()
    }
    for number, name in enumerate((*DRIVES, "crane"), 1):
        devices[name] |= {"ring_address": number}
    devices["max4"] |= {"drives": {name: {"ring_address": number} for number, name in enumerate(DRIVES, 1)}}
    return {
        "time": KINDS[kind],
        "buses": {"ring0": {"kind": kind, **settings}, "ring1": {"kind": kind}},
        "devices": devices,
    }


def refused(kind: str, **settings: Any) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        from_dict(rig(kind, **settings), Path())
    return [f"{mistake.key}: {mistake.what}; {mistake.remedy}" for mistake in caught.value.mistakes]


@pytest.fixture(params=KINDS)
def kind(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def test_what_names_linked_devices_is_right(kind: str) -> None:
    settings = {
        "order": ["knife", "belt"],  # the lift follows
        "bypassed": ["lift"],
        "faults": [
            {"what": "break", "after": "master"},
            {"what": "break", "after": "max4"},
            {"what": "distort", "after": "belt"},
            {"what": "off", "station": "lift"},
        ],
    }
    assert from_dict(rig(kind, **settings), Path()).buses["ring0"].members.keys() == {"max4", *DRIVES}


def test_a_station_of_the_order_that_is_no_device_is_refused(kind: str) -> None:
    (mistake,) = refused(kind, order=["belt", "lfit", "knife"])
    assert mistake == 'buses.ring0.order[1]: this ring has no station "lfit"; did you mean lift?'


def test_a_device_of_another_ring_is_no_station(kind: str) -> None:
    assert refused(kind, order=["crane"], bypassed=["crane"]) == [
        'buses.ring0.order[0]: this ring has no station "crane"; there are: belt, lift, knife',
        'buses.ring0.bypassed[0]: this ring has no station "crane"; there are: belt, lift, knife',
    ]


def test_a_station_has_one_place_in_the_order(kind: str) -> None:
    (mistake,) = refused(kind, order=["belt", "lift", "belt"])
    assert mistake == "buses.ring0.order[2]: belt is in the order already; a station has one place in the ring"


@pytest.mark.parametrize(
    ("fault", "wrong"),
    [
        ({"what": "break", "after": "lfit"}, "after.*did you mean lift"),
        ({"what": "distort", "after": "mster"}, "after.*did you mean master"),
        ({"what": "distort", "station": "crane"}, "station.*there are: belt"),
        ({"what": "off", "station": "knive"}, "station.*did you mean knife"),
        ({"what": "late", "station": "master"}, "station.*there are: belt"),
    ],
)
def test_a_fault_where_no_station_is_is_refused(kind: str, fault: dict[str, str], wrong: str) -> None:
    (mistake,) = refused(kind, faults=[{"what": "break", "after": "belt"}, fault])
    assert re.match(rf"buses\.ring0\.faults\[1\]\.{wrong}", mistake)


def test_the_master_is_no_station(kind: str) -> None:
    keys = [
        mistake.partition(":")[0]
        for mistake in refused(
            kind, order=["max4", "belt"], bypassed=["max4"], faults=[{"what": "off", "station": "max4"}]
        )
    ]
    assert keys == ["buses.ring0.order[0]", "buses.ring0.bypassed[0]", "buses.ring0.faults[0].station"]


def test_two_drives_of_one_ring_cannot_have_one_address(kind: str) -> None:
    data = rig(kind)
    data["devices"]["lift"]["ring_address"] = data["devices"]["crane"]["ring_address"] = 1
    with pytest.raises(ConfigError) as caught:
        from_dict(data, Path())
    (mistake,) = caught.value.mistakes
    assert mistake.key == "devices.lift.ring_address"
    assert mistake.what == "ring address 1 on ring0 is taken by devices.belt.ring_address"
