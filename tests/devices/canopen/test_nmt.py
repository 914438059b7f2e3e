"""NMT slave and heartbeat, CiA 301 7.2.8 and 7.3.2."""

import pytest
from canopen_bench import CanopenBench

OPERATIONAL, STOPPED, PRE_OPERATIONAL = "05", "04", "7f"
START, STOP, PREPARE, RESET_NODE, RESET_COMMUNICATION = "01", "02", "80", "81", "82"

# Figure 'NMT state diagram', row by row.
TRANSITIONS = [
    (PRE_OPERATIONAL, START, OPERATIONAL),
    (PRE_OPERATIONAL, STOP, STOPPED),
    (PRE_OPERATIONAL, PREPARE, PRE_OPERATIONAL),
    (OPERATIONAL, START, OPERATIONAL),
    (OPERATIONAL, STOP, STOPPED),
    (OPERATIONAL, PREPARE, PRE_OPERATIONAL),
    (STOPPED, START, OPERATIONAL),
    (STOPPED, STOP, STOPPED),
    (STOPPED, PREPARE, PRE_OPERATIONAL),
]
ENTER = {OPERATIONAL: START, STOPPED: STOP, PRE_OPERATIONAL: PREPARE}


@pytest.mark.parametrize(("state", "command", "expected"), TRANSITIONS)
def test_command_leads_to_the_state_of_the_diagram(state: str, command: str, expected: str) -> None:
    bench = CanopenBench(objects={"1017:00": 100})
    bench.send(f"000#{ENTER[state]} 05", f"000#{command} 05")
    assert f"705#{expected}" in bench.after(100)


@pytest.mark.parametrize("state", ENTER)
@pytest.mark.parametrize("command", [RESET_NODE, RESET_COMMUNICATION])
def test_reset_boots_up_into_pre_operational(bench: CanopenBench, state: str, command: str) -> None:
    bench.send(f"000#{ENTER[state]} 05")
    assert bench.send(f"000#{command} 05") == ["705#00"]
    assert bench.point("nmt.state") == "pre_operational"


@pytest.mark.parametrize("command", [RESET_NODE, RESET_COMMUNICATION])
def test_a_node_that_takes_time_to_boot_neither_sends_nor_hears_anything_meanwhile(command: str) -> None:
    bench = CanopenBench(objects={"1017:00": 40}, boot_up_ms=100)
    assert bench.after(99) == []
    assert bench.after(1) == ["705#00"]
    assert bench.send(f"000#{command} 05") == []
    assert bench.point("nmt.state") == "initialising"
    switch_state_global = "7e5#04 01 00 00 00 00 00 00"
    assert (
        bench.send("000#01 05", "605#40 00 10 00 00 00 00 00", switch_state_global, "7e5#5e 00 00 00 00 00 00 00") == []
    )
    assert bench.after(50) == []
    assert bench.send(f"000#{command} 05") == []
    assert bench.after(50) == ["705#00"]
    assert bench.after(40) == ["705#7f"]


def test_command_to_all_nodes_is_obeyed(bench: CanopenBench) -> None:
    bench.send("000#01 00")
    assert bench.point("nmt.state") == "operational"


@pytest.mark.parametrize(
    "frame", ["000#01 06", "000#01", "000#01 05 00", "000#", "000#03 05", "000#R", "00000000#01 05"]
)
def test_anything_else_is_ignored(bench: CanopenBench, frame: str) -> None:
    assert bench.send(frame) == []
    assert bench.point("nmt.state") == "pre_operational"


def test_reset_node_restores_all_parameters(bench: CanopenBench) -> None:
    bench.write("2b 17 10 00 64 00 00 00", "2f 02 62 01 ff 00 00 00")
    bench.send("000#81 05")
    assert bench.sdo("40 17 10 00 00 00 00 00") == "4b 17 10 00 00 00 00 00"
    assert bench.sdo("40 02 62 01 00 00 00 00") == "4f 02 62 01 00 00 00 00"


def test_reset_communication_keeps_the_application(bench: CanopenBench) -> None:
    bench.write("2b 17 10 00 64 00 00 00", "2f 02 62 01 ff 00 00 00")
    bench.send("000#82 05")
    assert bench.sdo("40 17 10 00 00 00 00 00") == "4b 17 10 00 00 00 00 00"
    assert bench.sdo("40 02 62 01 00 00 00 00") == "4f 02 62 01 ff 00 00 00"


def test_reset_node_does_not_move_the_inputs_of_the_machine(bench: CanopenBench) -> None:
    bench.set("6000:01", 0x55)
    bench.send("000#81 05")
    assert bench.point("6000:01") == 0x55


def test_stopped_node_answers_no_sdo(bench: CanopenBench) -> None:
    bench.send("000#02 05")
    assert bench.sdo("40 00 10 00 00 00 00 00") == ""


def test_node_asks_the_bus_only_for_what_it_wants(bench: CanopenBench) -> None:
    assert bench.interest == [0x000, 0x080, 0x100, 0x205, 0x285, 0x305, 0x605, 0x705, 0x7E5]


def test_interest_is_the_same_in_every_state(bench: CanopenBench) -> None:
    """A frame may follow an NMT command faster than a change of the interest could take effect."""
    before = bench.interest
    bench.send("000#02 05")
    assert bench.interest == before


def test_boot_up_is_the_first_heartbeat() -> None:
    bench = CanopenBench(objects={"1017:00": 100})
    assert bench.after(99) == ["705#00"]
    assert bench.after(1) == ["705#7f"]
    assert bench.after(1000) == ["705#7f"] * 10


def test_heartbeat_time_holds_at_once(bench: CanopenBench) -> None:
    assert bench.send("605#2b 17 10 00 32 00 00 00") == ["585#60 17 10 00 00 00 00 00", "705#7f"]
    assert bench.after(100) == ["705#7f", "705#7f"]
    bench.write("2b 17 10 00 00 00 00 00")
    assert bench.after(1000) == []


def test_heartbeat_goes_on_when_stopped() -> None:
    bench = CanopenBench(objects={"1017:00": 100})
    bench.send("000#02 05")
    assert bench.after(200) == ["705#04", "705#04"]


WATCH_NODE_9_FOR_100_MS = "23 16 10 01 64 00 09 00"


def test_lost_heartbeat_is_reported_and_ends_operational(bench: CanopenBench) -> None:
    bench.write(WATCH_NODE_9_FOR_100_MS)
    assert 0x709 in bench.interest
    bench.send("000#01 05", "709#05")
    assert bench.after(99) == []
    assert bench.after(1) == ["085#30 81 11 00 00 00 00 00"]
    assert bench.point("nmt.state") == "pre_operational"
    assert bench.send("709#05") == ["085#00 00 00 00 00 00 00 00"]


def test_watch_begins_with_the_first_heartbeat(bench: CanopenBench) -> None:
    bench.write(WATCH_NODE_9_FOR_100_MS)
    assert bench.send("709#00") == []
    assert bench.after(1000) == []


@pytest.mark.parametrize(("behaviour", "state"), [("00", "pre_operational"), ("01", "operational"), ("02", "stopped")])
def test_error_behaviour_says_what_a_lost_heartbeat_does(bench: CanopenBench, behaviour: str, state: str) -> None:
    bench.write(WATCH_NODE_9_FOR_100_MS, f"2f 29 10 01 {behaviour} 00 00 00")
    bench.send("000#01 05", "709#05")
    bench.after(100)
    assert bench.point("nmt.state") == state


def test_two_watches_over_one_node_are_refused(bench: CanopenBench) -> None:
    bench.write(WATCH_NODE_9_FOR_100_MS, WATCH_NODE_9_FOR_100_MS)
    assert bench.sdo("23 16 10 02 c8 00 09 00") == "80 16 10 02 43 00 04 06"


# 1F80h, CiA 302-2


@pytest.mark.parametrize("entry", ["64 00 00 00", "64 00 80 00", "64 00 ff 00", "00 00 09 00"])
def test_entries_that_watch_no_node_may_be_alike(bench: CanopenBench, entry: str) -> None:
    """An entry of 1016h with node-ID 0 or above 127, or with a time of 0, is not used (CiA 301 7.5.2.19)."""
    bench.write(f"23 16 10 01 {entry}", f"23 16 10 02 {entry}")


def test_node_that_starts_itself() -> None:
    bench = CanopenBench(objects={"1F80:00": 0})
    assert bench.after(0) == ["705#00", "185#00 00 00 00", "285#00 00 00 00 00 00 00 00"]
    assert bench.point("nmt.state") == "operational"
    bench.send("000#80 05")
    assert bench.point("nmt.state") == "pre_operational"
    bench.send("000#82 05")
    assert bench.point("nmt.state") == "operational"


def test_node_is_no_master(bench: CanopenBench) -> None:
    assert bench.sdo("23 80 1f 00 01 00 00 00") == "80 80 1f 00 30 00 09 06"
    bench.write("23 80 1f 00 00 00 00 00")
