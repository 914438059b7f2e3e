"""A node's end of the ring: cycles in, reports out."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pamring_bench import ST1, PlainNode

from fieldrig.clock import MS, VirtualClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.ring.pam.message import GROUP, LONGEST_BUFFER, Cycle, Frame, Reception, RingMessage
from fieldrig_devices.pamring import codec
from fieldrig_devices.pamring.ends import RingFault
from fieldrig_devices.pamring.frames import (
    Accepted,
    AxisItem,
    Group,
    Identify,
    Identity,
    InputChanged,
    InputItem,
    Order,
    Read,
    Refused,
    Report,
    Run,
    Running,
    SetOutput,
    SetPoint,
    SetPointMode,
)
from fieldrig_devices.pamring.node import INACTIVE_NS, NodeState

NODE = 17
VALUE = SetPoint(SetPointMode.SPEED, 5)
INPUT = InputItem(4, 101, 1, True, 1, 1)


class Bench:
    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.link = RecordedLink[RingMessage]()
        self.node = PlainNode(self.clock, self.link, NODE, ST1)
        self.number = 0

    def hear(self, *frames: tuple[int, Order]) -> list[Report]:
        """The node hears a cycle a millisecond later; returns what it reports."""
        return self.hear_bytes(*[(target, codec.encode(order)) for target, order in frames])

    def hear_bytes(self, *frames: Frame, reception: Reception = Reception.GOOD) -> list[Report]:
        self.clock.advance_to(self.clock.now_ns() + MS)
        self.number += 1
        self.link.deliver(Cycle(self.number, frames, reception))
        return self.reports()

    def reports(self) -> list[Report]:
        buffers = [message for message in self.link.take() if isinstance(message, bytes)]
        return [codec.decode_report(report) for buffer in buffers for report in codec.split(buffer)]

    def up(self, *items: AxisItem | InputItem) -> "Bench":
        self.hear((0, Identify()))
        self.hear(*[(NODE, item) for item in items])
        self.hear((0, Run()))
        return self


def test_it_answers_identify_configuration_and_run() -> None:
    bench = Bench()
    assert bench.hear((0, Identify())) == [Identity(ST1, 0x0590)]
    assert bench.hear((NODE, INPUT)) == [Accepted(4)]
    assert bench.hear((0, Run())) == [Running(), InputChanged(4, 1)]
    assert bench.node.end.state is NodeState.RUNNING


def test_an_item_that_it_cant_have_is_refused() -> None:
    bench = Bench()
    bench.node.refused = frozenset({4})
    bench.hear((0, Identify()))
    assert bench.hear((NODE, INPUT)) == [Refused(4)]


def test_items_are_taken_only_between_identify_and_run() -> None:
    bench = Bench()
    assert bench.hear((NODE, INPUT)) == [Refused(4)]
    bench.up()
    assert bench.hear((NODE, INPUT)) == [Refused(4)]
    assert bench.node.items == []


def test_identify_makes_a_node_that_runs_forget_its_items_and_its_group() -> None:
    bench = Bench().up(INPUT)
    bench.hear((NODE, Group(3)))
    assert bench.hear((0, Identify())) == [Identity(ST1, 0x0590)]
    assert bench.node.items == []
    bench.hear((0, Run()))
    bench.hear((GROUP + 3, VALUE))
    assert bench.node.orders == []


def test_run_without_identify_and_orders_before_run_change_nothing() -> None:
    bench = Bench()
    assert bench.hear((0, Run()), (NODE, SetOutput(1, 1)), (NODE, Read(1, 2))) == []
    bench.hear((0, Identify()))
    bench.hear((NODE, SetOutput(1, 1)))
    assert bench.node.orders == []


def test_registers_are_read_before_run_because_groups_are_formed_by_them() -> None:
    bench = Bench()
    bench.hear((0, Identify()))
    assert len(bench.hear((NODE, Read(1, 2)))) == 1


@pytest.mark.manual("PAML-162")
def test_a_frame_to_its_group_is_for_it_and_one_to_another_group_or_node_is_not() -> None:
    bench = Bench().up()
    bench.hear((NODE, Group(3)))
    bench.hear((GROUP + 3, VALUE), (GROUP + 2, SetPoint(SetPointMode.SPEED, 6)), (18, SetOutput(1, 1)))
    assert bench.node.orders == [VALUE]


@pytest.mark.manual("PAML-162")
def test_a_group_counts_from_the_next_frame_of_the_same_cycle_on() -> None:
    bench = Bench().up()
    bench.hear((GROUP + 3, VALUE), (NODE, Group(3)), (GROUP + 3, VALUE), (NODE, Group(0)), (GROUP + 3, VALUE))
    assert bench.node.orders == [VALUE]


def test_a_group_that_there_is_not_changes_nothing() -> None:
    bench = Bench().up()
    bench.hear((NODE, Group(3)))
    bench.hear((NODE, Group(16)))
    bench.hear((GROUP + 3, VALUE))
    assert bench.node.orders == [VALUE]


def test_orders_are_carried_out_in_the_order_in_which_they_were_sent() -> None:
    bench = Bench().up()
    first, second, third = SetOutput(1, 1), SetOutput(1, 0), SetOutput(2, 1)
    bench.hear((NODE, first), (0, second), (NODE, third))
    assert bench.node.orders == [first, second, third]
    assert bench.node.cycles == 4


def test_the_reports_of_one_cycle_are_one_message_and_others_are_sent_at_once() -> None:
    bench = Bench().up()
    bench.link.deliver(Cycle(9, tuple((NODE, codec.encode(Read(request, 0))) for request in range(3))))
    assert len(bench.link.take()) == 1
    bench.node.end.send(InputChanged(1, 0))
    assert bench.reports() == [InputChanged(1, 0)]


def test_many_reports_of_one_cycle_are_cut_to_what_the_chip_takes() -> None:
    bench = Bench()
    bench.hear((0, Identify()))
    inputs = [InputItem(item, 101, 1, True, 1, 1) for item in range(200)]
    bench.hear(*[(NODE, item) for item in inputs])
    bench.link.deliver(Cycle(9, ((0, codec.encode(Run())),)))
    assert max(len(message) for message in bench.link.sent if isinstance(message, bytes)) <= LONGEST_BUFFER
    assert bench.reports() == [Running(), *[InputChanged(item, 1) for item in range(200)]]


def test_a_ring_without_cycles_is_inactive_until_one_comes() -> None:
    bench = Bench()
    bench.clock.advance_to(INACTIVE_NS)
    assert bench.node.faults == [RingFault.INACTIVE]
    bench.hear()
    bench.hear()
    assert bench.node.faults == [RingFault.INACTIVE, RingFault.NONE]
    bench.clock.advance_to(bench.clock.now_ns() + INACTIVE_NS - 1)
    assert len(bench.node.faults) == 2
    bench.clock.advance_to(bench.clock.now_ns() + 1)
    assert bench.node.faults[2:] == [RingFault.INACTIVE]


class PatientRing(RecordedLink[RingMessage]):
    patience_ns = 100 * MS


def test_a_patient_ring_is_inactive_later() -> None:
    clock = VirtualClock()
    node = PlainNode(clock, PatientRing(), NODE, ST1)
    clock.advance_to(INACTIVE_NS + 100 * MS - 1)
    assert node.faults == []
    clock.advance_to(INACTIVE_NS + 100 * MS)
    assert node.faults == [RingFault.INACTIVE]


@pytest.mark.manual("PAMS-108")
@pytest.mark.parametrize(
    ("reception", "faults"),
    [
        (Reception.NO_CARRIER, [RingFault.CARRIER]),
        (Reception.CRC_ERROR, [RingFault.CRC, RingFault.INACTIVE, RingFault.CRC]),
    ],
)
def test_the_first_node_behind_a_fault_goes_on_showing_it_when_the_ring_stops(
    reception: Reception, faults: list[RingFault]
) -> None:
    """Its program hears of the silence nevertheless, and stops what moves."""
    bench = Bench()
    bench.hear()
    bench.hear_bytes(reception=reception)
    bench.clock.advance_to(bench.clock.now_ns() + 10 * INACTIVE_NS)
    assert bench.node.faults == faults
    bench.hear()
    assert bench.node.faults == [*faults, RingFault.NONE]


@given(st.lists(st.tuples(st.sampled_from([0, NODE, GROUP + 1]), st.binary(min_size=1, max_size=40)), max_size=6))
def test_hostile_frames_dont_disturb_it(frames: list[Frame]) -> None:
    bench = Bench().up()
    bench.hear_bytes(*frames)
    bench.hear((0, Identify()))
    assert bench.node.end.state is NodeState.IDENTIFIED
