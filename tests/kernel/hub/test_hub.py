"""A hub carries a bus between members of its own process and of others."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from in_loop import in_loop
from patience import PATIENCE_S

from fieldrig.bus import Delivery
from fieldrig.errors import BusError, ControlError
from fieldrig.hub.attach import attach
from fieldrig.hub.hub import LocalHub
from fieldrig.hub.wire import HEADER, Kind, Records, pack
from fieldrig.loop.real_clock import RealClock
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.hub import CanHub, CanHubSettings
from fieldrig_bus.can.notices import FaultNote
from fieldrig_bus.wires import Signal, WiresHub, WiresHubSettings

pytestmark = pytest.mark.system

RUN = Signal("pump.run", True)


class HubBench:
    def __init__(self, run: Path, attach_at: str | None = None) -> None:
        self.clock = RealClock(asyncio.get_running_loop())
        self.run = run
        self.bus = WiresHub("wires", WiresHubSettings(attach=attach_at))
        self.trace: list[Delivery[Any]] = []
        self.hub = LocalHub(self.bus, self.clock, run)
        self.hub.on_delivery(self.trace.append)
        self.lost: asyncio.Future[str] = asyncio.get_running_loop().create_future()

    async def remote(self, member: str) -> Any:
        return await attach(self.bus, member, self.clock, self.run, self.lost.set_result)

    async def close(self) -> None:
        await self.hub.close()
        self.clock.close()


@asynccontextmanager
async def open_hub(run: Path, attach_at: str | None = None) -> AsyncIterator[HubBench]:
    bench = HubBench(run, attach_at)
    await bench.hub.open()
    try:
        yield bench
    finally:
        await bench.close()


class Listener:
    """Collects what a link hears; `heard(n)` waits for n messages."""

    def __init__(self, link: Any, interest: list[str] | None = None) -> None:
        self.messages: list[Any] = []
        self._changed = asyncio.Event()
        link.on_receive(self._on_message, interest)

    def _on_message(self, message: Any) -> None:
        self.messages.append(message)
        self._changed.set()

    async def heard(self, count: int) -> list[Any]:
        async with asyncio.timeout(PATIENCE_S):
            while len(self.messages) < count:
                self._changed.clear()
                await self._changed.wait()
        return self.messages


@in_loop
async def test_members_here_and_elsewhere_hear_each_other(tmp_path: Path) -> None:
    async with open_hub(tmp_path) as bench:
        here = bench.hub.join("here")
        there = await bench.remote("there")
        at_home, away = Listener(here), Listener(there)
        here.send(RUN)
        assert await away.heard(1) == [RUN]
        there.send(Signal("tank.level", 1.5, "m"))
        assert await at_home.heard(1) == [Signal("tank.level", 1.5, "m")]
        assert [delivery.sender for delivery in bench.trace if delivery.receivers] == ["here", "there"]
        await there.close()


@in_loop
async def test_who_leaves_may_come_again_and_a_taken_name_is_refused(tmp_path: Path) -> None:
    async with open_hub(tmp_path) as bench:
        first = await bench.remote("pump")
        with pytest.raises(BusError, match="already has a member 'pump'"):
            await bench.remote("pump")
        await first.close()
        async with asyncio.timeout(PATIENCE_S):
            while True:  # until the hub has seen the first one leave
                try:
                    again = await bench.remote("pump")
                    break
                except BusError:
                    await asyncio.sleep(0)
        await again.close()


@in_loop
async def test_a_lost_hub_is_told_and_the_link_attaches_again_with_its_interest(tmp_path: Path) -> None:
    async with open_hub(tmp_path) as bench:
        link = await bench.remote("panel")
        listener = Listener(link, ["pump.run"])
        await bench.hub.close()
        async with asyncio.timeout(PATIENCE_S):
            assert "gone" in await bench.lost
        link.send(RUN)  # into the void: no error
        second = LocalHub(bench.bus, bench.clock, tmp_path)
        await second.open()
        await link.connect()
        pump = second.join("pump")
        pump.send(Signal("pump.speed", 1, "%"))
        pump.send(RUN)
        assert await listener.heard(1) == [RUN]
        await link.close()
        await second.close()


@in_loop
async def test_a_hub_that_is_back_is_told_what_holds(tmp_path: Path) -> None:
    async with open_hub(tmp_path) as bench:
        pump = await bench.remote("pump")
        pump.send(Signal("pump.run", False))
        pump.send(Signal("pump.speed", 50, "%"))
        await bench.hub.close()
        await bench.lost
        pump.send(RUN)  # only the last value of a wire holds
        second = LocalHub(bench.bus, bench.clock, tmp_path)
        await second.open()
        await pump.connect()
        listener = Listener(second.join("late"))
        assert await listener.heard(2) == [RUN, Signal("pump.speed", 50, "%")]
        await pump.close()
        await second.close()


@in_loop
async def test_devices_attach_over_tcp_too_and_a_taken_port_is_refused_with_the_remedy(
    tmp_path: Path, free_port: int
) -> None:
    async with open_hub(tmp_path / "hub", f"tcp://127.0.0.1:{free_port}") as bench:
        link = await attach(bench.bus, "far", bench.clock, tmp_path / "elsewhere", print)
        listener = Listener(link)
        bench.hub.join("here").send(RUN)
        assert await listener.heard(1) == [RUN]
        other = LocalHub(bench.bus, bench.clock, tmp_path / "other")
        with pytest.raises(BusError, match="choose another port"):
            await other.open()
        await link.close()


@in_loop
async def test_faults_come_and_go_while_the_hub_runs(tmp_path: Path) -> None:
    clock = RealClock(asyncio.get_running_loop())
    trace: list[Any] = []
    bus = CanHub("can0", CanHubSettings(bitrate=None))
    hub = LocalHub(bus, clock, tmp_path)
    hub.on_delivery(lambda delivery: trace.append(delivery.message))
    sender, heard = hub.join("here"), list[CanFrame]()
    hub.join("there").on_receive(heard.append)
    number = hub.add_fault({"what": "drop", "count": 1})
    sender.send(CanFrame(1))
    assert hub.faults()[number] == {"what": "drop", "count": 1, "state": "over", "applied": 1}
    sender.send(CanFrame(2))
    assert heard == [CanFrame(2)]
    assert trace == [FaultNote(number, "dropped"), CanFrame(1), CanFrame(2)]
    hub.clear_fault(number)
    assert hub.faults() == {}
    with pytest.raises(ControlError, match="can0: there is no fault 1\n  there are none"):
        hub.clear_fault(number)
    with pytest.raises(ControlError, match=r"can0: there is no fault 'dorp'\n  did you mean drop\?"):
        hub.add_fault({"what": "dorp"})
    await hub.close()
    clock.close()


@in_loop
async def test_faults_of_members_here_and_elsewhere_are_in_the_trace(tmp_path: Path) -> None:
    async with open_hub(tmp_path) as bench:
        listener, tank = Listener(bench.hub.join("panel")), await bench.remote("tank")
        tank.note(FaultNote(1, "leak"))
        tank.send(RUN)
        await listener.heard(1)
        here: Any = bench.hub.join("here")
        here.note(FaultNote(2, "power_off"))
        assert [(delivery.sender, delivery.message) for delivery in bench.trace] == [
            ("tank", FaultNote(1, "leak")),
            ("tank", RUN),
            ("here", FaultNote(2, "power_off")),
        ]


@in_loop
async def test_a_fault_that_needs_no_frame_wakes_the_hub(tmp_path: Path) -> None:
    clock = RealClock(asyncio.get_running_loop())
    hub = LocalHub(CanHub("can0", CanHubSettings()), clock, tmp_path)
    hub.join("here")
    listener = Listener(hub.join("there"))
    hub.add_fault({"what": "babble", "node": "here", "identifier": 5, "count": 3})
    assert await listener.heard(3) == [CanFrame(5)] * 3
    await hub.close()
    clock.close()


@in_loop
async def test_no_hub_is_an_error_with_a_remedy(tmp_path: Path) -> None:
    bench = HubBench(tmp_path)
    with pytest.raises(BusError, match="start the process that runs this bus first"):
        await bench.remote("pump")
    await bench.close()


@in_loop
async def test_a_medium_with_more_work_than_there_is_time_for_leaves_others_their_turn(tmp_path: Path) -> None:
    bench = HubBench(tmp_path)
    bench.hub.model.next_ns = lambda: 0  # type: ignore[method-assign]
    bench.hub.carry()
    for _ in range(3):
        await asyncio.sleep(0.001)
    await bench.close()


@pytest.mark.parametrize(
    "garbage",
    [
        b"GET / HTTP/1.1\r\n\r\n",
        pack(Kind.MESSAGE, 0, b"[]"),
        pack(Kind.HELLO, 0, b"{}"),
        pack(Kind.HELLO, 0, b'{"bus":"wires","member":"x"}') + pack(Kind.MESSAGE, 0, b"nonsense"),
        pack(Kind.HELLO, 0, b'{"bus":"wires","member":"x"}') + pack(Kind.MESSAGE, 0, b"\xff\x01\0\0\0drop"),
        pack(Kind.HELLO, 0, b'{"bus":"wires","member":"x"}') + pack(Kind.NOTE, 0, b"\xff\x01"),
        HEADER.pack(Kind.HELLO, 0, 0xFFFFFFFF),
    ],
)
@in_loop
async def test_a_stranger_that_talks_nonsense_is_put_off_and_the_bus_goes_on(tmp_path: Path, garbage: bytes) -> None:
    async with open_hub(tmp_path) as bench:
        reader, writer = await asyncio.open_unix_connection(str(tmp_path / "wires.sock"))
        writer.write(garbage)
        async with asyncio.timeout(PATIENCE_S):
            try:
                while await reader.read(4096):
                    pass
            except ConnectionResetError:
                pass
        writer.close()
        listener = Listener(await bench.remote("panel"))
        bench.hub.join("here").send(RUN)
        assert await listener.heard(1) == [RUN]


@given(st.lists(st.tuples(st.sampled_from(list(Kind)), st.integers(-(1 << 63), (1 << 63) - 1), st.binary())), st.data())
def test_records_survive_any_cut_of_the_stream(records: list[tuple[Kind, int, bytes]], data: st.DataObject) -> None:
    stream = b"".join(pack(*record) for record in records)
    cutter, seen = Records(), []
    while stream:
        cut = data.draw(st.integers(1, len(stream)))
        seen += list(cutter.feed(stream[:cut]))
        stream = stream[cut:]
    assert seen == records
