"""Zero positioners with an axis that carries out their orders."""

import pytest
from pam_objects import Bench
from pam_programs import HEADER

from fieldrig_devices.motion.profile import Limits
from fieldrig_devices.pam.objects.readings import ObjectReadings
from fieldrig_devices.pamring.frames import AxisOrder, AxisReport, InputChanged, Move, Read
from fieldrig_devices.pamring.registers import Parameter, parameter_address

TURN = 1 << 32
AXIS = """
NODE NOD_Main; ADDRESS = 1; TYPE = ST1; END
AXIS AXI_Main; NODE = NOD_Main; PULSES_PER_UNIT = 11930464.71111111; TRAVEL_SPEED = 720; ACCELERATION = 36000;
  DECELERATION = 72000; INITIAL_POSITION = 0; POSITION_PERIOD = 360; END
BINARY_INPUT SBI_Sensor; NODE = NOD_Main; ADDRESS = 201; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
TMP_GENERATOR TMP_Main; TRAVEL_SPEED = 1; ACCELERATION = 1; INITIAL_POSITION = 0; POSITION_RANGE = 0 1;
  PERIOD = 0.001; END
CONVERTER CNV_Main; DESTINATION = AXI_Main; MODE = POSITION; END
ZERO_POSITIONER ZEP_Main; OBJECT = AXI_Main; SENSOR = SBI_Sensor;
"""
SENSOR = 2
"""The sensor's item; the axis is item 1."""
A_CYCLE_LATE = ObjectReadings(report_delay_cycles=1)
RESOLVER = "RESOLVER_OFFSET = 100;"
COARSE = "COARSE_SPEED = 3600; COARSE_EDGE = RISING; COARSE_MOVE = 0.0;"
FINE = "FINE_SPEED = -90; FINE_EDGE = FALLING; FINE_MOVE = 30;"


def started(phases: str) -> Bench:
    bench = Bench(f"{HEADER}{AXIS}{phases} END\n", readings=A_CYCLE_LATE)
    bench.st1(1)
    bench.cycle()
    bench.cycle(work=lambda: bench.do("ZEP_Main", "start"))
    return bench


def degrees(bench: Bench) -> float:
    return bench.nodes[1].position / TURN * 360


def edge(bench: Bench, value: int, age_us: int = 0) -> float:
    """Let the sensor change now, and return the angle at that; the PAM has the report a cycle later."""
    found = degrees(bench)
    bench.cycle()
    bench.report(1, InputChanged(SENSOR, value, age_us))
    bench.cycle()
    return found


def moves(bench: Bench, address: int = 1) -> list[Move]:
    return [order.move for order in bench.sent(address) if isinstance(order, AxisOrder)]


@pytest.mark.manual("PAML-202")
@pytest.mark.manual("PAML-203")
@pytest.mark.manual("PAML-204")
@pytest.mark.manual("PAML-208")
@pytest.mark.manual("PAML-209")
@pytest.mark.manual("PAML-211")
def test_the_example_of_the_manual() -> None:
    bench = started(COARSE + RESOLVER)
    bench.cycle(150)
    assert not bench.ask("ZEP_Main", "ready")
    seen = edge(bench, 1)
    farthest, cycles = 0.0, 0
    while bench.nodes[1].done != bench.nodes[1].number:
        farthest = max(farthest, degrees(bench) - seen)
        bench.cycle()
        cycles += 1
    assert farthest == pytest.approx(90, abs=4)  # 90 degrees of stopping, and the way of a period at 3600 degrees/s
    assert degrees(bench) == pytest.approx(seen, abs=0.01)  # and back to the edge
    assert cycles == pytest.approx(50 + 140, abs=10)
    bench.nodes[1].registers[0] = 65536 * 5 + 65536 * 50 // 360
    bench.until(lambda: bool(bench.ask("ZEP_Main", "ready")))
    assert Read(3, 0) in bench.sent(1)
    assert moves(bench) == [Move.RUN, Move.RELATIVE_MOVE, Move.RELATIVE_MOVE, Move.POSITION]
    assert bench.sent(1)[-2].value == pytest.approx(50 / 360 * TURN, rel=1e-3)  # type: ignore[union-attr]
    assert bench.ask("AXI_Main", "position") == 0


@pytest.mark.manual("PAML-202")
@pytest.mark.manual("PAML-203")
def test_the_edge_is_found_on_the_ramp_and_counted_from_its_instant() -> None:
    bench = started(COARSE.replace("COARSE_MOVE = 0.0", "COARSE_MOVE = 200"))
    bench.cycle(40)
    seen = degrees(bench)
    bench.cycle(10)
    edge(bench, 1, age_us=10_000)
    bench.until(lambda: bench.nodes[1].done == bench.nodes[1].number)
    assert degrees(bench) == pytest.approx(seen + 200, abs=0.01)


def test_the_limits_of_the_node_count() -> None:
    """At 3 turns/s and 20 turns/s2 the axis is far behind its declaration."""
    bench = Bench(
        f"{HEADER}{AXIS}{COARSE.replace('COARSE_MOVE = 0.0', 'COARSE_MOVE = 300')} END\n", readings=A_CYCLE_LATE
    )
    bench.st1(1)
    bench.nodes[1].limits = Limits(3 * TURN, 20 * TURN, 20 * TURN)
    for code, turns in ((Parameter.CKV, 3), (Parameter.CKA, 20)):
        bench.nodes[1].registers[parameter_address(code)] = turns * 65536
    bench.cycle(3)
    bench.cycle(work=lambda: bench.do("ZEP_Main", "start"))
    for cycles in (90, 200):  # on the ramp, and at the speed
        bench.cycle(cycles)
        seen = degrees(bench)
        bench.cycle(10)
        edge(bench, 1, age_us=10_000)
        bench.until(lambda: bench.nodes[1].done == bench.nodes[1].number)
        assert degrees(bench) == pytest.approx(seen + 300, abs=0.01)
        bench.until(lambda: bool(bench.ask("ZEP_Main", "ready")))
        bench.change(1, SENSOR, 0)
        bench.cycle(work=lambda: bench.do("ZEP_Main", "start"))


@pytest.mark.manual("PAML-205")
def test_no_move_only_stops() -> None:
    bench = started(COARSE.replace("COARSE_MOVE = 0.0", "COARSE_MOVE = NONE"))
    bench.cycle(150)
    edge(bench, 1)
    bench.until(lambda: bool(bench.ask("ZEP_Main", "ready")))
    assert moves(bench) == [Move.RUN, Move.STOP, Move.POSITION]


@pytest.mark.manual("PAML-206")
def test_the_current_speed_is_that_of_the_axis() -> None:
    bench = started(COARSE.replace("3600", "CURRENT"))
    run = next(order for order in bench.sent(1) if isinstance(order, AxisOrder))
    assert run.value == round(720 / 360 * TURN)


@pytest.mark.manual("PAML-200")
@pytest.mark.manual("PAML-201")
def test_the_fine_phase_follows_with_its_own_edge() -> None:
    bench = Bench(f"{HEADER}{AXIS}{COARSE}{FINE} END\n", readings=A_CYCLE_LATE)
    bench.st1(1)
    bench.cycle()
    bench.item("ZEP_Main").set_parameter("FINE_SPEED", -180)
    bench.item("ZEP_Main").set_parameter("COARSE_MOVE", "NONE")
    bench.cycle(work=lambda: bench.do("ZEP_Main", "start"))
    bench.cycle(20)
    edge(bench, 1)
    bench.until(lambda: moves(bench)[-1] is Move.RUN)
    fine = bench.sent(1)[-1]
    assert isinstance(fine, AxisOrder)
    assert fine.value == round(-180 / 360 * TURN)
    bench.cycle(20)
    seen = edge(bench, 0)
    bench.until(lambda: bench.nodes[1].done == bench.nodes[1].number)
    assert degrees(bench) == pytest.approx(seen + 30, abs=0.01)
    bench.until(lambda: bool(bench.ask("ZEP_Main", "ready")))


@pytest.mark.manual("PAML-207")
def test_six_positioners_at_most_are_in_the_fine_phase() -> None:
    text = HEADER
    for n in range(1, 9):
        text += AXIS.replace("ADDRESS = 1;", f"ADDRESS = {n};").replace("_Main", f"_{n}").replace("_Sensor", f"_S{n}")
        text += f"{FINE} END\n"
    bench = Bench(text)
    bench.st1(*range(1, 9))

    def start() -> None:
        for n in range(1, 9):
            bench.do(f"ZEP_{n}", "start")

    bench.cycle(work=start)
    assert [n for n in range(1, 9) if moves(bench, n)] == [1, 2, 3, 4, 5, 6]
    bench.do("ZEP_8", "stop")  # out of the line
    bench.change(3, SENSOR, 1)
    bench.change(3, SENSOR, 0)
    bench.cycle(400)
    assert bench.ask("ZEP_3", "ready")
    assert moves(bench, 7) == [Move.RUN]
    bench.do("ZEP_1", "stop")
    assert moves(bench, 8) == [Move.STOP]


@pytest.mark.manual("PAML-210")
def test_nothing_starts_while_a_pipe_drives_the_axis() -> None:
    bench = Bench(f"{HEADER}{AXIS}{COARSE} END\n")
    bench.connect("CNV_Main", "TMP_Main")
    bench.cycle()
    count = len(bench.port.sent)
    bench.do("ZEP_Main", "start")
    assert bench.ask("ZEP_Main", "ready")
    assert len(bench.port.sent) == count


@pytest.mark.manual("PAMS-016")
@pytest.mark.manual("PAMS-017")
def test_a_stop_ends_the_phases() -> None:
    bench = started(COARSE + RESOLVER)
    bench.cycle(10)
    bench.do("ZEP_Main", "stop")
    bench.until(lambda: bool(bench.ask("ZEP_Main", "ready")))
    edge(bench, 1)
    bench.cycle(10)
    assert moves(bench) == [Move.RUN, Move.STOP]


@pytest.mark.manual("PAML-212")
def test_a_positioner_of_each_axis() -> None:
    text = AXIS.replace("NODE NOD_Main;", "NODE NOD_Main; NUMBER = 2;").replace("OBJECT", "NUMBER = 2; OBJECT")
    bench = Bench(f"{HEADER}{text}{COARSE} END\n")
    bench.st1(1, 2)
    bench.item("ZEP_Main", 1).do("start")
    bench.cycle(5)
    bench.change(1, SENSOR, 1)
    bench.cycle()
    assert moves(bench) == []
    bench.change(2, SENSOR, 1)
    bench.cycle()
    assert moves(bench, 2) == [Move.RUN, Move.RELATIVE_MOVE]


@pytest.mark.manual("PAML-204")
def test_an_edge_and_the_end_of_the_run_in_one_cycle_are_not_the_end_of_the_move_after_it() -> None:
    bench = started(COARSE)
    run = [order for order in bench.sent(1) if isinstance(order, AxisOrder)][-1]
    bench.objects.on_report(1, InputChanged(SENSOR, 1))
    bench.objects.on_report(1, AxisReport(4, 0, run.number, 0))
    bench.cycle()
    assert moves(bench) == [Move.RUN, Move.RELATIVE_MOVE]
    assert not bench.ask("ZEP_Main", "ready")
