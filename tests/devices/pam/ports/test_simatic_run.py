"""The Simatic S5 DualPort while the application runs (sections 12.1, 12.2 and 12.4)."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pam_ports import GROUP, SIMATIC, PortBench, started_simatic

from fieldrig_devices.pam.ports.masters.s5 import S5Master
from fieldrig_devices.pam.ports.memory import Memory
from fieldrig_devices.pam.ports.simatic.cells import AddressFifo

WATCH_DOG = 0xFFE // 2


def behind_a_period(bench: PortBench) -> None:
    bench.cycles(11 - bench.kernel.cycle_number % 10)


@pytest.mark.manual("PAMS-088", "PAMS-096")
def test_outputs_are_in_their_cells_and_announced() -> None:
    bench, master = started_simatic()
    bench.item("DFO_MachOk").do("set", ())
    bench.item("DFO_MachHeadBusy", 3).do("set", ())
    bench.item("DWO_MachHeadPosition", 2).set_value(-5)
    assert bench.memory.read(0x904 // 2, 1) == [1 << 13]  # cell #904 bit 13
    assert bench.memory.read(0x906 // 2, 1) == [1 << 3]
    assert bench.memory.read(0x926 // 2, 1) == [0xFFFB]
    assert bench.memory.read(0x800 // 2, 3) == [0x904, 0x906, 0x926]
    assert bench.memory.read(0x900 // 2, 1) == [6]
    assert bench.play(master.take()) == [
        ("DFO_MachOk", 0, True),
        ("DFO_MachHeadBusy", 3, True),
        ("DWO_MachHeadPosition", 2, -5),
    ]


@pytest.mark.manual("PAMS-088", "PAMS-089")
def test_an_input_word_is_announced_and_updated_at_the_period() -> None:
    bench, master = started_simatic()
    behind_a_period(bench)
    for value in (1, 2, -3):
        assert bench.play(master.put("DWI_MachHeadSpeed", value, 1))
    bench.cycles(9)
    assert bench.kernel.events == []
    bench.cycles()
    assert bench.value("DWI_MachHeadSpeed", 1) == -3
    assert bench.kernel.events == ["DWI_MachHeadSpeed"]
    bench.memory.write(0x120 // 2, [99])  # not announced
    bench.cycles(20)
    assert bench.value("DWI_MachPressure") == 0


@pytest.mark.manual("PAMS-090")
def test_input_flags_are_found_within_one_period() -> None:
    bench, master = started_simatic()
    behind_a_period(bench)
    bench.play(master.put("DFI_MachRunning", True))
    bench.play(master.put("DFI_MachHeadTorque", True, 2))
    seen = []
    for _ in range(10):
        bench.cycles()
        seen.append(len(bench.kernel.events))
    # #104 to #183 are 64 cells, thus 7 of them are read in each cycle: #182 in the tenth, #104 in the first.
    assert seen == [0] * 8 + [1, 2]
    assert bench.kernel.events == ["DFI_MachHeadTorque", "DFI_MachRunning"]


@pytest.mark.manual("PAMS-090")
def test_a_flag_that_changes_right_after_the_start_is_found() -> None:
    bench = PortBench(GROUP + SIMATIC)
    bench.begin()
    master = S5Master(bench.plans[0])
    bench.play(master.start_up({"DFI_MachRunning": True}))
    assert bench.value("DFI_MachRunning") is True
    bench.play(master.put("DFI_MachRunning", False))
    bench.cycles(10)
    assert bench.value("DFI_MachRunning") is False


@pytest.mark.manual("PAMS-089")
def test_the_odd_bytes_of_head_and_tail_are_not_used() -> None:
    bench, _ = started_simatic()
    bench.memory.write(0x120 // 2, [7])
    bench.memory.write(bench.memory.read(0x100 // 2, 1)[0] // 2, [0x120])
    bench.memory.write(0x100 // 2, [0xAB00 + bench.memory.read(0x100 // 2, 1)[0] + 2])
    bench.memory.write(0x902 // 2, [0xCD02])  # TAIL of the output FIFO, as if an entry had been read
    bench.cycles(10)
    assert bench.value("DWI_MachPressure") == 7
    for value in range(1, 131):
        bench.item("DWO_MachCurrentPressure").set_value(value)
    assert bench.memory.read(0x900 // 2, 1) == [0]  # one in front of TAIL
    assert bench.kernel.codes.count("07..E008") == 1


@pytest.mark.manual("PAMS-107")
def test_an_unknown_address_is_reported() -> None:
    bench, _ = started_simatic()
    for address in (0x121, 0x106, 0xFFFF):
        bench.memory.write(bench.memory.read(0x100 // 2, 1)[0] // 2, [address])
        bench.memory.write(0x100 // 2, [bench.memory.read(0x100 // 2, 1)[0] + 2])
    bench.cycles(10)
    assert bench.kernel.reports[-3:] == [("07..E011", (0x121,)), ("07..E011", (0x106,)), ("07..E011", (0xFFFF,))]


@pytest.mark.manual("PAMS-089", "PAMS-107")
def test_127_addresses_fit() -> None:
    bench, master = started_simatic()
    for value in range(1, 131):
        bench.item("DWO_MachCurrentPressure").set_value(value)
    assert bench.kernel.codes.count("07..E008") == 1
    assert bench.memory.read(0x900 // 2, 1) == [254]
    assert bench.play(master.take()) == [("DWO_MachCurrentPressure", 0, 130)]  # the cell has the last value
    bench.item("DWO_MachCurrentPressure").set_value(1)
    assert bench.memory.read(0x900 // 2, 1) == [0]
    assert [bench.play(master.put("DWI_MachPressure", value)) for value in range(128)] == [True] * 127 + [False]


@pytest.mark.manual("PAMS-093", "PAMS-107")
def test_the_watchdog() -> None:
    bench, master = started_simatic()
    for _ in range(60):
        assert bench.play(master.watch())
        bench.cycles(10)
    bench.memory.write(WATCH_DOG, [0xABFF])  # the odd byte is not used
    bench.cycles(10)
    assert bench.memory.read(WATCH_DOG, 1) == [0xAB00]
    bench.cycles(490)
    assert not bench.item("DualPort").ask("error", ())
    bench.cycles(20)
    assert bench.kernel.codes[-1] == "07..E01E"
    assert bench.item("DualPort").ask("error", ())
    assert bench.ports.may_run
    bench.memory.write(WATCH_DOG, [0xFF])
    bench.play(master.put("DFI_MachRunning", True))
    bench.play(master.put("DWI_MachPressure", 4))
    bench.cycles(50)
    assert bench.memory.read(WATCH_DOG, 1) == [0xFF]
    assert (bench.value("DFI_MachRunning"), bench.value("DWI_MachPressure")) == (False, 0)


@pytest.mark.manual("PAMS-093")
def test_the_host_sees_within_200_ms_that_the_pam_has_stopped() -> None:
    bench, master = started_simatic()
    bench.ports._ports[0].fail()
    assert [bench.play(master.watch()) for _ in range(22)] == [True] * 21 + [False]


@pytest.mark.manual("PAML-029", "PAMS-086")
def test_components_that_are_not_active_are_not_serviced() -> None:
    bench, master = started_simatic()
    bench.inactive = {1}
    for index in (0, 1):
        bench.play(master.put("DFI_MachHeadReady", True, index))
        bench.play(master.put("DWI_MachHeadSpeed", 7, index))
        bench.item("DWO_MachHeadPosition", index).set_value(7)
    bench.cycles(20)
    assert [bench.value("DFI_MachHeadReady", index) for index in (0, 1)] == [True, False]
    assert [bench.value("DWI_MachHeadSpeed", index) for index in (0, 1)] == [7, 0]
    assert bench.play(master.take()) == [("DWO_MachHeadPosition", 0, 7)]


@settings(max_examples=50, deadline=None)
@given(moves=st.lists(st.sampled_from("wr"), max_size=400))
def test_an_address_fifo_keeps_order_and_loses_nothing(moves: list[str]) -> None:
    bench = PortBench(GROUP + SIMATIC)
    memory = Memory()
    writer, reader = (AddressFifo(memory, bench.plans[0], "FIFO_IN") for _ in range(2))
    waiting: list[int] = []
    for number, move in enumerate(moves):
        if move == "w":
            assert writer.put(number) is (len(waiting) < 127)
            waiting = [*waiting, number][:127]
        else:
            assert reader.get() == (waiting.pop(0) if waiting else None)


@pytest.mark.parametrize("wrong", [1, 255])
def test_an_index_that_does_not_exist_leads_nowhere(wrong: int) -> None:
    bench = PortBench(GROUP + SIMATIC)
    memory = Memory()
    fifo = AddressFifo(memory, bench.plans[0], "FIFO_IN")
    memory.write(0x100 // 2, [wrong, wrong])
    assert fifo.get() is None
    assert not fifo.put(1)
