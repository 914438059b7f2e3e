"""Addresses of buses on the command line."""

from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.errors import RigError
from fieldrig_bus.can.hub import CanHubSettings
from fieldrig_bus.can.python_can import PythonCan
from fieldrig_bus.can.socketcan import CanSocketcanSettings
from fieldrig_bus.can.udp import CanUdpSettings
from fieldrig_devices.conformance.address import parse


def test_socketcan() -> None:
    assert parse("can.socketcan:vcan0").bus.settings == CanSocketcanSettings(channel="vcan0")


def test_udp_with_and_without_its_group() -> None:
    assert parse("can.udp:239.1.2.3:4000").bus.settings == CanUdpSettings(group="239.1.2.3", port=4000)
    assert parse("can.udp").bus.settings == CanUdpSettings()


def test_hub_by_run_folder_and_by_address() -> None:
    local, remote = parse("can.hub:run/lab/can0"), parse("can.hub:tcp://10.0.0.7:4000/can1")
    assert (local.bus.name, local.run) == ("can0", Path("run/lab"))
    assert (remote.bus.name, remote.bus.settings) == ("can1", CanHubSettings(connect="10.0.0.7:4000"))


def test_python_can_with_its_keys() -> None:
    bus = parse("python-can:interface=socketcand,channel=can0,host=127.0.0.1,port=29536").bus
    assert isinstance(bus, PythonCan)
    assert bus.python_can() == {"interface": "socketcand", "channel": "can0", "host": "127.0.0.1", "port": 29536}


@pytest.mark.parametrize(
    "text", ["vcan0", "can.socketcan:", "can.socketcan:a b", "can.udp:1.2.3.4", "can.udp:239.1.2.3:x", "python-can:x"]
)
def test_anything_else_is_refused_with_the_expected_forms(text: str) -> None:
    with pytest.raises(RigError) as caught:
        parse(text)
    assert "can.socketcan:vcan0" in caught.value.remedy


@settings(max_examples=200, deadline=None)
@given(st.sampled_from(["can.socketcan:", "can.udp:", "can.hub:", "python-can:", ""]), st.text(max_size=20))
def test_any_text_is_a_bus_or_refused(kind: str, rest: str) -> None:
    with suppress(RigError):
        parse(kind + rest)
