"""Manual chapter 10, figure by figure: who sees what, when.  BrakeCouplingTime is 50 ms, StopTimeLim 1000 ms."""

from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mc4_bench import ChainBench, Line

from fieldrig.clock import MS
from fieldrig_devices.mc4.diagnosis import Code
from fieldrig_devices.mc4.enable import LIFTED, SETTLED, TASKS, Stage, Times

CONTROLLED = Line(0, True, True, True, 3, 0x21, 0)


def ramp(from_rpm: float, stands_after_ms: int) -> Callable[[int], float]:
    return lambda ms: max(0.0, from_rpm * (1 - ms / stands_after_ms)) if ms < stands_after_ms else 0.0


def enable_off(bench: ChainBench) -> None:
    bench.controller = False


def inverter_enable_off(bench: ChainBench) -> None:
    bench.hardware = False


def error_b(bench: ChainBench) -> None:
    bench.diagnosis.raise_(Code.DC_BUS_CONTROLLER)


def two_errors_b(bench: ChainBench) -> None:
    error_b(bench)
    bench.look()
    bench.run(500)
    bench.diagnosis.raise_(Code.MOTOR_TEMPERATURE)


def error_a(bench: ChainBench) -> None:
    bench.diagnosis.raise_(Code.ENCODER_MEMORY)


def overload(bench: ChainBench) -> None:
    bench.diagnosis.raise_(Code.OVERLOAD)


def overload_reached_at(ms: int) -> Callable[[ChainBench], None]:
    def act(bench: ChainBench) -> None:
        overload(bench)
        bench.look()
        bench.run(ms)
        bench.is_at_overload_position = True

    return act


FROM_1000 = 1000.0
STANDING: Callable[[int], float] = lambda ms: 0.0  # noqa: E731  (a row of the table below)
SLOW = ramp(FROM_1000, 600)  # below 10 rpm after 594 ms
VERY_SLOW = ramp(FROM_1000, 1800)  # after 1782 ms
NEVER: Callable[[int], float] = lambda ms: FROM_1000 if ms < 4000 else 0.0  # noqa: E731

# brake closed, torque, ready, AxisState, MC4State, code; each from its ms on
COURSES = [
    pytest.param(
        enable_off, SLOW, Times(),
        [
            Line(0, True, True, True, 4, 0x40, 0),
            Line(595, False, True, True, 4, 0x41, 0),
            Line(645, False, False, True, 1, 0x10, 0),
        ],
        id="10.2.1 stops within StopTimeLim", marks=pytest.mark.manual("PD-151"),
    ),
    pytest.param(
        inverter_enable_off, SLOW, Times(),
        [
            Line(0, True, True, True, 4, 0x40, 0),
            Line(595, False, True, True, 4, 0x41, 0),
            Line(645, False, False, True, 0, 0x03, 0),
        ],
        id="10.2.1 by Inverter Enable", marks=[pytest.mark.manual("PD-151"), pytest.mark.manual("PD-162")],
    ),
    pytest.param(
        enable_off, VERY_SLOW, Times(),
        [
            Line(0, True, True, True, 4, 0x40, 0),
            Line(1000, True, True, False, 4, 0x40, 2190),
            Line(1783, False, True, False, 4, 0x41, 2190),
            Line(1833, False, False, False, 5, 0x02, 2190),
        ],
        id="10.2.2 StopTimeLim passed, controlled", marks=pytest.mark.manual("PD-152"),
    ),
    pytest.param(
        enable_off, NEVER, Times(),
        [
            Line(0, True, True, True, 4, 0x40, 0),
            Line(1000, True, True, False, 4, 0x40, 2190),
            Line(2000, False, True, False, 4, 0x41, 2190),
            Line(2050, False, False, False, 4, 0x42, 2190),
            Line(4000, False, False, False, 5, 0x02, 2190),
        ],
        id="10.2.3 never stops in time", marks=pytest.mark.manual("PD-153"),
    ),
    pytest.param(
        error_b, SLOW, Times(),
        [
            Line(0, True, True, False, 4, 0x40, 2106),
            Line(595, False, True, False, 4, 0x41, 2106),
            Line(645, False, False, False, 5, 0x02, 2106),
        ],
        id="10.3.1 reaction B, stops in time", marks=pytest.mark.manual("PD-154"),
    ),
    pytest.param(
        error_b, NEVER, Times(),
        [
            Line(0, True, True, False, 4, 0x40, 2106),
            Line(1000, False, True, False, 4, 0x41, 2106),
            Line(1050, False, False, False, 4, 0x42, 2106),
            Line(4000, False, False, False, 5, 0x02, 2106),
        ],
        id="10.3.2 reaction B, one limit only", marks=pytest.mark.manual("PD-155"),
    ),
    pytest.param(
        two_errors_b, NEVER, Times(),
        [
            Line(0, True, True, False, 4, 0x40, 2106),
            Line(1000, False, True, False, 4, 0x41, 2106),
            Line(1050, False, False, False, 4, 0x42, 2106),
            Line(4000, False, False, False, 5, 0x02, 2106),
        ],
        id="10.3.2 a second error B doesn't restart the limit", marks=pytest.mark.manual("PD-155"),
    ),
    pytest.param(
        error_a, SLOW, Times(),
        [Line(0, False, False, False, 4, 0x42, 1117), Line(595, False, False, False, 5, 0x02, 1117)],
        id="10.4 reaction A in motion", marks=pytest.mark.manual("PD-156"),
    ),
    pytest.param(
        error_a, STANDING, Times(),
        [Line(0, False, False, False, 4, 0x42, 1117), Line(50, False, False, False, 5, 0x02, 1117)],
        id="10.4 reaction A standing: BrakeCouplingTime", marks=pytest.mark.manual("PD-156"),
    ),
    pytest.param(
        error_a, SLOW, Times(brake_coast=True),
        [
            Line(0, True, False, False, 4, 0x42, 1117),
            Line(595, False, False, False, 4, 0x42, 1117),
            Line(645, False, False, False, 5, 0x02, 1117),
        ],
        id="10.4 CoastOption for the brake", marks=pytest.mark.manual("PD-157"),
    ),
    pytest.param(
        enable_off, SLOW, Times(enable_coast=True),
        [Line(0, False, False, False, 4, 0x42, 0), Line(595, False, False, False, 5, 0x02, 0)],
        id="10.4 bEnableCoast", marks=pytest.mark.manual("PD-158"),
    ),
    pytest.param(
        error_b, SLOW, Times(error_coast=True, brake_coast=True),
        [
            Line(0, True, False, False, 4, 0x42, 2106),
            Line(595, False, False, False, 4, 0x42, 2106),
            Line(645, False, False, False, 5, 0x02, 2106),
        ],
        id="10.4 bErrorCoast and the brake", marks=pytest.mark.manual("PD-158"),
    ),
    pytest.param(
        overload_reached_at(700), SLOW, Times(),
        [Line(0, True, True, True, 4, 0x30, 3125), Line(700, True, True, True, 4, 0x32, 3125)],
        id="10.5.1 overload position reached", marks=pytest.mark.manual("PD-159"),
    ),
    pytest.param(
        overload, ramp(FROM_1000, 1200), Times(),
        [
            Line(0, True, True, True, 4, 0x30, 3125),
            Line(800, True, True, False, 4, 0x40, 2191),
            Line(1189, False, True, False, 4, 0x41, 2191),
            Line(1239, False, False, False, 5, 0x02, 2191),
        ],
        id="10.5.2 800 ms passed", marks=pytest.mark.manual("PD-160"),
    ),
    pytest.param(
        inverter_enable_off, SLOW, Times(safe_stop_coasts=True),
        [Line(0, False, False, False, 4, 0x42, 0), Line(595, False, False, False, 5, 0x02, 0)],
        id="safe stop takes the torque at once, if configured so", marks=pytest.mark.manual("PD-162"),
    ),
]  # fmt: skip


@pytest.mark.parametrize(("act", "speed", "times", "course"), COURSES)
def test_course(
    act: Callable[[ChainBench], None], speed: Callable[[int], float], times: Times, course: list[Line]
) -> None:
    bench = ChainBench(times)
    bench.start()
    bench.speed = speed
    assert bench.trace == [CONTROLLED]
    bench.trace.clear()
    act(bench)
    bench.look()
    bench.run(5000 - bench.ms)
    assert bench.trace == course


@pytest.mark.manual("PD-155")
def test_passed_limit_of_a_stop_by_error_b_is_reported_beside_the_error() -> None:
    bench = ChainBench()
    bench.start()
    bench.speed = NEVER
    error_b(bench)
    bench.look()
    bench.run(999)
    assert set(bench.diagnosis.pending) == {Code.DC_BUS_CONTROLLER}
    bench.run(1)
    assert set(bench.diagnosis.pending) == {Code.DC_BUS_CONTROLLER, Code.STOP_TIME_LIMIT}
    assert bench.diagnosis.code == 2106


@pytest.mark.manual("PD-150")
def test_switching_on() -> None:
    bench = ChainBench(hardware=False, controller=False)
    bench.run(9)
    bench.hardware = True
    bench.run(10)
    bench.controller = True
    bench.run(200)
    assert bench.trace == [
        Line(0, False, False, True, 0, 0x03, 0),
        Line(10, False, False, True, 1, 0x10, 0),
        Line(20, True, True, True, 2, 0x20, 0),
        Line(120, True, True, True, 3, 0x21, 0),  # BrakeDisconnectionTime
    ]


@pytest.mark.manual("PD-150")
def test_dc_circuit_that_is_not_charged_holds_it_up() -> None:
    bench = ChainBench(can_start=False)
    bench.run(500)
    assert bench.stage() is Stage.WAITING
    bench.can_start = True
    bench.run(1)
    assert bench.stage() is Stage.LIFTING


@pytest.mark.manual("PD-150")
@pytest.mark.parametrize("code", [Code.ENCODER_MEMORY, Code.DC_BUS_CONTROLLER])
def test_error_holds_it_up(code: Code) -> None:
    bench = ChainBench()
    bench.controller = False
    bench.diagnosis.raise_(code)
    bench.controller = True
    bench.run(500)
    assert (bench.stage(), bench.chain.has_torque, bench.chain.is_ready) == (Stage.STOPPED, False, False)


@pytest.mark.manual("PD-150")
def test_enable_lifted_while_the_brake_lifts() -> None:
    bench = ChainBench()
    bench.run(40)
    bench.controller = False
    bench.run(100)
    assert [(line.at_ms, line.mc4_state) for line in bench.trace] == [(0, 0x20), (41, 0x41), (91, 0x10)]


@pytest.mark.manual("PD-156", "PD-100")
def test_after_reaction_a_it_starts_again_when_quitted() -> None:
    bench = ChainBench()
    bench.start()
    error_a(bench)
    bench.run(500)
    assert bench.chain.mc4_state == 0x02
    assert bench.quit()
    assert bench.stage() is Stage.LIFTING
    bench.run(100)
    assert bench.stage() is Stage.CONTROLLED


@pytest.mark.manual("PD-156")
def test_not_quitted_while_it_still_turns() -> None:
    bench = ChainBench()
    bench.start()
    bench.speed = NEVER
    error_a(bench)
    bench.run(500)
    assert not bench.quit()
    assert bench.diagnosis.code == 1117


@pytest.mark.manual("PD-159", "PD-100")
def test_follows_the_set_values_again_after_a_quitted_overload() -> None:
    bench = ChainBench()
    bench.start()
    overload(bench)
    bench.run(100)
    assert not bench.quit()
    bench.is_at_overload_position = True
    bench.run(1)
    assert bench.chain.mc4_state == 0x32
    assert bench.quit()
    assert bench.stage() is Stage.CONTROLLED


@pytest.mark.manual("PD-159")
def test_overload_stop_ends_with_the_enable() -> None:
    bench = ChainBench()
    bench.start()
    overload(bench)
    bench.run(100)
    bench.controller = False
    bench.run(100)
    assert bench.stage() is Stage.STOPPED
    assert bench.quit()
    bench.controller = True
    bench.run(101)
    assert bench.stage() is Stage.CONTROLLED


@pytest.mark.manual("PD-160")
def test_overload_that_does_not_stop_at_all() -> None:
    bench = ChainBench()
    bench.start()
    bench.speed = NEVER
    overload(bench)
    bench.run(5000)
    seen = [(line.at_ms, line.mc4_state) for line in bench.trace[2:]]
    assert seen == [(800, 0x40), (1800, 0x41), (1850, 0x42), (4000, 0x02)]
    assert set(bench.diagnosis.pending) == {Code.OVERLOAD, Code.OVERLOAD_STOP_TIME, Code.STOP_TIME_LIMIT}


@pytest.mark.manual("PD-158")
def test_after_coasting_the_next_enable_starts_it() -> None:
    bench = ChainBench(Times(enable_coast=True))
    bench.start()
    bench.controller = False
    bench.run(1000)
    assert bench.chain.mc4_state == 0x02
    bench.controller = True
    bench.run(1)
    assert bench.stage() is Stage.LIFTING


def test_an_error_a_on_the_way_down_takes_the_torque() -> None:
    bench = ChainBench()
    bench.start()
    bench.speed = SLOW
    error_b(bench)
    bench.run(100)
    error_a(bench)
    bench.run(1)
    assert (bench.stage(), bench.diagnosis.code) == (Stage.COASTING, 1117)


@pytest.mark.manual("PD-162")
def test_no_start_without_inverter_enable() -> None:
    bench = ChainBench(hardware=False)
    bench.run(1000)
    assert (bench.stage(), bench.chain.is_brake_lifted) == (Stage.NO_HARDWARE_ENABLE, False)


def test_every_stage_has_its_task_and_own_state() -> None:
    assert set(TASKS) == set(Stage)
    assert len({stage.value[1] for stage in Stage}) == len(Stage)
    assert set(Stage) >= LIFTED | SETTLED


def test_times_count_from_their_own_event() -> None:
    bench = ChainBench(Times(brake_disconnection_ns=30 * MS, brake_coupling_ns=20 * MS, stop_limit_ns=200 * MS))
    bench.start()
    bench.speed = NEVER
    bench.controller = False
    bench.run(1000)
    assert [line.at_ms for line in bench.trace] == [0, 1, 201, 401, 421]


def changes(bench: ChainBench) -> list[tuple[int, int, bool, bool]]:
    """When, MC4State, brake relay, torque."""
    return [(line.at_ms, line.mc4_state, line.brake_closed, line.torque) for line in bench.trace]


@pytest.mark.manual("PD-154")
def test_an_error_b_does_not_lift_a_brake_that_has_dropped() -> None:
    """It comes within BrakeCouplingTime and doesn't extend it; it can be acknowledged only after that."""
    bench = ChainBench()
    bench.start()
    bench.controller = False
    bench.run(30)
    error_b(bench)
    bench.run(100)
    assert changes(bench)[1:] == [
        (1, 0x41, False, True),
        (31, 0x41, False, True),
        (51, 0x02, False, False),
    ]


@pytest.mark.manual("PD-156")
def test_an_error_a_at_standstill_changes_nothing_but_the_code() -> None:
    bench = ChainBench()
    bench.start()
    error_b(bench)
    bench.run(500)
    assert bench.chain.mc4_state == 0x02
    error_a(bench)
    bench.look()
    assert (bench.chain.mc4_state, bench.diagnosis.code) == (0x02, 1117)


@pytest.mark.manual("PD-157")
def test_coasting_does_not_lift_a_brake_that_has_dropped() -> None:
    """Reaction A within BrakeCouplingTime, with the option for the brake."""
    bench = ChainBench(Times(brake_coast=True))
    bench.start()
    bench.controller = False
    bench.run(20)
    bench.speed = NEVER
    error_a(bench)
    bench.run(500)
    assert changes(bench)[-1] == (21, 0x42, False, False)


@pytest.mark.manual("PD-159")
def test_overload_while_the_brake_lifts_is_stopped_and_to_be_quitted() -> None:
    bench = ChainBench(is_at_overload_position=True)
    bench.run(40)
    overload(bench)
    bench.run(200)
    assert [state for _, state, _, _ in changes(bench)] == [0x20, 0x32]
    assert bench.quit()
    assert bench.stage() is Stage.CONTROLLED


@pytest.mark.manual("PD-162")
def test_safe_stop_may_coast_while_controller_enable_still_ramps_down() -> None:
    for act, state in ((enable_off, 0x40), (inverter_enable_off, 0x42)):
        bench = ChainBench(Times(safe_stop_coasts=True))
        bench.start()
        bench.speed = SLOW
        act(bench)
        bench.run(1)
        assert bench.chain.mc4_state == state


@pytest.mark.manual("PD-158", "PD-162")
def test_after_coasting_both_enables_are_needed_to_leave_0x02() -> None:
    bench = ChainBench(Times(enable_coast=True))
    bench.start()
    bench.hardware = False
    bench.run(1000)
    assert bench.chain.mc4_state == 0x02
    bench.hardware = True
    bench.run(1)
    assert bench.stage() is Stage.LIFTING


EVENTS: dict[str, Callable[[ChainBench], object]] = {
    "enable": lambda bench: setattr(bench, "controller", True),
    "disable": enable_off,
    "inverter enable": lambda bench: setattr(bench, "hardware", True),
    "no inverter enable": inverter_enable_off,
    "A": error_a,
    "B": error_b,
    "overload": overload,
    "at overload position": lambda bench: setattr(bench, "is_at_overload_position", True),
    "quit": ChainBench.quit,
    "turning": lambda bench: setattr(bench, "speed", lambda ms: FROM_1000),
    "standing": lambda bench: setattr(bench, "speed", STANDING),
}


@pytest.mark.long
@pytest.mark.manual("PD-150", "PD-156", "PD-161")
@settings(max_examples=150, deadline=None)
@given(
    st.lists(st.tuples(st.sampled_from(sorted(EVENTS)), st.integers(0, 120)), max_size=12),
    st.builds(Times, enable_coast=st.booleans(), error_coast=st.booleans(), brake_coast=st.booleans()),
)
def test_no_order_of_events_is_unsafe_or_a_dead_end(events: list[tuple[str, int]], times: Times) -> None:
    bench = ChainBench(times)
    for event, ms in events:
        EVENTS[event](bench)
        for _ in range(ms):
            bench.run(1)
            chain, pending = bench.chain, bench.diagnosis.pending
            assert not (chain.has_torque and Code.ENCODER_MEMORY in pending), "reaction A takes the torque"
            assert not (chain.is_ready and bench.diagnosis.code in range(1000, 3000)), "its contact opens with A and B"
            assert chain.has_torque or not chain.is_brake_lifted or times.brake_coast, "no torque: the brake drops"
            assert chain.stage is not Stage.CONTROLLED or (bench.hardware and bench.controller)
    for event in ("standing", "at overload position", "enable", "inverter enable"):
        EVENTS[event](bench)
    bench.run(3_000)
    bench.quit()
    bench.run(200)
    assert (bench.stage(), bench.diagnosis.code) == (Stage.CONTROLLED, 0)
