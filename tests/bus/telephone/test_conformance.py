"""Every kind of telephone network keeps the same promises between two members."""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Callable, Coroutine
from pathlib import Path
from random import Random
from typing import Any

import pytest
from patience import PATIENCE_S

from fieldrig.clock import S, VirtualClock
from fieldrig.hub.hub import LocalHub
from fieldrig.link import Link
from fieldrig.loop.real_clock import RealClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.telephone.bus import TelephoneSettings, TelephoneVirtual
from fieldrig_bus.telephone.exchange import TelephoneExchange, TelephoneExchangeSettings
from fieldrig_bus.telephone.message import Dial, Heard, Hook, Ring, TelephoneMessage, Tone
from fieldrig_bus.telephone.outside import OutsideModem

SETTINGS: dict[str, Any] = {"numbers": {"near": "100", "far": "200"}, "delay_ms": 1.0, "ring_off_ms": 200.0}
EVERY_BYTE = bytes(range(256))


class Bench(ABC):
    """Two members with what they have heard, and a modem at each, on a network of this kind."""

    near: Link[TelephoneMessage]
    far: Link[TelephoneMessage]

    def __init__(self, run: Path) -> None:
        self.run = run
        self.heard: dict[str, list[TelephoneMessage]] = {"near": [], "far": []}
        self.data: dict[str, bytes] = {"near": b"", "far": b""}
        self.over: list[str] = []
        self.modems: dict[str, OutsideModem] = {}

    def put_modem(self, name: str, link: Link[TelephoneMessage], clock: Any) -> None:
        def on_data(data: bytes) -> None:
            self.data[name] += data

        self.modems[name] = OutsideModem(link, clock, on_data, lambda: self.over.append(name))

    def receive(self, name: str, message: TelephoneMessage) -> None:
        self.heard[name].append(message)
        self.modems[name].from_network(message)

    @abstractmethod
    async def open(self) -> None: ...
    @abstractmethod
    async def close(self) -> None: ...
    @abstractmethod
    async def until(self, is_so: Callable[[], bool]) -> None: ...


class Virtual(Bench):
    async def open(self) -> None:
        self.clock = VirtualClock()
        self.model = TelephoneVirtual("net", TelephoneSettings.model_validate(SETTINGS)).model()
        self.model.begin(0, Random(1))
        for name in ("near", "far"):
            self.model.join(name)
            self.model.listen(0, name, None)
            link: RecordedLink[TelephoneMessage] = RecordedLink()
            link.send = lambda message, name=name: self.model.submit(self.clock.now_ns(), name, message)  # type: ignore[method-assign,misc]
            setattr(self, name, link)
            self.put_modem(name, link, self.clock)

    async def close(self) -> None:
        pass

    async def until(self, is_so: Callable[[], bool]) -> None:
        while not is_so():
            instants = [when for when in (self.model.next_ns(), self.clock.next_ns()) if when is not None]
            assert instants
            assert min(instants) < PATIENCE_S * S
            self.clock.advance_to(min(instants))
            for delivery in self.model.collect(self.clock.now_ns()):
                for receiver in delivery.receivers:
                    self.receive(receiver, delivery.message)


class Exchange(Bench):
    async def open(self) -> None:
        self.clock = RealClock(asyncio.get_running_loop())
        self.hub = LocalHub(
            TelephoneExchange("net", TelephoneExchangeSettings.model_validate(SETTINGS)), self.clock, self.run
        )
        for name in ("near", "far"):
            link = self.hub.join(name)
            link.on_receive(lambda message, name=name: self.receive(name, message))  # type: ignore[misc]
            setattr(self, name, link)
            self.put_modem(name, link, self.clock)
        await self.hub.open(serve=False)

    async def close(self) -> None:
        await self.hub.close()
        self.clock.close()

    async def until(self, is_so: Callable[[], bool]) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while not is_so():
                await asyncio.sleep(0.001)


def on_every_kind(test: Callable[[Any], Coroutine[Any, Any, None]]) -> Any:
    @pytest.mark.parametrize("kind", [Virtual, pytest.param(Exchange, marks=pytest.mark.system)])
    def run(kind: Callable[[Path], Bench], tmp_path: Path) -> None:
        async def opened() -> None:
            bench = kind(tmp_path)
            await bench.open()
            try:
                await test(bench)
            finally:
                await bench.close()

        asyncio.run(opened())

    run.__name__, run.__doc__ = test.__name__, test.__doc__
    return run


async def connected(bench: Bench) -> Bench:
    bench.modems["near"].call("200")
    await bench.until(lambda: bool(bench.heard["far"]))
    bench.modems["far"].answer()
    await bench.until(lambda: all(modem.pump.is_running for modem in bench.modems.values()))
    return bench


@on_every_kind
async def test_a_seized_line_gives_the_dial_tone(bench: Bench) -> None:
    bench.near.send(Hook(True))
    await bench.until(lambda: bench.heard["near"] == [Heard(Tone.DIAL)])


@on_every_kind
async def test_the_called_line_rings_with_the_number_of_the_caller(bench: Bench) -> None:
    bench.near.send(Hook(True))
    bench.near.send(Dial("200"))
    await bench.until(lambda: len(bench.heard["far"]) == 3)
    assert bench.heard["far"] == [Ring(True, "100"), Ring(False, "100"), Ring(True, "100")]
    assert bench.heard["near"] == [Heard(Tone.DIAL), Heard(Tone.RINGING)]


@on_every_kind
async def test_every_byte_passes_both_ways_at_once(bench: Bench) -> None:
    await connected(bench)
    bench.modems["near"].pump.send(EVERY_BYTE * 4)
    bench.modems["far"].pump.send(EVERY_BYTE[::-1] * 4)
    await bench.until(lambda: all(len(data) >= 1024 for data in bench.data.values()))
    assert bench.data == {"near": EVERY_BYTE[::-1] * 4, "far": EVERY_BYTE * 4}


@on_every_kind
async def test_an_end_that_is_not_ready_gets_nothing_until_it_is(bench: Bench) -> None:
    await connected(bench)
    bench.modems["far"].set_ready(False)
    await bench.until(lambda: bench.modems["near"].pump._is_held)
    bench.modems["near"].pump.send(EVERY_BYTE)
    assert bench.modems["near"].pump.waiting == 256
    bench.modems["far"].set_ready(True)
    await bench.until(lambda: bench.data["far"] == EVERY_BYTE)


@on_every_kind
async def test_everything_arrives_before_a_modem_that_has_finished_hangs_up(bench: Bench) -> None:
    await connected(bench)
    bench.modems["near"].pump.send(EVERY_BYTE)
    bench.modems["near"].finish()
    await bench.until(lambda: bench.over == ["near", "far"])
    assert bench.data["far"] == EVERY_BYTE


@on_every_kind
async def test_a_call_to_a_line_in_use_is_over_at_once(bench: Bench) -> None:
    bench.far.send(Hook(True))
    await bench.until(lambda: bool(bench.heard["far"]))
    bench.modems["near"].call("200")
    await bench.until(lambda: bench.over == ["near"])
    assert bench.heard["near"][-1] == Heard(Tone.BUSY)
