"""A member that declares its bit rate.  At 1 Mbit/s a bit takes 1 us."""

import asyncio
import socket
from random import Random
from typing import Any

import pytest
from direct_bench import At
from hub_bench import HubBench, LoopBench, hub_bench

from fieldrig.bus import Delivery
from fieldrig.clock import MS, US, S
from fieldrig.testing import RecordedLink
from fieldrig_bus.can.acceptance import Filters
from fieldrig_bus.can.codec import CanMessage
from fieldrig_bus.can.direct import DirectEnd
from fieldrig_bus.can.faulty_link import FaultyLink
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.hub import CanHub, CanHubSettings
from fieldrig_bus.can.model import CanBusModel
from fieldrig_bus.can.notices import BitRate, CanControl, CanError, CanState, use_bit_rate
from fieldrig_bus.can.outsiders import OutsidersSettings
from fieldrig_bus.can.virtual import CanVirtual

FRAME = CanFrame(0x123, b"\x55")
WRONG = BitRate(250_000)


def bus(bitrate: int | None = 1_000_000, **settings: Any) -> CanBusModel:
    model = CanVirtual("can0", OutsidersSettings.model_validate({"bitrate": bitrate, **settings})).model()
    model.begin(0, Random(7))
    for member in ("a", "b", "c"):
        model.join(member)
        model.listen(0, member, [[0, 0], "state"])
    return model


def heard(deliveries: list[Delivery[CanMessage]]) -> list[tuple[str, tuple[str, ...]]]:
    return [(each.sender, tuple(each.receivers)) for each in deliveries if isinstance(each.message, CanFrame)]


@pytest.mark.long
@pytest.mark.parametrize("bit_per_s", [250_000, 800_000])
def test_wrong_bit_rate_is_that_of_the_fault(bit_per_s: int) -> None:
    declared, faulty = bus(), bus()
    declared.submit(0, "c", BitRate(bit_per_s))
    faulty.add_fault(0, {"what": "wrong_bit_rate", "node": "c", "bitrate": bit_per_s})
    for model in (declared, faulty):
        model.submit(0, "a", FRAME)
        model.submit(20 * MS, "c", FRAME)
    assert declared.collect(S) == faulty.collect(S)
    assert declared.statistics(S) == faulty.statistics(S)


def test_member_with_another_bit_rate_hears_nothing_and_its_frames_are_errors() -> None:
    model = bus()
    model.submit(0, "c", WRONG)
    model.submit(0, "a", FRAME)
    first = model.collect(20 * MS)
    assert heard(first) == [("a", ("b",))]  # once c is error passive
    model.submit(20 * MS, "c", FRAME)
    second = model.collect(40 * MS)
    assert heard(second) == []
    assert any(each.sender == "c" and isinstance(each.message, CanError) for each in second)
    assert model.statistics(40 * MS)["c.state"] == CanState.PASSIVE


def test_bit_rate_of_the_bus_changes_nothing() -> None:
    model = bus()
    model.submit(0, "c", BitRate(1_000_000))
    model.submit(0, "a", CanFrame(0))
    assert [(each.time_ns, each.receivers) for each in model.collect(MS)] == [(50 * US, ("b", "c"))]


def test_member_is_back_when_it_takes_the_bit_rate_of_the_bus() -> None:
    model = bus()
    model.submit(0, "c", WRONG)
    model.submit(0, "a", FRAME)
    model.collect(20 * MS)
    model.submit(20 * MS, "c", BitRate(1_000_000))
    model.submit(21 * MS, "a", FRAME)
    model.submit(22 * MS, "c", FRAME)
    assert heard(model.collect(30 * MS)) == [("a", ("b", "c")), ("c", ("a", "b"))]


def test_listen_only_member_with_another_bit_rate_hears_nothing_and_disturbs_no_other() -> None:
    model = bus()
    model.submit(0, "c", CanControl(is_listen_only=True))
    model.submit(0, "c", WRONG)
    model.submit(0, "a", FRAME)
    assert heard(model.collect(MS)) == [("a", ("b",))]


def test_fault_goes_before_what_a_member_says() -> None:
    model = bus()
    model.submit(0, "c", WRONG)
    model.add_fault(0, {"what": "wrong_bit_rate", "node": "c", "bitrate": 1_000_000})
    model.submit(0, "a", FRAME)
    assert heard(model.collect(MS)) == [("a", ("b", "c"))]


def test_without_bit_times_there_is_no_wrong_bit_rate() -> None:
    model = bus(None)
    model.submit(0, "c", WRONG)
    model.submit(0, "a", FRAME)
    assert heard(model.collect(MS)) == [("a", ("b", "c"))]


def test_bit_rate_is_set_by_the_link() -> None:
    link = RecordedLink[Any]()
    use_bit_rate(link, 125_000)
    assert link.sent == [BitRate(125_000)]


def hub(attach: str | None) -> CanHub:
    return CanHub("can0", CanHubSettings.model_validate({"bitrate": 1_000_000, "attach": attach}))


def deaf(bench: HubBench) -> list[str]:
    return [member.name for member in bench.hub.model.members.values() if member.skew is not None]  # type: ignore[attr-defined]


@pytest.mark.long
def test_member_in_another_process_says_it_again_to_a_new_hub() -> None:
    with hub_bench(hub, "unix", 0) as bench:
        first = bench.join("a")
        first.send(FRAME)
        first.send(WRONG)
        first.send(BitRate(125_000))
        bench.pump(lambda: deaf(bench) == ["a"])
        standing = bench._remote[0]._standing
        assert [bench.bus.decode(data) for data in standing.values()] == [BitRate(125_000)]


class QuietEnd(DirectEnd):
    """An end of a medium that carries nothing."""

    def transmit(self, frame: CanFrame) -> bool:
        raise AssertionError(frame)

    def listen(self, filters: Filters | None, with_own: bool) -> None:
        raise NotImplementedError

    def receive(self) -> None:
        raise NotImplementedError


def test_medium_that_is_there_without_us_has_its_own_bit_rate() -> None:
    async def end(at: At, sock: socket.socket) -> QuietEnd:
        return QuietEnd(at, sock)

    bench = LoopBench()
    ours, theirs = socket.socketpair()
    try:
        at = At("a", bench.clock)
        quiet = bench.loop.run_until_complete(end(at, ours))
        use_bit_rate(quiet, 250_000)
        use_bit_rate(FaultyLink(at, quiet, [], Random(7)), 250_000)
        bench.loop.run_until_complete(asyncio.sleep(0))
        assert at.traced == []
        quiet.close()
    finally:
        theirs.close()
        bench.close()
