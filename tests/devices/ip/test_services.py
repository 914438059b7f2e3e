"""A stack whose services are behind a relay, in virtual time and at the listeners of this host."""

import asyncio
from pathlib import Path
from typing import Any

import pytest
from in_loop import in_loop
from ip_line import CONTROLLER, Line, User
from patience import PATIENCE_S

from fieldrig.hub.hub import LocalHub
from fieldrig.loop.real_clock import RealClock
from fieldrig_bus.ip.channel import Channel
from fieldrig_bus.ip.message import IN_CHANNEL, Offered, Opened, RelayMessage
from fieldrig_bus.ip.model import RelayModel
from fieldrig_bus.ip.relay import IpRelay, RelaySettings
from fieldrig_devices.ip.services import RelayedServices
from fieldrig_devices.ip.tcp.connection import Ending

PAGE = bytes(place * 5 & 0xFF for place in range(200_000))


class End:
    """A member's end of the model."""

    def __init__(self, bench: "Bench", name: str) -> None:
        self._bench, self._name = bench, name

    def send(self, message: RelayMessage) -> None:
        self._bench.model.submit(self._bench.line.now_ns, self._name, message)

    def on_receive(self, handler: Any, interest: object = None) -> None:
        self._bench.handlers[self._name] = handler
        self._bench.model.join(self._name)
        self._bench.model.listen(0, self._name, None)


class Bench:
    """A caller, a line, the stack of `plc`, the relay, and the device `web` behind it."""

    def __init__(self) -> None:
        self.line = Line(mtu=1500, window=32_768)
        self.model = RelayModel()
        self.handlers: dict[str, Any] = {}
        self.services = RelayedServices("plc", End(self, "plc"), lambda: None)
        self.services.attach(self.line.controller)
        self.web = End(self, "web")
        self.web.on_receive(self._on_request)
        self.web.send(Offered((80,)))
        self.channels: list[Channel] = []
        self.run(0)

    def _on_request(self, message: RelayMessage) -> None:
        if isinstance(message, Opened):
            channel = Channel(message.opener, message.number, True, self.web.send)

            def on_data(_: bytes) -> None:
                channel.send(PAGE)
                channel.end()

            channel.on_data = on_data
            self.channels.append(channel)
        elif isinstance(message, IN_CHANNEL):
            self.channels[-1].take(message)

    def run(self, seconds: float) -> None:
        until_ns = self.line.now_ns + round(seconds * 1e9)
        while True:
            while self.model.next_ns() is not None:
                for delivery in self.model.collect(1 << 62):
                    for receiver in delivery.receivers:
                        self.handlers[receiver](delivery.message)
            due_ns = self.line.next_ns()
            if due_ns is None or due_ns > until_ns:
                break
            self.line.run(max(due_ns, self.line.now_ns))
        self.line.now_ns = until_ns


@pytest.mark.manual("PD-240")
def test_a_connection_is_carried_to_the_device_that_offers_its_port() -> None:
    bench = Bench()
    user = User(bench.line.caller.connect(CONTROLLER, 80))
    user.connection.send(b"GET")
    bench.run(10)
    user.connection.end()
    bench.run(10)
    assert (bytes(user.received), user.has_end, user.endings) == (PAGE, True, [Ending.COMPLETE])
    assert len(bench.services._channels) == 0
    assert bench.model.statistics(0)["channels"] == 0


def test_a_port_that_is_not_offered_is_refused() -> None:
    bench = Bench()
    user = User(bench.line.caller.connect(CONTROLLER, 81))
    bench.run(1)
    assert user.endings == [Ending.REFUSED]


def test_a_lost_link_is_the_end_of_the_channels() -> None:
    bench = Bench()
    User(bench.line.caller.connect(CONTROLLER, 80))
    bench.run(1)
    bench.line.controller.link_down(bench.line.now_ns)
    bench.run(1)
    assert (bench.channels[0].is_over, bench.model.statistics(0)["channels"]) == (True, 0)


def test_a_service_that_leaves_resets_its_connections() -> None:
    bench = Bench()
    user = User(bench.line.caller.connect(CONTROLLER, 80))
    bench.run(1)
    bench.model.leave("web")
    bench.run(1)
    assert user.endings == [Ending.RESET]


# In real time


@pytest.mark.system
@in_loop
async def test_a_connection_is_carried_to_a_listener_of_this_host(tmp_path: Path) -> None:
    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        request = await reader.read()
        writer.write(request * 2)
        await writer.drain()
        writer.close()

    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    address = f"127.0.0.1:{server.sockets[0].getsockname()[1]}"
    line, clock = Line(mtu=1500), RealClock(asyncio.get_running_loop())
    settings = RelaySettings(services={80: address, 81: "127.0.0.1:1"})
    hub = LocalHub(IpRelay("relay", settings), clock, tmp_path)
    services = RelayedServices("plc", hub.join("plc"), lambda: None)
    services.attach(line.controller)
    await hub.open(serve=False)
    try:
        await until(lambda: services._ports == {80, 81}, line)
        user, refused = User(line.caller.connect(CONTROLLER, 80)), User(line.caller.connect(CONTROLLER, 81))
        user.connection.send(PAGE)
        user.connection.end()
        await until(lambda: bool(user.endings and refused.endings), line)
        assert bytes(user.received) == PAGE * 2
        assert (user.endings, refused.endings) == ([Ending.COMPLETE], [Ending.RESET])
        assert len(services._channels) == 0
    finally:
        await hub.close()
        clock.close()
        server.close()
        await server.wait_closed()


async def until(condition: Any, line: Line) -> None:
    """Let the line and the loop run until the condition is true."""
    async with asyncio.timeout(PATIENCE_S):
        while not condition():
            line.run_for(0.01)
            await asyncio.sleep(0)
