"""The port to the kernel where TUN is not allowed."""

import asyncio
import os
from pathlib import Path

import pytest
from in_loop import in_loop

from fieldrig.errors import BusError
from fieldrig.hub.hub import LocalHub
from fieldrig.loop.real_clock import RealClock
from fieldrig_bus.ip import tun
from fieldrig_bus.ip.kernel import KernelPort
from fieldrig_bus.ip.message import RelayMessage
from fieldrig_bus.ip.relay import IpRelay, RelaySettings


def test_the_device_has_its_own_stack_unless_the_rig_says_otherwise() -> None:
    assert IpRelay("relay", RelaySettings()).ports() == ()
    assert [type(port) for port in IpRelay("relay", RelaySettings(ip="auto")).ports()] == [KernelPort]


@pytest.mark.parametrize("ip", ["auto", "kernel"])
@in_loop
async def test_without_tun_there_is_a_message_with_the_reason(
    ip: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    real = os.open

    def refuse(path: str, flags: int, *more: int) -> int:
        if path == tun.DEVICE:
            raise PermissionError(1, "Operation not permitted")
        return real(path, flags, *more)

    monkeypatch.setattr(os, "open", refuse)
    clock = RealClock(asyncio.get_running_loop())
    hub = LocalHub(IpRelay("relay", RelaySettings.model_validate({"ip": ip})), clock, tmp_path)
    heard: list[RelayMessage] = []
    hub.join("plc").on_receive(heard.append)
    try:
        if ip == "kernel":
            with pytest.raises(BusError, match="kernel of this host: /dev/net/tun: Operation not permitted"):
                await hub.open(serve=False)
        else:
            await hub.open(serve=False)
            assert "Operation not permitted; it ends in the stack of the device" in caplog.text
            assert heard == []
    finally:
        await hub.close()
        clock.close()
