"""The node's program on the ring: items that cannot be, the heap, wrong orders, the FIFO, and a node at rest."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from smart_io_bench import RecordedPort, SmartIoBench

from fieldrig.clock import MS
from fieldrig_devices.pamring.ends import NodeProgram
from fieldrig_devices.pamring.frames import (
    AnalogItem,
    Answer,
    AxisItem,
    AxisOrder,
    Blink,
    Configuration,
    CounterItem,
    Display,
    InputChanged,
    InputItem,
    KeyItem,
    KeyMode,
    LedItem,
    Motor,
    MotorOrder,
    Move,
    Order,
    OutputItem,
    Read,
    SetOutput,
    SevenSegmentItem,
    Severity,
    Trouble,
)

KEY = KeyMode.ON_OFF
WRONG: list[Configuration] = [
    InputItem(1, 100, 1, True, 1, 1), InputItem(1, 113, 1, True, 1, 1), InputItem(1, 301, 1, True, 1, 1),
    InputItem(1, 209, 5, True, 1, 1), InputItem(1, 101, 0, True, 1, 1), InputItem(1, 101, 1, True, 0, 1),
    InputItem(1, 101, 1, True, 1, 0), CounterItem(1, 213, True, 1, 1), OutputItem(1, 208, 6, True),
    OutputItem(1, 1612, 1, True), KeyItem(1, 25, False, KEY, 50), KeyItem(1, 0, False, KEY, 50),
    KeyItem(1, 113, True, KEY, 50), LedItem(1, 25), LedItem(1, 0), AnalogItem(1, 2), SevenSegmentItem(1, 1, 2),
    SevenSegmentItem(1, 2, 1),
]  # fmt: skip


def test_the_program_is_what_the_ring_expects() -> None:
    program: NodeProgram = SmartIoBench().program
    assert program is not None


@pytest.mark.manual("PAMS-105")
@pytest.mark.manual("PAMS-111")
@pytest.mark.parametrize("item", WRONG, ids=repr)
def test_an_item_that_can_not_be_is_refused(item: Configuration) -> None:
    bench = SmartIoBench()
    bench.configure()
    assert not bench.program.accept(item)
    bench.order(SetOutput(1, 1))
    assert [trouble.details for trouble in bench.troubles()] == [(0x0B, 0)], "there is no such item"


@pytest.mark.manual("PAMS-051")
def test_an_item_of_another_node_is_of_an_unknown_type() -> None:
    bench = SmartIoBench()
    bench.program.attach(bench.port)
    bench.program.forget()
    assert not bench.program.accept(AxisItem(1, 0, 0))
    assert bench.port.take() == [Trouble(Severity.WARNING, 0x00C, (0x0C, 0), word=0x08_0000)]


@pytest.mark.manual("PAMS-105")
def test_there_are_no_more_analog_outputs_and_displays_than_the_hardware_has() -> None:
    bench = SmartIoBench()
    bench.configure(AnalogItem(1, 1), SevenSegmentItem(2, 1, 1))
    assert not bench.program.accept(AnalogItem(3, 1))
    assert not bench.program.accept(SevenSegmentItem(4, 1, 1))
    bare = SmartIoBench(keyboard="006.7010")
    bare.configure(LedItem(1, 6))
    assert not bare.program.accept(SevenSegmentItem(2, 1, 1))
    none = SmartIoBench(keyboard="none", terminals={})
    none.configure()
    assert not none.program.accept(LedItem(1, 6))


def test_an_item_that_comes_again_replaces_the_first_one() -> None:
    bench = SmartIoBench()
    bench.configure(OutputItem(1, 105, 1, True), OutputItem(1, 106, 1, True))
    bench.order(SetOutput(1, 1))
    assert (bench.get("out105"), bench.get("out106")) == (False, True)


@pytest.mark.manual("PAMS-112")
@pytest.mark.manual("PAMS-051")
def test_a_configuration_that_is_too_large_is_a_heap_overflow() -> None:
    bench = SmartIoBench(heap_bytes=256)
    bench.program.attach(bench.port)
    bench.program.forget()
    accepted = [bench.program.accept(InputItem(number, 101, 1, True, 1, 1)) for number in range(1, 8)]
    assert accepted == [True] * 5 + [False] * 2, "48 bytes each"
    assert bench.get("display") == "F 3"
    assert bench.port.take() == [Trouble(Severity.WARNING, 0x00C, (0x01, 0), word=0x1)]
    bench.program.forget()
    assert bench.get("display") == "8."
    assert bench.get("error_word") == 0


def test_everything_that_a_node_can_have_fits_into_its_heap() -> None:
    bench = SmartIoBench(modules={number: {} for number in range(1, 17)}, key_count=32, led_count=32)
    addresses = [100 * module + position for module in range(1, 17) for position in range(1, 13)]
    items: list[Configuration] = [AnalogItem(1, 1), SevenSegmentItem(2, 1, 1)]
    items += [InputItem(1_000 + address, address, 1, True, 1, 1) for address in addresses]
    items += [OutputItem(3_000 + address, address, 1, True) for address in addresses]
    items += [KeyItem(5_000 + number, number, False, KEY, 50) for number in range(1, 33)]
    items += [LedItem(6_000 + number, number) for number in range(1, 33)]
    bench.configure(*items)
    assert bench.get("error_word") == 0


@pytest.mark.manual("PAMS-051")
@pytest.mark.manual("PAMS-105")
@pytest.mark.parametrize(
    ("order", "code", "bit"),
    [
        (AxisOrder(1, Move.POWER_ON), 0x09, 0x01_0000),
        (Blink(1, True), 0x0A, 0x02_0000),
        (Display(1, 0x41), 0x0A, 0x02_0000),
        (MotorOrder(1, Motor.STOP), 0x0A, 0x02_0000),
        (SetOutput(2, 1), 0x0A, 0x02_0000),
        (SetOutput(9, 1), 0x0B, 0x04_0000),
    ],
)
def test_a_wrong_order_is_a_warning_that_ends_by_itself(order: Order, code: int, bit: int) -> None:
    bench = SmartIoBench()
    bench.configure(OutputItem(1, 105, 1, True), InputItem(2, 103, 1, True, 1, 1))
    bench.order(order, order)
    assert bench.port.take() == [Trouble(Severity.WARNING, 0x00C, (code, 0), word=bit)], "once"
    assert bench.get("error_word") == bit
    bench.run(999)
    assert bench.port.take() == []
    bench.run(1)
    assert bench.port.take() == [Trouble(Severity.ENDED, 0x00C, (code, 0))]


@pytest.mark.manual("PAMS-112")
def test_too_many_commands_in_a_cycle_fill_fifo_6_and_those_are_lost() -> None:
    bench = SmartIoBench()
    bench.configure(OutputItem(1, 105, 1, True))
    for value in range(300):
        bench.order(SetOutput(1, value & 1))
    bench.order(Read(7, 1))
    assert bench.port.take() == [Trouble(Severity.WARNING, 0x00C, (0x02, 6), word=0x2)], "the read is not answered"
    assert bench.get("display") == "E 6"
    bench.run(1_000)
    bench.order(Read(8, 1))
    assert Answer(8, None) in bench.port.take()
    assert bench.get("display") == " "


def test_twenty_commands_in_each_millisecond_are_never_too_many() -> None:
    bench = SmartIoBench()
    bench.configure(OutputItem(1, 105, 1, True))
    for _ in range(1_000):
        bench.order(*[SetOutput(1, 1)] * 20)
        bench.run(1)
    assert bench.port.take() == []


def test_a_full_fifo_takes_twenty_commands_a_millisecond_later() -> None:
    bench = SmartIoBench()
    bench.configure(OutputItem(1, 105, 1, True))
    bench.run(1_000)
    bench.order(*[SetOutput(1, 1)] * 256)
    assert bench.port.take() == []
    bench.run(1)
    bench.order(*[SetOutput(1, 1)] * 20)
    assert bench.port.take() == []
    bench.order(SetOutput(1, 0))
    assert (len(bench.troubles()), bench.get("out105")) == (1, True)


def test_the_items_are_gone_after_forget() -> None:
    bench = SmartIoBench()
    bench.configure(InputItem(1, 103, 1, True, 1, 1), OutputItem(2, 105, 1, True))
    bench.program.forget()
    bench.wire("button", True)
    bench.run(10)
    assert bench.port.take() == []
    assert bench.clock.next_ns() is None


@pytest.mark.manual("PAML-093")
def test_a_cycle_of_a_node_at_rest_reports_nothing() -> None:
    bench = SmartIoBench(modules={number: {} for number in range(1, 17)}, terminals={})
    bench.configure(*(InputItem(module, 100 * module + 1, 12, True, 1, 2) for module in range(1, 17)))
    for _ in range(1_000):
        bench.program.cycle()
        bench.run(1)
    assert bench.port.take() == []
    assert bench.clock.next_ns() is None


ITEMS = st.one_of(
    st.builds(InputItem, st.integers(0, 9), st.integers(-5, 1700), st.integers(-1, 40), st.booleans(),
              st.integers(-1, 50), st.integers(-1, 9)),
    st.builds(OutputItem, st.integers(0, 9), st.integers(-5, 1700), st.integers(-1, 40), st.booleans()),
    st.builds(KeyItem, st.integers(0, 9), st.integers(-5, 1700), st.booleans(), st.sampled_from(KeyMode),
              st.integers(-1, 50), st.integers(-1, 50), st.integers(-1, 50)),
    st.builds(LedItem, st.integers(0, 9), st.integers(-5, 40)),
)  # fmt: skip
ORDERS = st.one_of(
    st.builds(SetOutput, st.integers(0, 9), st.integers(-(1 << 31), 1 << 31)),
    st.builds(Blink, st.integers(0, 9), st.booleans()),
    st.builds(Display, st.integers(0, 9), st.integers(-1, 300)),
    st.builds(MotorOrder, st.integers(0, 9), st.sampled_from(Motor), st.tuples(st.integers(-9, 9))),
    st.builds(Read, st.integers(0, 9), st.integers(0, 9)),
)


@pytest.mark.long
@given(st.lists(ITEMS, max_size=10), st.lists(ORDERS, max_size=20))
def test_nothing_that_a_pam_sends_breaks_the_node(items: list[Configuration], orders: list[Order]) -> None:
    bench = SmartIoBench()
    bench.program.attach(bench.port)
    bench.program.forget()
    accepted = {item.item for item in items if bench.program.accept(item)}
    bench.program.run()
    for order in orders:
        bench.program.order(order)
    bench.clock.advance_to(3_000 * MS)
    reported = {report.item for report in bench.port.sent if isinstance(report, InputChanged)}
    assert reported <= accepted
    assert bench.get("error_word") == 0, "all warnings of orders have ended"


@pytest.mark.long
def test_a_port_that_is_attached_again_is_used() -> None:
    bench = SmartIoBench()
    bench.configure(OutputItem(1, 105, 1, True))
    other = RecordedPort()
    bench.program.attach(other)
    bench.order(SetOutput(9, 1))
    assert len(other.sent) == 1
