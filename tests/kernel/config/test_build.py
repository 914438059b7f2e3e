import sys
from pathlib import Path
from random import Random
from typing import Any

import pytest

from fieldrig.clock import VirtualClock
from fieldrig.config.build import build_device, random_of, try_devices
from fieldrig.config.rig_file import RigConfig, from_dict
from fieldrig.device import Device
from fieldrig.errors import ConfigError, Mistake
from fieldrig.storage.store import MemoryStore
from fieldrig.testing import RecordedLink

HERE = Path(__file__).parents[1]
CLOCK, STORE = VirtualClock(), MemoryStore()
CAN, WORDS = RecordedLink[Any](), RecordedLink[Any]()


@pytest.fixture(autouse=True)
def _path_stays_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [str(HERE), *sys.path])


def rig_of(folder: Path = HERE, **device: Any) -> RigConfig:
    buses = {"can0": {"kind": "config_kinds:CanLine"}, "words": {"kind": "config_kinds:WordLine"}}
    return from_dict({"time": "virtual", "buses": buses, "devices": {"io": device}}, folder)


def built(config: RigConfig, **links: Any) -> Any:
    return build_device(config.devices["io"], clock=CLOCK, links=links, store=STORE, random=random_of("io", 7))


def node(**keys: Any) -> dict[str, Any]:
    return {"kind": "config_kinds:Node", "node_id": 5, "links": {"can": "can0"}, **keys}


def test_a_device_gets_what_its_constructor_names() -> None:
    config = rig_of(**node(links={"can": "can0", "words": ["words"]}))
    clock, name, settings, store, random, can, words = built(config, can=CAN, words=[WORDS]).got
    assert (clock, name, settings, store) == (CLOCK, "io", config.devices["io"].settings, STORE)
    assert (can, words) == (CAN, [WORDS])
    assert random.random() == Random("7/io").random()


def test_a_link_that_is_left_out_is_none() -> None:
    assert built(rig_of(**node()), can=CAN).got[-2:] == (CAN, None)
    reader = rig_of(kind="config_kinds:Reader", links={"words": "words"})
    assert built(reader, words=WORDS).got == (WORDS, None)


def test_a_device_without_a_constructor_gets_nothing() -> None:
    assert isinstance(built(rig_of(kind="config_kinds:Idle")), Device)


def test_a_device_that_refuses_its_files_is_named(tmp_path: Path) -> None:
    (tmp_path / "io.eds").write_text("broken")
    config = rig_of(tmp_path, **node(file="io.eds"))
    with pytest.raises(ConfigError) as caught:
        built(config, can=CAN)
    assert caught.value.mistakes == [Mistake("", None, "devices.io", "line 1 is not an object")]


def test_every_device_can_be_tried_before_the_rig_starts(tmp_path: Path) -> None:
    assert try_devices(rig_of(**node(links={"can": "can0", "words": ["words"]})).devices.values()) == []
    (tmp_path / "io.eds").write_text("broken")
    assert [str(mistake) for mistake in try_devices(rig_of(tmp_path, **node(file="io.eds")).devices.values())] == [
        "devices.io: line 1 is not an object"
    ]
