"""Programs of the manual on a whole card, with simulated motors where they need them (digest 19)."""

import pytest
from arp_bench import SERVO_AXIS, CardBench, Groups
from arp_listings import EXAMPLE2, EXEMPLE1, TEST_PID

from fieldrig_bus.wires import Motion
from fieldrig_devices.arp.card_access import CardState

LOOP = "\nLOOP:\nGOTO LOOP"
SYNCHRONOUS, ARRIVED_2 = 261, 292
PST_AXES: Groups = {
    "axis1": {**SERVO_AXIS, 7: 6_000, 8: 50_000, 14: 100, 24: 5_000, 25: 10},
    "axis2": {7: 5_000, 8: 50_000},
}


@pytest.mark.manual("ARP-095", "ARP-096")
def test_positions_are_what_the_program_says_to_the_last_decimal() -> None:
    bench = CardBench("PAC 1, 12.345\nPRC 1, V2\nPAC 2, V1\nPRC 2, -0.001" + LOOP, {"axis1": {4: 1}, "axis2": {4: 1}})
    bench.put_variable(1, -7.501)
    bench.put_variable(2, 0.002)
    bench.run_for(1_000)
    assert (bench.position(1), bench.position(2)) == (12.347, -7.502)


# ---- A14: two cam switches and two events on an encoder that is only read


def sweep(bench: CardBench, to: int, ms: int) -> None:
    """Move the encoder to a position."""
    start = bench.position(1)
    now_ns = bench.clock.now_ns()
    bench.wires.deliver(Motion("card1.encoder1", start, "count", now_ns, (to - start) / ms * 1_000))
    bench.run_for(ms)
    bench.drive("encoder1", to).run_for(2)


@pytest.mark.manual("ARP-001", "ARP-004", "ARP-112")
def test_a14_cams_work_in_their_direction_only() -> None:
    bench = CardBench(EXEMPLE1).drive("encoder1", 0).run_for(50)
    bench.wires.take()
    sweep(bench, 20_000, 1_000)
    up = [(signal.name, signal.value) for signal in bench.wires.take()]
    sweep(bench, 0, 1_000)
    down = [(signal.name, signal.value) for signal in bench.wires.take()]
    assert up == [("card1.O101", True), ("card1.O101", False)]
    assert down == [("card1.O102", True), ("card1.O102", False)]
    sweep(bench, 10_000, 500)
    assert bench.last_sent("O101") is True
    assert bench.variable(1) == 10_000


@pytest.mark.manual("ARP-004", "ARP-087")
def test_a14_events_are_served_once_when_they_are_enabled() -> None:
    bench = CardBench(EXEMPLE1).drive("encoder1", 0).run_for(50)
    sweep(bench, 6_000, 100)
    assert bench.last_sent("O103") is False  # F2 is low
    bench.set("F2", True)
    bench.run_for(2)
    assert (bench.last_sent("O103"), bench.get("F2")) == (True, False)
    bench.set("O103", False)
    bench.run_for(100)
    assert bench.last_sent("O103") is False
    bench.set("F3", True)
    bench.run_for(5)
    bench.set("F4", True)
    bench.run_for(5)
    assert (bench.last_sent("O104"), bench.get("F3")) == (True, False)


# ---- A15: the electronic cam, master simulated, slave a motor


@pytest.mark.long
@pytest.mark.manual("ARP-002", "ARP-004", "ARP-101", "ARP-104")
def test_a15_the_slave_follows_its_simulated_master() -> None:
    bench = CardBench(EXAMPLE2, PST_AXES)
    bench.add_servo(1)
    bench.run_for(1_005)
    assert bench.access.F[SYNCHRONOUS] == 0
    bench.run_for(10)
    assert bench.access.F[SYNCHRONOUS] == 1  # the slave is at rest at 0, where the table begins
    while bench.position(2) == 0:
        bench.run_for(1)
    began_ns = bench.clock.now_ns() - 1_000_000
    trajectory: dict[float, float] = {}
    while bench.access.F[295]:
        trajectory[bench.position(2)] = bench.position(1)
        bench.run_for(1)
        assert bench.access.F[SYNCHRONOUS] == 1
    assert (bench.clock.now_ns() - began_ns) / 1e9 == pytest.approx(2.1, abs=0.002)
    assert (bench.position(2), bench.position(1)) == (10_000.0, 0.0)
    assert max(trajectory.values()) == pytest.approx(4_750, abs=1)
    nearest = min(trajectory, key=lambda master: abs(master - 2_500))
    assert trajectory[nearest] == pytest.approx(nearest, abs=0.001)


@pytest.mark.long
@pytest.mark.manual("ARP-004", "ARP-105")
def test_a15_it_runs_on_and_on() -> None:
    bench = CardBench(EXAMPLE2, PST_AXES)
    bench.add_servo(1)
    bench.run_for(2_000)
    turns = errors = 0
    was_at_end = False
    for _ in range(1_000):  # 100 s
        bench.run_for(100)
        assert bench.access.F[SYNCHRONOUS] == 1
        errors = max(errors, abs(bench.access.tracking_error(1)))
        is_at_end = bench.position(2) == 10_000
        turns += is_at_end and not was_at_end
        was_at_end = is_at_end
        bench.wires.take()
    assert (bench.state, bench.error) == (CardState.RUN, 0)
    assert turns == 100_000 // 6_400 + 1  # 2.1 s in each direction, a second's rest, and the dwell at each end
    assert errors < 20_000  # units, of a slave that accelerates with 50000 units/s2


# ---- A16: the tension regulator


@pytest.mark.manual("ARP-004", "ARP-113")
def test_a16_the_regulator_is_in_reset_until_it_is_started() -> None:
    bench = CardBench(TEST_PID, {"general": {2: 1}}, inputs={"I108": True, "adc1": 0.002})
    for number, value in {50: 1_000, 52: 100_000, 54: 0.1, 57: 0.001, 58: 100, 59: 5, 60: -5}.items():
        bench.put_variable(number, value)  # REFPID, DELTAR, KMIS, KERR, MAXERR, MAXPID, MINPID
    for number, value in {61: 1, 62: 1, 63: 8, 64: -8, 65: 0.5}.items():
        bench.put_variable(number, value)  # KREG, KOUT, MAXDAC, MINDAC, OFFDAC
    bench.run_for(1_000)
    assert (bench.access.F[306], bench.access.F[305], bench.last_sent("dac2")) == (1, 1, 0.5)
    assert bench.variable(10) == 2_000  # microvolts
    assert bench.variable(68) == pytest.approx(200)  # DG_MIS
    assert bench.last_sent("dac1") == pytest.approx(200 / 50)
    bench.set("F303", True)
    bench.run_for(1_000)
    assert (bench.access.F[306], bench.access.F[305]) == (1, 0)
    assert bench.last_sent("dac2") == pytest.approx(0.8, abs=0.001)  # KP 1 of (1000 - 200) * 0.001


# ---- A19: what PST refuses

TABLE = "V10 == 3\nV11 == 0\nV12 == 0\nV13 == 5000\nV14 == 5000\nV15 == 10000\nV16 == 0\n"


@pytest.mark.manual("ARP-050", "ARP-103")
@pytest.mark.parametrize(
    "wrong",
    [
        "PST 1, 2, V10",
        "V10 == 1\nPST 2, 1, V10",
        "V10 == 23\nPST 2, 1, V10",
        "V13 == 0\nPST 2, 1, V10",
        "@PAR1[24] == 6001\nPST 2, 1, V10",  # k = 1: 6001 of at most 6000 units/s
        "@PAR1[8] == 4000\nPST 2, 1, V10",  # a join of 12500 in segments of 5000
    ],
)
def test_a19_each_cause_of_e13(wrong: str) -> None:
    axes = {"axis1": {4: 1, 7: 6_000, 8: 50_000, 24: 5_000}, "axis2": {4: 1}}
    bench = CardBench(f"{TABLE}{wrong}\nV1 == ERROR\nLOOP:\nV2 += 1\nGOTO LOOP", axes).run_for(100)
    assert (bench.variable(1), bench.error, bench.state) == (113, 113, CardState.RUN)
    assert bench.access.F[SYNCHRONOUS] == 0
    assert bench.variable(2) > 0


def test_a19_a_table_that_is_right_has_no_error() -> None:
    axes = {"axis1": {4: 1, 7: 6_000, 8: 50_000, 24: 5_000}, "axis2": {4: 1}}
    bench = CardBench(f"{TABLE}PST 2, 1, V10\nV1 == ERROR{LOOP}", axes).run_for(100)
    assert (bench.variable(1), bench.access.F[SYNCHRONOUS]) == (0, 1)


# ---- A21, A24


@pytest.mark.manual("ARP-098")
def test_a21_a_second_move_waits_for_the_end_of_the_first() -> None:
    bench = CardBench("PAC 1, 100\nV1 == 1\nPAC 1, 0\nV1 == 2" + LOOP, {"axis1": {4: 1, 7: 100, 8: 1_000}}).run_for(500)
    assert (bench.variable(1), bench.line) == (1, 4)
    while bench.access.F[263] and bench.position(1) < 100:
        assert (bench.line, bench.variable(1)) == (4, 1)
        bench.run_for(1)
    assert bench.clock.now_ns() == pytest.approx(1.11e9, abs=5e6)  # 0.1 + 0.9 + 0.1 s
    bench.run_for(3)
    assert bench.variable(1) == 2


@pytest.mark.manual("ARP-002", "ARP-046", "ARP-050")
def test_a24_a_motor_that_is_blocked_is_e16_and_the_program_goes_on() -> None:
    program = "PVC 1, 50\nLOOP:\nV1 += 1\nV2 == ERROR\nGOTO LOOP"
    bench = CardBench(program, {"axis1": {**SERVO_AXIS, 7: 1_000, 8: 5_000, 14: 20}})
    servo = bench.add_servo(1)
    bench.run_for(1_000)
    assert (bench.error, bench.access.F[264]) == (0, 1)
    assert bench.get("axis1.speed") == pytest.approx(500, abs=5)
    block = servo.points()["blocked"].write
    assert block is not None
    block(True)
    bench.run_for(30)
    assert bench.error == 0  # 15 units
    bench.run_for(30)
    assert (bench.error, bench.get("error_axis"), bench.state) == (116, 1, CardState.RUN)
    assert bench.last_sent("dac1") == 0.0
    count = bench.variable(1)
    bench.run_for(10)
    assert (bench.variable(1) > count, bench.variable(2)) == (True, 116)


@pytest.mark.long
@pytest.mark.manual("ARP-002")
def test_a_motor_goes_where_pac_says() -> None:
    bench = CardBench(
        "PAC 1, 1500\nWAIT 5\nPAC 1, -500" + LOOP, {"axis1": {**SERVO_AXIS, 7: 2_000, 8: 20_000, 16: 0.5}}
    )
    servo = bench.add_servo(1)
    bench.run_for(4_000)
    assert bench.access.F[260] == 1
    assert servo.points()["position"].read() == pytest.approx(1.5 * 2 * 3.14159265, abs=0.001)
    bench.run_for(4_000)
    assert servo.points()["encoder"].read() == pytest.approx(-0.5 * 40_000, abs=3)
