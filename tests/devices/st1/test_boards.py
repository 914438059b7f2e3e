"""The I/O boards of an ST1: addresses, levels, debounce, time stamps, and what a missing board does."""

import pytest
from st1_bench import ProgramBench

from fieldrig_devices.pamring import frames


def input_at(address: int, *, item: int = 1, bits: int = 1, period_ms: int = 10, debounce: int = 3) -> frames.InputItem:
    return frames.InputItem(item, address, bits, True, period_ms, debounce)


@pytest.fixture
def bench() -> ProgramBench:
    """An ST1 whose input 201 alone has time stamps, as in D.2 of the manual."""
    return ProgramBench(power=False, readings={"time_stamps": "IN16"})


@pytest.mark.manual("PAMS-110", "PAML-084")
def test_the_addresses_of_inputs(bench: ProgramBench) -> None:
    accepted = [address for address in range(1, 1700) if bench.program.accept(input_at(address))]
    assert accepted == [101, 102, *range(201, 217)]


@pytest.mark.manual("PAMS-110", "PAML-101")
def test_the_addresses_of_outputs(bench: ProgramBench) -> None:
    accepted = [address for address in range(1, 1700) if bench.program.accept(frames.OutputItem(1, address, 1, True))]
    assert accepted == list(range(201, 209))


@pytest.mark.manual("PAML-085", "PAML-102")
@pytest.mark.parametrize(
    "item",
    [
        input_at(201, bits=2),
        frames.OutputItem(1, 201, 2, True),
        input_at(201, period_ms=0),
        input_at(201, debounce=0),
        frames.CounterItem(1, 201, True, 1, 1),
        frames.KeyItem(1, 201, True, frames.KeyMode.ON_OFF, 10),
        frames.AnalogItem(1, 1),
        frames.LedItem(1, 1),
        frames.SevenSegmentItem(1, 1, 1),
        frames.MotorItem(1, 2, 3, 4, 5, 100, 10),
    ],
    ids=lambda item: type(item).__name__,
)
def test_what_an_st1_has_not_is_refused(bench: ProgramBench, item: frames.InputItem) -> None:
    assert not bench.program.accept(item)


@pytest.mark.manual("PAML-082", "PAML-083")
def test_a_level_counts_after_equal_samples(bench: ProgramBench) -> None:
    bench.program.boards.put(0, True)
    assert bench.program.accept(input_at(101, item=5))
    bench.take(frames.InputChanged)
    bench.program.run()
    assert bench.take(frames.InputChanged) == [frames.InputChanged(5, 1)]
    bench.wait(2)
    bench.program.boards.put(0, False)  # seen by the samples at 10, 20 and 30 ms
    bench.wait(27.9)
    assert bench.take(frames.InputChanged) == []
    bench.wait(0.2)
    assert bench.take(frames.InputChanged) == [frames.InputChanged(5, 0)]


def test_an_input_that_bounces_counts_once_it_holds(bench: ProgramBench) -> None:
    assert bench.program.accept(input_at(102))
    bench.program.run()
    bench.take(frames.InputChanged)
    for ms, level in ((3, True), (12, False), (24, True)):
        bench.run_to(ms)
        bench.program.boards.put(1, level)
    bench.run_to(49.9)
    assert not bench.port.sent
    bench.run_to(50)
    assert bench.take(frames.InputChanged) == [frames.InputChanged(1, 1)]


@pytest.mark.manual("PAMS-110", "PAML-203")
@pytest.mark.parametrize(("address", "age_us"), [(201, 27_750), (202, 0)])
def test_only_input_201_says_when_it_changed(bench: ProgramBench, address: int, age_us: int) -> None:
    number = address - 185
    assert bench.program.accept(input_at(address))
    bench.program.run()
    bench.take(frames.InputChanged)
    bench.run_to(2.25)
    bench.program.boards.put(number, True)  # the samples at 10, 20 and 30 ms
    bench.run_to(12.25)
    bench.program.boards.put(number, False)
    bench.run_to(12.5)
    bench.program.boards.put(number, True)  # no sample has seen that it was away
    bench.run_to(40)
    assert bench.take(frames.InputChanged) == [frames.InputChanged(1, 1, age_us)]


@pytest.mark.manual("PAMS-110")
@pytest.mark.parametrize(("cacout", "level"), [(0xFF, False), (0x00, True)])
def test_cacout_gives_the_levels_before_the_pam_does(cacout: int, level: bool) -> None:
    bench = ProgramBench(power=False, parameters={"cacout": cacout})
    assert bench.outputs == dict.fromkeys(range(8, 16), level)


@pytest.mark.manual("PAML-101")
@pytest.mark.parametrize("is_active_high", [True, False])
def test_an_output_is_inactive_until_it_is_set(bench: ProgramBench, is_active_high: bool) -> None:
    assert bench.program.accept(frames.OutputItem(9, 203, 1, is_active_high))
    assert bench.outputs[10] is not is_active_high
    levels = []
    for level in (1, 0, 1):
        bench.send(frames.SetOutput(9, level))
        levels.append(bench.outputs[10])
    bench.program.forget()
    assert [*levels, bench.outputs[10]] == [True, False, True, False]


@pytest.mark.parametrize(
    "order",
    [frames.SetOutput(77, 1), frames.Blink(77, True), frames.Display(77, 65), frames.MotorOrder(77, frames.Motor.STOP)],
    ids=repr,
)
def test_an_order_for_an_item_that_is_not_there(bench: ProgramBench, order: frames.SetOutput) -> None:
    bench.send(order)
    assert bench.take(frames.Trouble) == [frames.Trouble(frames.Severity.WARNING, 0x00C, (0x0B, 77))]


@pytest.mark.manual("PAMS-110")
def test_a_missing_board_floods_the_pam() -> None:
    bench = ProgramBench(power=False, oio_board=False)
    assert bench.outputs == {}
    assert bench.program.accept(input_at(216, period_ms=1))
    assert bench.program.accept(input_at(101, item=2, period_ms=1))
    bench.program.run()
    bench.take(frames.InputChanged)
    bench.wait(50)
    assert [change.item for change in bench.take(frames.InputChanged)] == [1] * 50


def test_inputs_that_hold_cost_nothing(bench: ProgramBench) -> None:
    assert bench.program.accept(input_at(101, period_ms=1))
    bench.program.run()
    assert bench.clock.next_ns() is None
