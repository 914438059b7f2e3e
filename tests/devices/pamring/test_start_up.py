"""The start of a ring, with everything that may be wrong with it."""

import pytest
from pamring_bench import SHORT, SMART_IO, ST1, Bench

from fieldrig.clock import MS
from fieldrig_devices.pamring.declared import DeclaredNode
from fieldrig_devices.pamring.frames import (
    AxisItem,
    Configuration,
    CounterItem,
    InputChanged,
    InputItem,
    OutputItem,
    Severity,
    Trouble,
)
from fieldrig_devices.pamring.node import NodeState
from fieldrig_devices.pamring.settings import RingLimits
from fieldrig_devices.pamring.start_up import Phase

FEEDER, LIFT = DeclaredNode(0x11, ST1, 17), DeclaredNode(0x12, SMART_IO, 33)
TWO = (FEEDER, LIFT)
BOTH = ((17, ST1), (33, SMART_IO))
AXIS, LIMIT = AxisItem(1, 0, 0), InputItem(2, 101, 1, True, 5, 1)
KEY_IN, LAMP = InputItem(3, 201, 1, True, 5, 2), OutputItem(4, 101, 1, True)
ITEMS: dict[int, list[Configuration]] = {17: [AXIS, LIMIT], 33: [KEY_IN, LAMP]}
RING_ENDED = [("06..F001", (0, 0, 0)), ("07..E013", (0, 0, 0))]


@pytest.mark.manual("PAML-020", "PAMS-107")
def test_a_ring_as_declared_is_configured_and_runs_and_says_so_in_order() -> None:
    bench = Bench(TWO, BOTH).configure(ITEMS).start()
    assert bench.pam.ring.phase is Phase.RUNNING
    assert bench.pam.codes == [
        "07..M003", "07..M004", "07..M00B", "07..M00D", "07..M013", "07..M00E", "07..M014",
    ]  # fmt: skip
    assert bench.node(17).items == [AXIS, LIMIT]
    assert bench.node(33).items == [KEY_IN, LAMP]
    assert {node.end.state for node in bench.nodes} == {NodeState.RUNNING}
    assert bench.pam.reports == [(17, InputChanged(2, 1)), (33, InputChanged(3, 1))]


@pytest.mark.manual("PAMS-107")
def test_a_pam_without_nodes_works() -> None:
    bench = Bench((), ()).start()
    assert bench.pam.codes == ["07..M003", "07..M00C"]
    assert bench.pam.ring.phase is Phase.RUNNING


def test_a_ring_of_st1_nodes_has_no_messages_of_smart_io_nodes() -> None:
    bench = Bench([FEEDER], [(17, ST1)]).configure({17: [AXIS]}).start()
    assert bench.pam.codes == ["07..M003", "07..M004", "07..M00B", "07..M014"]


# ---- section 14.4: the ring is not as declared; D1 is the ring mode, which is 1


@pytest.mark.manual("PAML-021", "PAML-027", "PAMS-106")
def test_a_declared_node_that_is_missing_is_named() -> None:
    bench = Bench((FEEDER, DeclaredNode(0x13, SMART_IO, 33, 2)), BOTH).start()
    assert bench.pam.errors == [("06..F003", (1, 34, 0)), *RING_ENDED]
    assert bench.pam.ring.phase is Phase.FAILED


@pytest.mark.manual("PAML-020", "PAML-027", "PAMS-106")
def test_a_node_that_is_not_declared_is_named() -> None:
    bench = Bench([FEEDER], BOTH).start()
    assert bench.pam.errors == [("06..F002", (1, 33, 0)), *RING_ENDED]


@pytest.mark.manual("PAML-021")
def test_wrong_address_switches_are_a_missing_node_and_an_extra_one() -> None:
    bench = Bench(TWO, ((18, ST1), (33, SMART_IO))).start()
    assert bench.pam.codes == ["06..F002", "06..F003", "06..F001", "07..E013", "07..F025", "07..F025"]
    assert bench.pam.said[:2] == [("06..F002", (1, 18, 0)), ("06..F003", (1, 17, 0))]


@pytest.mark.manual("PAML-020", "PAML-027", "PAMS-106")
def test_a_node_of_another_type_is_named() -> None:
    bench = Bench(TWO, ((17, SMART_IO), (33, SMART_IO))).start()
    assert bench.pam.errors == [("06..F004", (1, 17, 0)), *RING_ENDED]


@pytest.mark.manual("PAMS-106")
def test_a_node_whose_processor_stands_still_sends_no_ready_token() -> None:
    bench = Bench(TWO, BOTH)
    bench.fault(what="halt", station="n1")
    bench.start()
    assert bench.pam.errors == [("06..F005", (1, 33, 0)), *RING_ENDED]


@pytest.mark.manual("PAML-027", "PAMS-106")
def test_two_nodes_of_one_address_make_the_count_wrong() -> None:
    bench = Bench(TWO, (*BOTH, (33, SMART_IO))).start()
    assert bench.pam.errors == [("06..F006", (1, 3, 0)), *RING_ENDED]


@pytest.mark.manual("PAML-027", "PAMS-106")
@pytest.mark.parametrize(("thirds", "most"), [(1, 1), (3, 2), (6, 4)])
def test_more_nodes_than_the_cycle_has_time_for(thirds: int, most: int) -> None:
    settings = RingLimits(thirds=thirds, nodes_per_ms=2, boot_ns=20 * MS)
    five = [(address, ST1) for address in range(1, 6)]
    bench = Bench([DeclaredNode(1, ST1, 1, 5)], five, settings).start()
    assert bench.pam.errors == [("06..F016", (most, 5, 0)), *RING_ENDED]
    as_many = Bench([DeclaredNode(1, ST1, 1, most)], five[:most], settings).start()
    assert as_many.pam.errors == []


@pytest.mark.manual("PAMS-106")
@pytest.mark.parametrize("interface", ["asic", "fpga"])
def test_an_open_ring_is_an_empty_fifo_at_the_start_whatever_the_interface(interface: str) -> None:
    settings = RingLimits(boot_ns=20 * MS, interface="asic" if interface == "asic" else "fpga")
    bench = Bench(TWO, BOTH, settings)
    bench.fault(what="break", after="n0")
    bench.start()
    assert bench.pam.said == [("06..F00C", (0, 0, 0)), *RING_ENDED]


def test_a_ring_that_closes_in_time_is_waited_for() -> None:
    bench = Bench(TWO, BOTH)
    bench.fault(what="break", after="n0", duration_ms=15)
    assert bench.start().pam.ring.phase is Phase.RUNNING


def test_a_node_that_comes_in_time_is_waited_for_although_the_ring_is_closed_without_it() -> None:
    bench = Bench(TWO, BOTH, bypassed=["n1"])
    bench.fault(what="off", station="n1", duration_ms=15)
    assert bench.start().pam.ring.active == {17, 33}


@pytest.mark.manual("PAMS-106")
def test_a_damaged_frame_at_the_start_names_the_node_behind_it() -> None:
    bench = Bench(TWO, BOTH)
    bench.fault(what="distort", after="n0")
    bench.start()
    assert bench.pam.said == [("06..F00E", (33, 0, 0)), *RING_ENDED]


# ---- NUMBER and NODES_GROUP


@pytest.mark.manual("PAML-004", "PAML-022")
def test_a_multiple_node_has_consecutive_addresses() -> None:
    bench = Bench([DeclaredNode(1, ST1, 63, 3)], [(65, ST1), (63, ST1), (64, ST1)]).start()
    assert bench.pam.ring.active == {63, 64, 65}
    bench = Bench([DeclaredNode(1, ST1, 63, 3)], [(63, ST1), (64, ST1), (66, ST1)]).start()
    assert bench.pam.said[:2] == [("06..F002", (1, 66, 0)), ("06..F003", (1, 65, 0))]


@pytest.mark.manual("PAML-005", "PAML-006")
@pytest.mark.parametrize("there", [[1], [2, 3], [1, 2, 3]])
def test_one_application_drives_as_many_components_of_a_group_as_there_are(there: list[int]) -> None:
    heads = DeclaredNode(1, ST1, 1, 3, "HEADS")
    bench = Bench([heads], [(address, ST1) for address in there]).configure({a: [AXIS] for a in (1, 2, 3)}).start()
    assert bench.pam.ring.phase is Phase.RUNNING
    assert bench.pam.ring.active == set(there)
    assert all(node.items == [AXIS] for node in bench.nodes)


@pytest.mark.manual("PAML-026", "PAML-028")
def test_a_member_of_a_nodes_group_may_be_missing() -> None:
    heads = DeclaredNode(1, ST1, 1, 3, "HEADS")
    bench = Bench([heads], [(1, ST1), (3, ST1)]).configure({a: [AXIS] for a in (1, 2, 3)}).start()
    assert bench.pam.errors == []
    assert bench.pam.ring.active == {1, 3}
    assert [len(node.items) for node in bench.nodes] == [1, 1]


@pytest.mark.manual("PAML-007")
def test_a_component_that_lacks_one_of_its_nodes_is_ignored_with_all_of_them() -> None:
    declared = [DeclaredNode(1, ST1, 1, 2, "HEADS"), DeclaredNode(2, SMART_IO, 33, 2, "HEADS")]
    bench = Bench(declared, [(1, ST1), (2, ST1), (34, SMART_IO)]).configure({1: [AXIS], 2: [AXIS]}).start()
    assert bench.pam.ring.active == {2, 34}
    assert bench.node(1).items == []
    assert bench.pam.ring.phase is Phase.RUNNING


@pytest.mark.manual("PAML-028", "PAMS-107")
def test_a_node_of_which_nothing_is_there_is_an_error_in_a_group_as_well() -> None:
    declared = [DeclaredNode(0x1A, ST1, 1, 3, "HEADS"), LIFT]
    bench = Bench(declared, [(33, SMART_IO)]).start()
    assert bench.pam.errors == [("07..F025", (0x1A, 3, 1)), ("07..F025", ())]
    assert bench.pam.texts == ["NODE INIT. ERROR"]
    assert bench.pam.ring.phase is Phase.FAILED


@pytest.mark.manual("PAMS-107")
def test_an_empty_ring_names_every_node() -> None:
    bench = Bench([DeclaredNode(1, ST1, 1, 3, "HEADS"), DeclaredNode(2, ST1, 7, 1, "TAILS")], []).start()
    assert bench.pam.errors == [("07..F025", (1, 3, 1)), ("07..F025", (2, 1, 7))]
    assert bench.pam.texts == ["ALL NODES WITHOUT ACTIVE ITEM"] * 2


# ---- section 14.5: configuration and run


@pytest.mark.manual("PAMS-105", "PAMS-107")
def test_a_refused_item_of_a_smart_io_ends_the_configuration() -> None:
    bench = Bench(TWO, BOTH).configure(ITEMS)
    bench.node(33).refused = frozenset({4})
    bench.start()
    assert bench.pam.errors == [("04..E01A", (33, 4, 0)), ("07..F014", (0, 0, 0))]
    assert bench.node(33).items == [KEY_IN], "the others were configured nevertheless"


@pytest.mark.manual("PAMS-107")
def test_a_refused_input_of_an_st1_is_a_bad_definition() -> None:
    bench = Bench(TWO, BOTH).configure(ITEMS)
    bench.node(17).refused = frozenset({2})
    bench.start()
    assert bench.pam.errors == [("07..F02D", (2, 0, 0))]


@pytest.mark.manual("PAMS-107")
def test_a_refused_axis_is_a_bad_axis_declaration() -> None:
    bench = Bench(TWO, BOTH).configure(ITEMS)
    bench.node(17).refused = frozenset({1})
    bench.start()
    assert bench.pam.errors == [("07..F01F", (0, 0, 0))]


@pytest.mark.manual("PAMS-105", "PAMS-107")
def test_all_that_is_refused_is_shown() -> None:
    bench = Bench(TWO, BOTH).configure(ITEMS)
    bench.node(17).refused, bench.node(33).refused = frozenset({1}), frozenset({3, 4})
    bench.start()
    assert bench.pam.codes[3:] == ["04..E01A", "04..E01A", "07..F014", "07..F01F"]


@pytest.mark.manual("PAMS-107")
def test_a_configuration_that_is_not_acknowledged_is_a_fault() -> None:
    bench = Bench(TWO, BOTH).configure({33: [KEY_IN]})
    bench.fault(what="halt", station="n1", start_ms=2.5)  # it has answered with its ready token
    bench.start()
    assert bench.pam.errors == [("07..F016", (0, 0, 0))]


@pytest.mark.manual("PAMS-107")
def test_a_run_order_that_is_not_acknowledged_is_a_fault() -> None:
    bench = Bench(TWO, BOTH)
    bench.fault(what="halt", station="n1", start_ms=2.5)
    bench.start()
    assert bench.pam.errors == [("07..F017", (0, 0, 0))]


@pytest.mark.manual("PAMS-107")
def test_a_node_that_allows_no_configuration_refuses_the_initialisation() -> None:
    bench = Bench(TWO, BOTH).configure(ITEMS)
    node = bench.node(33)

    def accept(item: Configuration) -> bool:
        node.end.send(Trouble(Severity.WARNING, 0x00C, (0x0A, 0), 0x020000))
        return True

    node.accept = accept  # type: ignore[method-assign]
    bench.start()
    assert set(bench.pam.errors) == {("04..W00C", (33, 0x0A, 0)), ("07..F015", (0, 0, 0))}


@pytest.mark.manual("PAMS-107")
def test_an_acknowledge_of_no_item_is_bad() -> None:
    bench = Bench(TWO, BOTH).configure({33: [KEY_IN, KEY_IN]}).start()
    assert bench.pam.errors == [("07..E00B", (33, 3, 0))]


@pytest.mark.parametrize("ms", range(1, 12))
def test_a_pam_that_is_reset_while_it_starts_its_ring_starts_it_again(ms: int) -> None:
    """The reports that are still under way mean nothing to it."""
    bench = Bench(TWO, BOTH).configure(ITEMS)
    bench.pam.start()
    bench.run(ms + 0.5)
    bench.pam.reset(TWO, ITEMS)
    bench.run(100)
    assert bench.pam.errors == []
    assert bench.pam.ring.phase is Phase.RUNNING
    assert bench.node(33).items == [KEY_IN, LAMP]


@pytest.mark.manual("PAMS-107")
def test_an_input_without_a_first_value_is_an_error_that_does_not_stop_the_pam() -> None:
    bench = Bench(TWO, BOTH).configure(ITEMS)
    bench.node(33).silent = frozenset({3})
    bench.start()
    assert bench.pam.errors == [("07..E021", (33, 3, 0))]
    assert "07..M00E" not in bench.pam.codes
    assert bench.pam.ring.phase is Phase.RUNNING


def test_inputs_of_an_st1_are_not_waited_for() -> None:
    bench = Bench(TWO, BOTH).configure(ITEMS)
    bench.node(17).silent = frozenset({2})
    assert bench.start().pam.errors == []


def test_first_values_may_come_one_by_one() -> None:
    inputs = [InputItem(item, 101, 1, True, 1, 1) for item in range(5)]
    bench = Bench([LIFT], [(33, SMART_IO)]).configure({33: inputs})
    bench.node(33).silent = frozenset(range(5))
    bench.pam.start()
    bench.run(8)
    for item in range(5):
        bench.run(8)
        bench.node(33).end.send(InputChanged(item, 1))
    bench.run(5)
    assert bench.pam.codes[-1] == "07..M00E"


def test_a_slow_input_has_time_for_its_samples() -> None:
    """20 samples, one in each 5 ms, are more than the time-out of 10 ms."""
    slow = InputItem(3, 201, 1, True, 5, 20)
    bench = Bench([LIFT], [(33, SMART_IO)]).configure({33: [slow]})
    node = bench.node(33)
    node.silent = frozenset({3})
    bench.pam.start()
    bench.run(95)
    node.end.send(InputChanged(3, 1))
    bench.run(5)
    assert bench.pam.codes[-1] == "07..M00E"


@pytest.mark.manual("PAML-167")
def test_a_large_configuration_takes_twenty_frames_per_millisecond() -> None:
    counters: list[Configuration] = [CounterItem(item, 101, True, 1, 1) for item in range(1_000)]
    bench = Bench([LIFT], [(33, SMART_IO)], SHORT).configure({33: counters}).start()
    assert len(bench.node(33).items) == 1_000, "50 ms are more than the time-out, but there is no pause of 10 ms"
    assert max(len(message.frames) for _, _, message in bench.trace if hasattr(message, "frames")) == 20
