"""The trace: values in every n-th control loop, as far as the line can carry them."""

import struct

import pytest
from arp_user_port import PortBench

LENGTH, RANGE = 3, 4
START, STOP, STATE = 0x51, 0x52, 0x02
COUNT = "L:\nV1 += 0.001\nWAIT 0.001\nGOTO L"  # 1 raw in each control loop


def request(every: int, *quantities: tuple[str, int]) -> bytes:
    return struct.pack("<H", every) + b"".join(struct.pack("<BH", ord(kind), number) for kind, number in quantities)


def samples(bench: PortBench, count: int) -> tuple[list[tuple[int, ...]], int]:
    """Loop and values of all samples received, and the number of samples lost so far."""
    found, lost = [], 0
    for body in bench.heard():
        assert body[:2] + body[3:4] == bytes((1, 1, 0xE1))
        (lost,) = struct.unpack_from("<I", body, 4)
        found += list(struct.iter_unpack(f"<I{count}i", body[8:]))
    return found, lost


@pytest.fixture
def bench() -> PortBench:
    return PortBench(COUNT, is_enabled=True, user_port={"baud": 1_000_000})


def test_a_sample_of_every_control_loop(bench: PortBench) -> None:
    bench.ok(START, request(1, ("V", 1), ("P", 1), ("C", 0)))
    bench.run_for(100)
    found, lost = samples(bench, 3)
    assert (len(found), lost) == (100, 0)
    loops, counts, positions, states = zip(*found, strict=True)
    assert list(loops) == list(range(loops[0], loops[0] + 100))
    assert list(counts) == list(range(counts[0], counts[0] + 100))
    assert (set(positions), set(states)) == ({0}, {3})


def test_a_sample_of_every_tenth(bench: PortBench) -> None:
    bench.ok(START, request(10, ("V", 1)))
    bench.run_for(100)
    found, _ = samples(bench, 1)
    assert [loop - found[0][0] for loop, _ in found] == list(range(0, 100, 10))


def test_it_ends(bench: PortBench) -> None:
    bench.ok(START, request(1, ("V", 1)))
    bench.run_for(10)
    bench.heard()
    bench.ok(STOP)
    bench.run_for(100)
    assert bench.heard() == []


def test_a_new_one_takes_the_place_of_the_old(bench: PortBench) -> None:
    bench.ok(START, request(1, ("V", 1)))
    bench.ok(START, request(5, ("V", 1), ("V", 2)))
    bench.run_for(100)
    assert len(samples(bench, 2)[0]) == 20


@pytest.mark.parametrize(
    ("data", "status"),
    [
        (b"", LENGTH),
        (request(1), LENGTH),
        (request(1, *[("V", 1)] * 17), LENGTH),
        (request(0, ("V", 1)), RANGE),
        (request(1, ("V", 1_001)), RANGE),
        (request(1, ("V", 1))[:-1], LENGTH),
    ],
)
def test_what_can_not_be_traced_leaves_the_old_trace(bench: PortBench, data: bytes, status: int) -> None:
    bench.ok(START, request(1, ("V", 1)))
    assert bench.ask(START, data)[0] == status
    bench.run_for(10)
    assert len(samples(bench, 1)[0]) == 10


def test_sixteen_quantities_fit(bench: PortBench) -> None:
    bench.ok(START, request(1, *[("V", 1)] * 16))
    bench.run_for(10)
    assert len(samples(bench, 16)[0]) == 10


class SlowLine:
    """Octets that the line has still to carry at 9600 baud, 960 octets per second."""

    def __init__(self, bench: PortBench) -> None:
        self._bench, self.unsent, self.sent = bench, 0.0, 0

    def run(self) -> int:
        """Run one millisecond, and return the number of octets sent in it."""
        before = len(self._bench.user.sent)
        self._bench.run_for(1)
        more = sum(len(data) for data in self._bench.user.sent[before:] if isinstance(data, bytes))
        self.unsent = max(self.unsent - 0.96, 0) + more
        self.sent += more
        return more


def test_a_slow_line_carries_what_it_can_and_the_rest_is_counted() -> None:
    bench = PortBench(COUNT, is_enabled=True, user_port={"baud": 9600})
    bench.ok(START, request(1, ("V", 1)))
    line = SlowLine(bench)
    for _ in range(5_000):
        line.run()
    assert 4_500 < line.sent < 5 * 960 + 300
    found, lost = samples(bench, 1)
    loops = [loop for loop, _ in found]
    assert loops == sorted(set(loops))
    assert lost == loops[-1] - loops[0] + 1 - len(found) > 3_500


def test_an_answer_waits_for_one_frame_of_the_trace_at_most() -> None:
    bench = PortBench(COUNT, is_enabled=True, user_port={"baud": 9600})
    bench.ok(START, request(1, *[("V", 1)] * 16))
    line = SlowLine(bench)
    most = 0.0
    for _ in range(2_000):
        line.run()
        most = max(most, line.unsent)
    assert 100 < most < 2 * 262 + 2 + 5


@pytest.mark.long
def test_a_card_without_requests_sends_nothing() -> None:
    bench = PortBench(COUNT, is_enabled=True)
    bench.run_for(20_000)
    assert bench.heard() == []
