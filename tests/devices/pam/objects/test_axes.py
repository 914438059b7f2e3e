"""Axes: orders to the node, what is known of their positions, and set-points of a pipe."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pam_objects import Bench
from pam_programs import HEADER

from fieldrig_devices.pam.objects.readings import ObjectReadings
from fieldrig_devices.pamring.frames import (
    AxisItem,
    AxisOrder,
    AxisReport,
    EndOfPipe,
    Move,
    SetPoint,
    SetPointMode,
)

TURN = 1 << 32
AXES = (
    HEADER
    + """
NODE NOD_Belt; ADDRESS = 1; TYPE = ST1; END
NODE NOD_Station; NUMBER = 2; ADDRESS = 2; TYPE = ST1; END
AXIS AXI_Belt; NODE = NOD_Belt; PULSES_PER_UNIT = 11930464.7111111111; TRAVEL_SPEED = 3600; ACCELERATION = 36000;
  INITIAL_POSITION = 30; POSITION_PERIOD = 360; END
AXIS AXI_Station; NODE = NOD_Station; PULSES_PER_UNIT = -100; TRAVEL_SPEED = 10; ACCELERATION = 20; DECELERATION = 40;
  INITIAL_POSITION = 0; POSITION_RANGE = -5 5; END
TMP_GENERATOR TMP_Master; TRAVEL_SPEED = 360; ACCELERATION = 3600; INITIAL_POSITION = 100; POSITION_PERIOD = 360;
  PERIOD = 0.001; ANTI_DELAY = NO; END
TMP_GENERATOR TMP_Other; TRAVEL_SPEED = 360; ACCELERATION = 3600; INITIAL_POSITION = 5; POSITION_PERIOD = 360;
  PERIOD = 0.001; ANTI_DELAY = NO; END
CONVERTER CNV_Belt; DESTINATION = AXI_Belt; MODE = POSITION; END
CONVERTER CNV_Other; DESTINATION = AXI_Belt; MODE = POSITION; END
CONVERTER CNV_Speed; DESTINATION = AXI_Belt; MODE = SPEED; END
CONVERTER CNV_Torque; DESTINATION = AXI_Belt; MODE = TORQUE; END
"""
)


@pytest.fixture
def bench() -> Bench:
    found = Bench(AXES)
    found.st1(1, 2, 3)
    return found


def order(bench: Bench, address: int = 1) -> AxisOrder:
    found = bench.sent(address)[-1]
    assert isinstance(found, AxisOrder)
    return found


@pytest.mark.manual("PAML-040")
@pytest.mark.manual("PAML-043")
@pytest.mark.manual("PAML-045")
def test_a_node_gets_its_axis_in_resolver_units(bench: Bench) -> None:
    assert [node.items for node in bench.objects.nodes] == [
        [AxisItem(1, round(TURN / 12), TURN)],
        [AxisItem(1, 0, 0)],
        [AxisItem(1, 0, 0)],
    ]
    assert bench.ask("AXI_Belt", "position") == 30


@pytest.mark.manual("PAML-064")
@pytest.mark.manual("PAMS-018")
@pytest.mark.manual("PAML-058")
@pytest.mark.manual("PAML-056")
@pytest.mark.manual("PAMS-014")
@pytest.mark.manual("PAMS-012")
@pytest.mark.manual("PAML-052")
@pytest.mark.manual("PAML-046")
@pytest.mark.parametrize(
    ("function", "arguments", "expected"),
    [
        ("absolute_move", (2.5,), AxisOrder(1, Move.ABSOLUTE_MOVE, -250, 1000, 2000, 4000)),
        ("relative_move", (-1,), AxisOrder(1, Move.RELATIVE_MOVE, 100, 1000, 2000, 4000)),
        ("run", (4,), AxisOrder(1, Move.RUN, -400, 400, 2000, 4000)),
        ("stop", (), AxisOrder(1, Move.STOP, 0, 0, 2000, 4000)),
        ("power_on", (), AxisOrder(1, Move.POWER_ON)),
        ("power_off", (), AxisOrder(1, Move.POWER_OFF, 0, 0, 2000, 4000)),
        ("position", (3,), AxisOrder(0, Move.POSITION, -300)),
        ("update_status", (), AxisOrder(0, Move.UPDATE_STATUS)),
    ],
)
def test_orders(bench: Bench, function: str, arguments: tuple[float, ...], expected: AxisOrder) -> None:
    bench.item("AXI_Station", 1).do(function, arguments)
    assert bench.port.sent == [(3, expected)]


@pytest.mark.parametrize("function", ["absolute_move", "relative_move", "run", "position"])
def test_numbers_that_no_frame_carries_are_limited(bench: Bench, function: str) -> None:
    for number in (1e300, -1e300):
        bench.do("AXI_Belt", function, number)
        assert order(bench).value == (1 << 62 if number > 0 else -(1 << 62))


@pytest.mark.parametrize("gain", [1e17, 1e308, -1e308])
def test_an_overflow_in_a_pipe_is_a_fault(gain: float) -> None:
    amplifier = "AMPLIFIER AMP_a; GAIN = 1; OFFSET = 0; GAIN_SLOPE = MAX; OFFSET_SLOPE = MAX; END\n"
    bench = Bench(AXES + amplifier)
    bench.connect("CNV_Belt", "AMP_a", "TMP_Master")
    bench.item("AMP_a").set_parameter("GAIN", gain)
    bench.do("TMP_Master", "position", 359)
    bench.cycle(2)
    assert bench.kernel.reports[0] == ("02..FFF3", ())
    assert not any(abs(value) > 1 << 62 for value in bench.set_points(1))


@pytest.mark.manual("PAML-049")
@pytest.mark.manual("PAML-050")
@pytest.mark.manual("PAML-051")
def test_new_limits_hold_for_the_next_motion_and_zero_is_ignored(bench: Bench) -> None:
    for axis in bench.objects.items["AXI_Station"]:
        for parameter in ("TRAVEL_SPEED", "ACCELERATION", "DECELERATION"):
            axis.set_parameter(parameter, 0)
            axis.set_parameter(parameter, -7)
        axis.set_parameter("ACCELERATION", 30)
    assert bench.port.sent == []
    bench.do("AXI_Station", "relative_move", 1)
    assert order(bench, 2) == AxisOrder(1, Move.RELATIVE_MOVE, -100, 1000, 3000, 4000)
    assert bench.item("AXI_Station").parameter("DECELERATION") == 40


@pytest.mark.manual("PAML-059")
@pytest.mark.manual("PAMS-033")
def test_an_axis_is_ready_when_its_last_physical_order_is_done(bench: Bench) -> None:
    assert bench.ask("AXI_Belt", "ready")
    bench.do("AXI_Belt", "relative_move", 360)
    bench.cycle(5)
    bench.do("AXI_Belt", "update_status")
    assert not bench.ask("AXI_Belt", "ready")
    bench.do("AXI_Belt", "relative_move", 1)
    bench.objects.on_report(1, AxisReport(2, 0, 1, 0))  # the first one is done, the second under way
    assert not bench.ask("AXI_Belt", "ready")
    bench.until(lambda: bool(bench.ask("AXI_Belt", "ready")))
    assert "AXI_Belt" in bench.kernel.touched_names
    bench.do("AXI_Belt", "position", 7)
    assert bench.ask("AXI_Belt", "ready")


@pytest.mark.manual("PAMS-030")
@pytest.mark.manual("PAMS-010")
@pytest.mark.manual("PAML-061")
def test_a_turn_takes_0_2_s_and_its_destination_is_known_at_once(bench: Bench) -> None:
    bench.do("AXI_Belt", "position", 0)
    bench.do("AXI_Belt", "relative_move", 720)
    assert bench.ask("AXI_Belt", "generator_position") == 0  # two turns
    bench.do("AXI_Belt", "absolute_move", 360)
    cycles = bench.until(lambda: bool(bench.ask("AXI_Belt", "ready")))
    assert cycles == pytest.approx(200, abs=3)  # 0.1 s up, 0.1 s down
    assert bench.ask("AXI_Belt", "position") == pytest.approx(0, abs=1e-6)


@pytest.mark.manual("PAML-062")
def test_a_run_is_ended_by_a_stop_and_the_node_tells_where(bench: Bench) -> None:
    bench.do("AXI_Belt", "run", 360)
    bench.until(lambda: bool(bench.ask("AXI_Belt", "ready")))
    bench.cycle(500)
    bench.do("AXI_Belt", "run", 0)
    bench.until(lambda: bool(bench.ask("AXI_Belt", "ready")))
    assert bench.ask("AXI_Belt", "position") == pytest.approx(bench.nodes[1].position / TURN * 360 % 360)


@pytest.mark.manual("PAML-055")
@pytest.mark.manual("PAMS-013")
def test_power_on_makes_the_position_zero(bench: Bench) -> None:
    bench.do("AXI_Belt", "power_on")
    assert bench.ask("AXI_Belt", "position") == 0


@pytest.mark.manual("PAMS-010")
def test_an_absolute_move_is_the_numeric_difference_or_the_shorter_way() -> None:
    for readings, target in ((ObjectReadings(), 10), (ObjectReadings(takes_shorter_way=True), 370)):
        bench = Bench(AXES, readings=readings)
        bench.do("AXI_Belt", "position", 350)
        bench.do("AXI_Belt", "absolute_move", 10)
        assert order(bench).value == pytest.approx(target / 360 * TURN, abs=1)
        assert bench.ask("AXI_Belt", "generator_position") == 10


@pytest.mark.manual("PAMS-054")
@pytest.mark.manual("PAMS-035")
@pytest.mark.manual("PAMS-029")
@pytest.mark.manual("PAML-060")
@pytest.mark.manual("PAMS-049")
@pytest.mark.manual("PAMS-055")
def test_status_and_errors_of_a_report(bench: Bench) -> None:
    assert not bench.ask("AXI_Belt", "error")
    bench.objects.on_report(1, AxisReport(1 | 16, 0x2F07_0000, 0, 0))
    assert bench.ask("AXI_Belt", "status") == 17
    assert [bench.ask("AXI_Belt", "status", mask) for mask in (16, 2)] == [True, False]
    assert not bench.ask("AXI_Belt", "error")  # none of these bits is an error
    bench.objects.on_report(1, AxisReport(1, 0x9080_0010, 0, 0))
    assert bench.ask("AXI_Belt", "error")
    assert bench.ask("AXI_Belt", "error_code") == 0x9080_0010
    assert [bench.ask("AXI_Belt", "error_code", mask) for mask in (0x10, 0x20)] == [True, False]


@pytest.mark.manual("PAML-405")
@pytest.mark.manual("PAML-482")
@pytest.mark.manual("PAML-485")
@pytest.mark.manual("PAML-404")
def test_a_pipe_moves_the_axis_to_its_first_value(bench: Bench) -> None:
    bench.connect("CNV_Belt", "TMP_Master")
    assert (bench.ask("CNV_Belt", "ready"), bench.ask("AXI_Belt", "position")) == (False, 30)
    bench.cycle()
    assert (bench.ask("CNV_Belt", "ready"), bench.ask("AXI_Belt", "position")) == (True, 100)
    bench.cycle(10)
    assert bench.sent(1) == [SetPoint(SetPointMode.POSITION, round(TURN * 100 / 360))]  # no change, no frame


@pytest.mark.manual("PAML-047")
@pytest.mark.manual("PAML-044")
def test_no_rounding_of_a_period_adds_up() -> None:
    """A period of 3.7 resolver units, so that each of them ends between two units."""
    bench = Bench(AXES.replace("PULSES_PER_UNIT = 11930464.7111111111", "PULSES_PER_UNIT = 0.010277777777777778"))
    bench.item("TMP_Master").set_parameter("INITIAL_POSITION", 0)
    bench.connect("CNV_Belt", "TMP_Master")
    bench.cycle(2)
    for name in ("ACCELERATION", "DECELERATION"):
        bench.item("TMP_Master").set_parameter(name, 1e9)
    bench.do("TMP_Master", "run", 36_000)
    bench.cycle(1000)
    bench.do("TMP_Master", "run", 0)
    bench.cycle(5)
    assert bench.set_points(1)[-1] == pytest.approx(100 * 3.7, abs=1)
    assert bench.ask("AXI_Belt", "position") == pytest.approx(bench.ask("TMP_Master", "position"))


@pytest.mark.manual("PAML-063")
@pytest.mark.manual("PAMS-031")
def test_a_pipe_is_motionless_one_cycle_after_its_last_set_point(bench: Bench) -> None:
    bench.connect("CNV_Belt", "TMP_Master")
    bench.cycle(2)
    assert bench.ask("AXI_Belt", "pipe_motionless")
    bench.do("TMP_Master", "relative_move", 180)
    seen = []
    while not bench.ask("TMP_Master", "ready"):
        bench.cycle(work=lambda: seen.append(bench.ask("AXI_Belt", "pipe_motionless")))
    assert not any(seen)
    bench.kernel.touched_names.clear()
    bench.cycle()
    assert bench.ask("AXI_Belt", "pipe_motionless")
    assert "AXI_Belt" in bench.kernel.touched_names
    bench.do("CNV_Belt", "disactivate")
    assert bench.ask("AXI_Belt", "position") == pytest.approx(280)
    assert bench.nodes[1].position == pytest.approx(280 / 360 * TURN, abs=1)


@pytest.mark.manual("PAML-042")
@pytest.mark.manual("PAML-053")
@pytest.mark.manual("PAML-054")
def test_moves_are_superimposed_on_the_pipe(bench: Bench) -> None:
    bench.connect("CNV_Belt", "TMP_Master")
    bench.cycle(2)
    bench.do("TMP_Master", "run", 36)
    bench.do("AXI_Belt", "relative_move", 10)
    bench.until(lambda: bool(bench.ask("AXI_Belt", "ready")))
    assert bench.ask("AXI_Belt", "generator_position") == pytest.approx(10)
    assert bench.ask("AXI_Belt", "position") == pytest.approx(bench.ask("TMP_Master", "position") + 10, abs=0.04)
    assert bench.ask("AXI_Belt", "speed") == pytest.approx(36)  # of the pipe alone
    bench.do("AXI_Belt", "absolute_move", -20)
    bench.until(lambda: bool(bench.ask("AXI_Belt", "ready")))
    assert bench.ask("AXI_Belt", "position") == pytest.approx(bench.ask("TMP_Master", "position") - 20, abs=0.04)
    bench.do("CNV_Belt", "disactivate")
    bench.cycle()
    assert bench.nodes[1].position == pytest.approx(bench.ask("AXI_Belt", "position") / 360 * TURN, abs=2)


@pytest.mark.manual("PAML-057")
@pytest.mark.manual("PAMS-017")
def test_a_stop_disconnects_the_pipe(bench: Bench) -> None:
    bench.connect("CNV_Belt", "TMP_Master")
    bench.cycle(2)
    bench.do("TMP_Master", "run", 360)
    bench.cycle(200)
    bench.do("AXI_Belt", "stop")
    assert order(bench).move is Move.STOP
    count = len(bench.port.sent)
    bench.cycle(20)
    assert len(bench.port.sent) == count
    assert bench.ask("AXI_Belt", "speed") == 0
    bench.do("CNV_Belt", "disactivate")
    assert len(bench.port.sent) == count  # the pipe has ended for this axis already


@pytest.mark.manual("PAML-407")
def test_another_pipe_to_the_same_axis_replaces_the_first(bench: Bench) -> None:
    bench.connect("CNV_Belt", "TMP_Master")
    bench.cycle(2)
    bench.connect("CNV_Other", "TMP_Other")
    bench.cycle(2)
    assert bench.set_points(1) == [round(TURN * 100 / 360), round(TURN * 5 / 360)]
    assert not any(isinstance(order, EndOfPipe) for order in bench.sent(1))
    assert (bench.ask("CNV_Belt", "ready"), bench.ask("CNV_Other", "ready")) == (False, True)
    assert bench.ask("TMP_Master", "position") == 0  # its last pipe has ended
    bench.do("CNV_Belt", "disactivate")
    assert bench.ask("AXI_Belt", "position") == 5


@pytest.mark.manual("PAML-486")
@pytest.mark.manual("PAML-406")
@pytest.mark.manual("PAML-483")
@pytest.mark.manual("PAMS-022")
def test_a_speed_leaves_the_position_and_ends_at_zero(bench: Bench) -> None:
    bench.item("TMP_Master").set_parameter("INITIAL_POSITION", 0)
    bench.connect("CNV_Speed", "TMP_Master")
    bench.cycle(2)
    assert (bench.set_points(1), bench.ask("AXI_Belt", "position")) == ([0], 30)
    bench.do("TMP_Master", "position", 90)
    bench.cycle(100)
    assert bench.sent(1)[-1] == SetPoint(SetPointMode.SPEED, TURN // 4)
    assert bench.ask("AXI_Belt", "speed") == 90
    assert bench.ask("AXI_Belt", "position") == pytest.approx(39)  # 90 u/s for 0.1 s
    bench.do("CNV_Speed", "disactivate")
    assert bench.sent(1)[-1] == EndOfPipe(SetPointMode.SPEED)


@pytest.mark.manual("PAML-480")
@pytest.mark.manual("PAML-484")
def test_a_torque_is_a_limit(bench: Bench) -> None:
    bench.item("TMP_Master").set_parameter("INITIAL_POSITION", 2.5)
    bench.connect("CNV_Torque", "TMP_Master")
    bench.cycle(2)
    bench.do("TMP_Master", "position", 20)
    bench.cycle()
    assert bench.set_points(1) == [250, 1000]  # of a motor of 10 Nm
    bench.connect("CNV_Belt", "TMP_Master")
    bench.cycle()
    assert bench.sent(1)[-2:] == [
        EndOfPipe(SetPointMode.TORQUE),
        SetPoint(SetPointMode.POSITION, round(TURN * 20 / 360)),
    ]


STEPS = st.lists(
    st.tuples(
        st.sampled_from(["absolute_move", "relative_move", "position", "run", "stop", "pipe", "end"]),
        st.floats(-1000, 1000),
    ),
    min_size=1,
    max_size=8,
)


@pytest.mark.long
@pytest.mark.manual("PAML-042")
@settings(max_examples=40, deadline=None)
@given(STEPS)
def test_the_position_is_that_of_the_node_after_any_orders(steps: list[tuple[str, float]]) -> None:
    bench = Bench(AXES.replace("ACCELERATION = 3600;", "ACCELERATION = 360000;"))
    bench.st1(1)
    bench.do("AXI_Belt", "position", 30)  # the node begins at 0
    bench.cycle()
    for function, argument in steps:
        if function == "pipe":
            bench.connect("CNV_Belt", "TMP_Master")
            bench.cycle(2)
            bench.do("TMP_Master", "relative_move", argument / 10)
            bench.until(lambda: bool(bench.ask("TMP_Master", "ready")))
        elif function == "end":
            bench.do("CNV_Belt", "disactivate")
        elif function == "stop":
            bench.do("AXI_Belt", "stop")
        else:
            bench.do("AXI_Belt", function, argument)
        bench.until(lambda: bool(bench.ask("AXI_Belt", "ready")))
        bench.cycle(3)
        if function == "run":
            bench.do("AXI_Belt", "run", 0)
            bench.until(lambda: bool(bench.ask("AXI_Belt", "ready")))
        difference = bench.nodes[1].position / TURN * 360 - bench.ask("AXI_Belt", "position")
        assert difference - 360 * round(difference / 360) == pytest.approx(0, abs=1e-5)


@pytest.mark.manual("PAML-062")
def test_a_report_from_before_the_end_of_a_pipe_does_not_move_the_position(bench: Bench) -> None:
    bench.connect("CNV_Belt", "TMP_Master")
    bench.cycle(5)
    bench.do("AXI_Belt", "relative_move", 10)
    number = order(bench).number
    bench.do("CNV_Belt", "disactivate")
    assert bench.ask("AXI_Belt", "position") == pytest.approx(110)
    bench.objects.on_report(1, AxisReport(1, 0, number, round(TURN / 36)))
    assert bench.ask("AXI_Belt", "ready")
    assert bench.ask("AXI_Belt", "position") == pytest.approx(110)


@pytest.mark.long
@pytest.mark.manual("PAML-059")
def test_no_order_has_the_number_of_the_one_before_even_after_65535_others(bench: Bench) -> None:
    bench.do("AXI_Belt", "run", 1)
    number = order(bench).number
    for _ in range(65534):
        bench.do("AXI_Station", "run", 1)
    bench.do("AXI_Belt", "run", 2)
    assert order(bench).number != number
    bench.objects.on_report(1, AxisReport(4, 0, number, 0))
    assert not bench.ask("AXI_Belt", "ready")
