"""The kinds `can.virtual` and `can.hub`: their settings, tools and ports."""

from pathlib import Path
from typing import Any

import pytest
from can.logger import _parse_logger_args
from pydantic import ValidationError

from fieldrig.clock import S
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.hub import CanHub, CanHubSettings
from fieldrig_bus.can.lawicel import LawicelPort
from fieldrig_bus.can.outsiders import OutsidersSettings
from fieldrig_bus.can.socketcand import SocketcandPort
from fieldrig_bus.can.virtual import CanVirtual

RUN = Path("/run/rig 1")


def hub(**settings: Any) -> CanHub:
    return CanHub("can0", CanHubSettings.model_validate(settings))


def lines(bus: CanHub) -> list[str]:
    return [tool.line for tool in bus.tools(RUN)]


def test_a_bus_has_500_kbit_s_by_default() -> None:
    model = CanVirtual("can0", OutsidersSettings()).model()
    model.join("a")
    model.join("b")
    model.submit(0, "a", CanFrame(0))
    assert model.next_ns() == (53 - 3) * S // 500_000


@pytest.mark.parametrize(
    "settings",
    [
        {"bitrate": 125_000},
        {"bitrate": None},
        {"bitrate": 500_000, "data_bitrate": 8_000_000},
        {"attach": "tcp://127.0.0.1:7000", "connect": "tcp://hub:7000"},
        {"socketcand": "127.0.0.1:29536", "channel": "vcan0"},
        {"slcan": {"path": "slcan/can0"}},
        {"slcan": {"listen": "[::1]:3333", "path": "can0"}},
    ],
)
def test_settings_that_make_sense_are_taken(settings: dict[str, Any]) -> None:
    assert hub(**settings).settings.model_dump(exclude_unset=True) == settings


@pytest.mark.parametrize(
    ("settings", "complaint"),
    [
        ({"bitrate": 9_999}, "greater than or equal to 10000"),
        ({"bitrate": 1_000_001}, "less than or equal to 1000000"),
        ({"bitrate": "500k"}, "valid integer"),
        ({"data_bitrate": 8_000_001}, "less than or equal to 8000000"),
        ({"bitrate": 500_000, "data_bitrate": 250_000}, "at least the bitrate"),
        ({"bitrate": None, "data_bitrate": 1_000_000}, "only on a bus with a bitrate"),
        ({"socketcand": "29536"}, "expected host:port"),
        ({"socketcand": "localhost:99999"}, "expected host:port"),
        ({"attach": "udp://localhost:1"}, "expected host:port"),
        ({"channel": "can 0"}, "pattern"),
        ({"slcan": {}}, "expected a path"),
        ({"slcan": {"listen": "somewhere"}}, "expected host:port"),
        ({"slcan": {"path": ""}}, "at least 1 character"),
        ({"speed": 5}, "Extra inputs"),
    ],
)
def test_settings_that_make_none_are_refused(settings: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValidationError, match=complaint):
        hub(**settings)


def test_python_can_joins_by_socketcand() -> None:
    arguments = hub(socketcand="0.0.0.0:29536", slcan={"listen": "127.0.0.1:3333"}).python_can()
    assert arguments == {"interface": "socketcand", "channel": "can0", "host": "127.0.0.1", "port": 29536}


def test_python_can_joins_by_slcan() -> None:
    assert hub(slcan={"listen": "127.0.0.1:3333"}).python_can() == {
        "interface": "slcan",
        "channel": "socket://127.0.0.1:3333",
    }


@pytest.mark.parametrize("bus", [hub(), hub(slcan={"path": "can0"}), CanVirtual("can0", OutsidersSettings())])
def test_python_can_has_no_arguments_when_it_cannot_join(bus: CanHub | CanVirtual) -> None:
    assert bus.python_can() is None


def test_the_lines_for_socketcand_say_to_python_can_what_can_bus_takes() -> None:
    bus = hub(socketcand="127.0.0.1:29536", channel="machine")
    assert lines(bus)[0].startswith("python -m can.viewer ")
    log = next(line for line in lines(bus) if line.startswith("python -m can.logger "))
    parsed, more = _parse_logger_args(log.split()[3:])
    assert {"interface": parsed.interface, "channel": parsed.channel, **parsed.bus_kwargs} == bus.python_can()
    assert more == {}  # python-can 4.6.1 reads --host=... but does not use it


def test_slcand_gets_the_pty_and_the_speed() -> None:
    assert "sudo slcand -o -c -s5 $(readlink -f '/run/rig 1/slcan0') slcan0 && sudo ip link set slcan0 up" in lines(
        hub(bitrate=250_000, slcan={"path": "slcan0"})
    )


def test_slcand_gets_no_speed_that_lawicel_does_not_know() -> None:
    assert any("slcand -o -c $(readlink" in line for line in lines(hub(bitrate=83_333, slcan={"path": "slcan0"})))


def test_a_hub_without_ways_in_has_no_lines() -> None:
    assert lines(hub()) == []


@pytest.mark.parametrize(
    ("settings", "ports"),
    [
        ({}, []),
        ({"socketcand": "127.0.0.1:0"}, [SocketcandPort]),
        ({"slcan": {"path": "slcan0"}}, [LawicelPort]),
        ({"socketcand": "127.0.0.1:0", "slcan": {"listen": "127.0.0.1:0"}}, [SocketcandPort, LawicelPort]),
    ],
)
def test_a_hub_opens_the_ways_in_that_its_settings_ask_for(settings: dict[str, Any], ports: list[type]) -> None:
    assert [type(port) for port in hub(**settings).ports()] == ports
