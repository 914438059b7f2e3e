"""The faults of a terminal: what the bus shows of them, and their end.  Key F1 is F245 of the card: bit 20."""

import pytest
from arp_terminal import TerminalBench

F1_DOWN, RELEASED = "194#00 00 10 00", "194#00 00 00 00"


@pytest.fixture
def bench() -> TerminalBench:
    return TerminalBench()


def test_a_key_that_sticks_is_down_until_the_fault_ends(bench: TerminalBench) -> None:
    bench.terminal.add_fault({"what": "stuck_key", "key": "F1", "start_ms": 100, "duration_ms": 200})
    assert bench.after(99) == []
    assert bench.after(1) == [F1_DOWN]
    assert bench.press("F1") == []
    assert bench.after(100) == [RELEASED]
    assert bench.press("F1") == [F1_DOWN, RELEASED]


def test_a_key_that_does_not_close_is_never_seen(bench: TerminalBench) -> None:
    bench.set("key.F1", True)
    assert bench.after(0) == [F1_DOWN]
    number = bench.terminal.add_fault({"what": "stuck_key", "key": "f1", "pressed": False})
    assert bench.after(0) == [RELEASED]
    assert bench.press("F1") == []
    bench.set("key.F1", True)
    bench.terminal.clear_fault(number)
    assert bench.after(0) == [F1_DOWN]


def test_a_digit_that_sticks_is_typed_once(bench: TerminalBench) -> None:
    bench.store_message(1, "SET ###")
    bench.send("314#01 01 01 01 00 05", "414#01 01 00 00 00 00")
    bench.terminal.add_fault({"what": "stuck_key", "key": "7"})
    bench.press("7 CR")
    assert bench.screen[0] == "SET   7"


def test_a_key_that_the_model_does_not_have_is_refused(bench: TerminalBench) -> None:
    with pytest.raises(ValueError, match=r"there is no key 'FA'\n.*F1"):
        bench.terminal.add_fault({"what": "stuck_key", "key": "FA"})


def test_a_terminal_whose_line_is_cut_is_silent_and_deaf(bench: TerminalBench) -> None:
    """Its heartbeat (1017h) is missing, and an SDO request has no answer, until the fault ends."""
    bench.send("614#2b 17 10 00 64 00 00 00")
    number = bench.terminal.add_fault({"what": "silent"})
    assert bench.after(300) == []
    assert bench.send("614#40 00 10 00 00 00 00 00") == []
    assert bench.press("F1") == []
    bench.terminal.clear_fault(number)
    assert bench.send("614#40 18 10 02 00 00 00 00") == ["594#43 18 10 02 04 00 00 00"]
    assert "714#05" in bench.after(100)
