"""The faults of a card: the codes of the digest (chapter 10.3), what the program and the axes do, and the way back."""

from arp_bench import SERVO_AXIS, CardBench

from fieldrig_devices.arp.card_access import CardState

CLOSED_LOOP = {"axis1": {**SERVO_AXIS, 7: 1_000, 8: 5_000, 14: 20}}
WATCH = "LOOP:\nV1 += 1\nV2 == ERROR\nGOTO LOOP"


def closed_again(bench: CardBench) -> CardBench:
    return bench.drive("I108", False).run_for(100).drive("I108", True).run_for(100)


def test_a_program_that_stops_is_e11_until_enable_is_opened_and_closed() -> None:
    bench = CardBench("SET O101\n" + WATCH).run_for(100)
    number = bench.card.add_fault({"what": "program_stopped", "start_ms": 50})
    assert (bench.run_for(40).error, bench.state) == (0, CardState.RUN)
    bench.run_for(40)
    assert (bench.error, bench.state, bench.get("O101")) == (111, CardState.BLOCKED, False)
    assert closed_again(bench).error == 111, "it stops again while the fault lasts"
    bench.card.clear_fault(number)
    assert bench.run_for(100).state is CardState.BLOCKED
    assert (closed_again(bench).error, bench.state) == (0, CardState.RUN)


def test_a_memory_that_fails_is_e03_at_the_next_access() -> None:
    bench = CardBench(WATCH).run_for(100)
    number = bench.card.add_fault({"what": "memory"})
    assert bench.run_for(100).error == 0
    assert not bench.access.save_parameters({(1, 7): 500_000})
    assert (bench.error, bench.state) == (103, CardState.BLOCKED)
    assert closed_again(bench).error == 103
    bench.card.clear_fault(number)
    assert (closed_again(bench).error, bench.state) == (0, CardState.RUN)
    assert bench.access.save_parameters({(1, 7): 500_000})


def test_an_axis_without_its_encoder_is_e16_and_the_program_reads_it() -> None:
    bench = CardBench("PVC 1, 50\n" + WATCH, CLOSED_LOOP)
    servo = bench.add_servo(1)
    bench.run_for(1_000)
    bench.card.add_fault({"what": "encoder_signal", "axis": 1, "duration_ms": 300})
    bench.run_for(1)
    shown = bench.get("axis1.position")
    before = servo.points()["position"].read()
    bench.run_for(100)
    assert (bench.error, bench.get("error_axis"), bench.variable(2), bench.state) == (116, 1, 116, CardState.RUN)
    assert bench.get("axis1.position") == shown
    assert servo.points()["position"].read() != before
    assert bench.last_sent("dac1") == 0.0


def test_counts_that_the_card_has_missed_are_lost() -> None:
    bench = CardBench(WATCH, {"axis1": {4: 0}}).run_for(100)
    bench.drive("encoder1", 100).run_for(10)
    bench.card.add_fault({"what": "encoder_signal", "axis": 1, "duration_ms": 20})
    bench.run_for(5).drive("encoder1", 150).run_for(30)
    assert bench.get("axis1.position") == 100
    bench.drive("encoder1", 160).run_for(10)
    assert bench.get("axis1.position") == 110
