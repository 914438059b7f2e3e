"""Probing over the ring: S-0-0169, S-0-0170 and what belongs to them, on the drive's two inputs."""

import pytest
from mc4_bench import DriveBench

from fieldrig_bus.wires import Signal
from fieldrig_devices.sercos.idn import Code, Element, ServiceError

PER_MS = 50.0
"""Increments; 200 in a cycle."""
START, CLEAR = b"\x03\0", b"\0\0"


def put(bench: DriveBench, probe: int, is_on: bool, ms: float = 8) -> None:
    """Switch an input now, and let this time pass."""
    bench.wires.send(Signal(f"d1.probe_{probe}", is_on))
    bench.run(ms)


def turning() -> DriveBench:
    bench = DriveBench({}).up().enable()
    bench.follow(lambda cycle: int(4 * PER_MS * cycle))
    return bench.run(600)


def arm(bench: DriveBench, edges: int) -> None:
    assert bench.write(169, bytes((edges, 0))) == b""
    assert bench.write(170, START) == b""
    for enable in (405, 406):
        assert bench.write(enable, b"\1\0") == b""


@pytest.mark.long
@pytest.mark.manual("PD-194")
def test_an_edge_latches_the_position_of_its_instant_and_not_of_its_cycle() -> None:
    """Four edges within one cycle, a millisecond apart."""
    bench = turning()
    arm(bench, 0b1111)
    before = bench.number(51)
    for probe, is_on in ((1, True), (2, True), (1, False), (2, False)):
        put(bench, probe, is_on, ms=1)
    places = [bench.number(idn) for idn in (130, 132, 131, 133)]
    assert before < places[0] < places[3] < bench.number(51)
    assert [place - places[0] for place in places] == pytest.approx([0, PER_MS, 2 * PER_MS, 3 * PER_MS], abs=1.5)


@pytest.mark.manual("PD-194")
@pytest.mark.parametrize(
    ("edges", "values"),
    [(0b0001, {130}), (0b0010, {131}), (0b0100, {132}), (0b1000, {133}), (0b1111, {130, 131, 132, 133}), (0, set())],
)
def test_only_the_edges_that_were_asked_for_are_latched(edges: int, values: set[int]) -> None:
    bench = turning()
    arm(bench, edges)
    for is_on in (True, False):
        for probe in (1, 2):
            put(bench, probe, is_on)
            assert bench.number(400 + probe) == is_on
    assert {idn for idn in (130, 131, 132, 133) if bench.number(idn)} == values
    assert bench.number(179) == edges
    assert [bench.number(idn) for idn in (409, 410, 411, 412)] == [edges >> bit & 1 for bit in range(4)]


@pytest.mark.manual("PD-194")
def test_an_edge_is_latched_once_until_the_probe_is_enabled_again() -> None:
    bench = turning()
    arm(bench, 0b0101)
    put(bench, 1, True)
    first = bench.number(130)
    put(bench, 1, False)
    put(bench, 1, True)
    put(bench, 2, True)
    assert (bench.number(130), bench.number(179)) == (first, 0b0101)
    bench.write(405, b"\0\0")
    assert bench.number(179) == 0b0100, "that of the other probe stays"
    put(bench, 1, False)
    put(bench, 1, True)
    assert bench.number(130) == first, "it is not enabled"
    bench.write(405, b"\1\0")
    put(bench, 1, False)
    put(bench, 1, True)
    assert bench.number(130) > first


def test_nothing_is_latched_while_the_command_is_not_active() -> None:
    bench = turning()
    arm(bench, 0b0001)
    status = bench.read(170, Element.IDN)
    assert isinstance(status, bytes)
    assert status[0] & 0xF == 7, "it is carried out until it is cleared"
    bench.write(170, CLEAR)
    put(bench, 1, True)
    assert (bench.number(130), bench.number(179)) == (0, 0)


def test_a_ring_that_went_down_ends_the_command() -> None:
    bench = turning()
    arm(bench, 0b0001)
    bench.master.request_phase(0)
    bench.run(100)
    bench.master.request_phase(4)
    bench.run(3_000)
    put(bench, 1, True)
    assert bench.number(179) == 0
    assert bench.write(170, START) == b"", "it can be begun again"


def test_what_probing_refuses() -> None:
    bench = DriveBench({}).up()
    for idn, data, code in (
        (169, b"\x10\0", Code.ABOVE_MAXIMUM),
        (405, b"\2\0", Code.ABOVE_MAXIMUM),
        (130, b"\0\0\0\0", Code.READ_ONLY),
        (179, b"\0\0", Code.READ_ONLY),
    ):
        answer = bench.write(idn, data)
        assert isinstance(answer, ServiceError)
        assert answer.code == code
