"""The law of sending at ends of direct buses as a process of a rig in real time, or a tool, makes them."""

import asyncio
import re
from pathlib import Path
from typing import Any

import pytest
from talkers import CanTalker, WireTalker

from fieldrig.config.rig_file import from_dict
from fieldrig.control import endpoint
from fieldrig.control.messages import Control
from fieldrig.hub.tool_member import join
from fieldrig.loop.real_clock import RealClock
from fieldrig.real.placement import placement
from fieldrig.real.process import DeviceProcess
from fieldrig.testing import free_port
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.wires import Signal

pytestmark = pytest.mark.system

TALKERS: dict[str, tuple[type[CanTalker | WireTalker], str, list[Any], Any]] = {
    # A frame that no bus can carry cannot be made; wires carry finite numbers under a name.
    "can.udp": (CanTalker, "can", ["hello", None, Signal("a", 1)], CanFrame(1, bytes(8))),
    "wires.zenoh": (WireTalker, "wires", ["hello", Signal("a", float("nan")), CanFrame(1)], Signal("a", 1.0)),
}  # fmt: skip


def rig_of(kind: str, tmp_path: Path) -> Any:
    cls, link, _, _ = TALKERS[kind]
    bus = {"kind": kind, **({"port": free_port()} if kind == "can.udp" else {})}
    device = {"kind": f"talkers:{cls.__name__}", "links": {link: "bus0"}}
    data = {"time": "real", "run": str(tmp_path), "buses": {"bus0": bus}, "devices": {"io": device}}
    return from_dict(data, tmp_path)


@pytest.mark.parametrize("kind", TALKERS)
def test_a_device_of_a_process_can_t_send_what_can_t_be(kind: str, tmp_path: Path) -> None:
    config = rig_of(kind, tmp_path)
    cls, _, wrong, good = TALKERS[kind]

    async def scene() -> None:
        control = Control(endpoint.listen(f"tcp/127.0.0.1:{free_port()}"), config.name)
        clock = RealClock(asyncio.get_running_loop())
        (plan,) = placement(config).values()
        process = DeviceProcess(config, plan, clock, control)
        try:
            await process.open()
            await process.attach(60)
            process.start()
            device = process.devices["io"].present
            assert isinstance(device, cls)
            check(device.link, wrong)
            device.link.send(good)
        finally:
            await process.close()
            await control.close()
            clock.close()

    asyncio.run(scene())


def test_a_tool_cannot_send_what_the_bus_refuses(tmp_path: Path) -> None:
    bus = rig_of("can.udp", tmp_path).buses["bus0"].bus
    _, _, wrong, good = TALKERS["can.udp"]
    visited = []

    def start(_clock: Any, link: Any, on_end: Any) -> None:
        check(link, wrong)
        link.send(good)
        visited.append(link)
        on_end(None)

    join(bus, tmp_path, "io", start)
    assert visited


def check(link: Any, wrong: list[Any]) -> None:
    for message in wrong:
        with pytest.raises((TypeError, ValueError), match=re.escape("io cannot send ") + r".* on bus0: "):
            link.send(message)
    with pytest.raises((TypeError, ValueError), match=r"io cannot listen to .* on bus0: "):
        link.on_receive(lambda _: None, [object()])
