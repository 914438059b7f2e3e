"""A master that is lost, or takes the node down, in the middle of something (6007h of CiA 402-2)."""

import pytest
from cia402_bench import Cia402Bench

pytestmark = pytest.mark.long

PP, PV = 1, 3
NO_ACTION, FAULT_SIGNAL, DISABLE_VOLTAGE, QUICK_STOP = range(4)
STOP, START, RESET_NODE = "000#02 05", "000#01 05", "000#81 05"


@pytest.fixture
def bench() -> Cia402Bench:
    return Cia402Bench()


def stopped(bench: Cia402Bench, cycles: int) -> Cia402Bench:
    """The master stops the node, and looks again later."""
    bench.send(STOP)
    bench.cycles(cycles)
    bench.send(START)
    return bench


@pytest.mark.parametrize(("option", "status"), [(FAULT_SIGNAL, 0x08), (DISABLE_VOLTAGE, 0x40), (QUICK_STOP, 0x40)])
def test_an_axis_that_is_being_enabled_loses_its_master_too(bench: Cia402Bench, option: int, status: int) -> None:
    """The brake takes 25 cycles, and the master is gone after 3."""
    bench.motor.lifting = 25
    bench.put(0x6007, option).put(0x6060, PP).control(0x06).control(0x0F).cycles(3)
    assert stopped(bench, 40).status(0x6F) == status
    assert not bench.motor.is_following


def test_no_action_lets_an_axis_be_enabled_to_the_end(bench: Cia402Bench) -> None:
    bench.motor.lifting = 25
    bench.put(0x6007, NO_ACTION).put(0x6060, PP).control(0x06).control(0x0F).cycles(3)
    assert stopped(bench, 40).status(0x6F) == 0x27


# Transitions 7 and 10 by command; a fault is for an axis under power.
@pytest.mark.parametrize(("option", "status"), [(FAULT_SIGNAL, 0x21), (DISABLE_VOLTAGE, 0x40), (QUICK_STOP, 0x40)])
def test_power_that_comes_back_finds_no_command_of_a_lost_master(bench: Cia402Bench, option: int, status: int) -> None:
    bench.motor.is_ready = False
    bench.put(0x6007, option).put(0x6060, PP).control(0x06).control(0x0F).cycles(3)
    bench.send(STOP)
    bench.cycles(3)
    bench.motor.is_ready = True
    bench.cycles(3)
    bench.send(START)
    assert bench.status(0x6F) == status
    assert not bench.motor.is_following


def test_reset_node_takes_enabling_back(bench: Cia402Bench) -> None:
    bench.motor.lifting = 25
    bench.put(0x6060, PP).control(0x06).control(0x0F).cycles(3)
    bench.send(RESET_NODE)
    assert bench.cycles(40).status(0x6F) == 0x40
    assert not bench.motor.is_following


def test_reset_node_in_a_fault_reaction_takes_power_away(bench: Cia402Bench) -> None:
    bench.put(0x605E, 1).put(0x6065, 10_000).put(0x60FF, 5_000_000).enabled(PV).cycles(200)
    bench.motor.lag = 20_000
    assert bench.cycles(3).status(0x4F) == 0x0F
    bench.send(RESET_NODE)
    assert bench.cycles(40).status(0x6F) == 0x40
    assert not bench.motor.is_following


def test_a_heartbeat_is_watched_anew_after_a_reset(bench: Cia402Bench) -> None:
    for _ in range(2):
        bench.put(0x1016, 0x0063_0064, 1).put(0x6007, QUICK_STOP).put(0x605A, 6).enabled(PP)
        bench.send("763#05")
        bench.after(101)
        assert bench.cycles(1).status(0x6F) == 0x07
        bench.send(RESET_NODE)
        bench.send(START)
        bench.cycles(2)


def test_a_master_that_guards_is_watched(bench: Cia402Bench) -> None:
    """100Ch x 100Dh: 30 ms.  The answer has the NMT state and a toggle bit."""
    bench.put(0x100C, 10).put(0x100D, 3).put(0x6007, QUICK_STOP).put(0x605A, 6).enabled(PP)
    assert bench.send("705#R")[0] == "705#05"
    bench.after(29)
    assert bench.send("705#R")[0] == "705#85"
    assert bench.cycles(1).status(0x6F) == 0x27
    bench.after(31)
    assert bench.cycles(1).status(0x6F) == 0x07
