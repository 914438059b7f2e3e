"""Passages of the manual about ports that can be read in two ways, each with its setting (pam-readings.md)."""

from pathlib import Path
from typing import Any, Literal

import pytest
from pam_ports import GROUP, SIMATIC, VME, PortBench, started_simatic, started_vme
from pydantic import ValidationError

from fieldrig_devices.pam.language.ports import crc_of
from fieldrig_devices.pam.ports.masters.s5 import S5Master
from fieldrig_devices.pam.ports.masters.vme import VmeMaster
from fieldrig_devices.pam.ports.options import PortOptions
from fieldrig_devices.pam.ports.vme.layout import Answer, Command

WATCHDOG = 20 // 2
LIMITED = GROUP + VME.replace("MASTER_CONFIGURATION_TIMEOUT = NONE", "MASTER_CONFIGURATION_TIMEOUT = 300")
S5_WATCH_DOG, HEAD_IN, TAIL_IN, HEAD_OUT = 0xFFE // 2, 0x100 // 2, 0x102 // 2, 0x900 // 2

Started = tuple[PortBench, VmeMaster] | tuple[PortBench, S5Master]


def configured(options: PortOptions, text: str = GROUP + VME) -> tuple[PortBench, VmeMaster]:
    """A bench whose master has asked for all inputs."""
    bench = PortBench(text, options)
    bench.begin()
    master = VmeMaster(bench.variables, options)
    bench.play(master.synchronise())
    bench.play(master.configure_inputs())
    return bench, master


@pytest.mark.manual("PAMS-070")
@pytest.mark.parametrize(("reply", "cells"), [("as_inputs", [0, 0, 2, 1]), ("first", [2, 1, 0, 0])])
def test_the_answer_to_def_out_is_in_the_cells_of_the_settings(
    reply: Literal["as_inputs", "first"], cells: list[int]
) -> None:
    bench, master = configured(PortOptions(def_out_reply=reply))
    bench.memory.write(34 // 2, [0] * 5)
    assert bench.play(master.command(Command.DEF_OUT, crc_of("DWO_MachCurrentPressure"), 9, 0)) == Answer.ACK_OK
    assert bench.memory.read(34 // 2, 4) == cells  # class 2, a word, with one item
    bench.play(master.configure_outputs())
    assert not master.mistakes


@pytest.mark.manual("PAMS-070", "PAMS-107")
def test_a_wrong_crc_is_an_error_and_the_start_up_goes_on() -> None:
    bench, master = configured(PortOptions())
    assert bench.play(master.command(Command.DEF_OUT, 0x1234, 2, 1)) == Answer.BAD_CRC
    assert bench.kernel.reports[-1] == ("07..E028", (0x1234, 0x0001_0002, 0))
    assert bench.ports.states == {"DualPort": "configuring outputs"}


@pytest.mark.manual("PAMS-076")
def test_a_rejected_start_runs_the_application_with_its_port() -> None:
    bench, master = configured(PortOptions())
    bench.play(master.configure_outputs())
    assert bench.play(master.command(Command.START)) == Answer.CDE_REJECTED
    assert bench.ports.may_run
    bench.play(master.put("DWI_MachPressure", 5))
    bench.item("DFO_MachStopped").do("set", ())
    bench.memory.write(WATCHDOG, [1])
    bench.cycles(20)
    assert bench.value("DWI_MachPressure") == 5
    assert bench.play(master.take()) == [("DFO_MachStopped", 0, True)]
    assert bench.memory.read(WATCHDOG, 1) == [0]
    assert bench.play(master.command(Command.START)) == Answer.CDE_REJECTED
    assert bench.play(master.put("DWI_MachPressure", 6))
    bench.cycles(1000)
    assert "07..E01E" in bench.kernel.codes


@pytest.mark.manual("PAMS-071")
def test_the_wait_for_start_is_limited() -> None:
    bench, master = configured(PortOptions(), LIMITED)
    bench.play(master.configure_outputs())
    bench.play(master.initialise({}))
    bench.cycles(200)
    bench.play(master.command(Command.ASK_DEF_IN))  # it is rejected, and begins the time-out again
    bench.cycles(400)
    assert bench.kernel.codes[-1] == "07..F020"


@pytest.mark.manual("PAMS-077", "PAMS-078")
@pytest.mark.parametrize(("first", "wrong"), [(0, 6), (1, 0), (1, 7)])
def test_items_are_counted_from_0_or_from_1(first: Literal[0, 1], wrong: int) -> None:
    bench, master = started_vme(options=PortOptions(first_item=first))
    at = 58 // 2 + 7 * bench.memory.read(1, 1)[0]
    bench.play(master.put("DLI_MachHeadSpeed", 7, 5))
    assert bench.memory.read(at, 4) == [6, 0, 5 + first, 7]
    bench.play(master.put("DWI_MachPressure", 3))
    assert bench.memory.read(at + 7, 4) == [5, 0, 0, 3]  # the index of a single variable is always 0
    bench.cycles(20)
    assert [bench.value("DLI_MachHeadSpeed", index) for index in range(6)] == [0, 0, 0, 0, 0, 7]
    bench.play(master.put("DLI_MachHeadSpeed", 9, -1))
    bench.cycles(20)
    assert bench.value("DLI_MachHeadSpeed", 0) == 9
    bench.item("DLO_MachHeadPosition", 3).set_value(-70_000)
    assert bench.memory.read(2074 // 2 + 2, 1) == [3 + first]
    assert bench.play(master.take()) == [("DLO_MachHeadPosition", 3, -70_000)]
    head = bench.memory.read(1, 1)[0]
    bench.memory.write(58 // 2 + 7 * head, [6, 0, wrong, 1, 0, 0, 0])
    bench.memory.write(1, [head + 1])
    bench.cycles(20)
    assert bench.kernel.reports[-1] == ("07..E02A", (6, 0, wrong))


@pytest.mark.manual("PAMS-075")
def test_the_queue_of_a_period_takes_144_changes() -> None:
    bench, master = started_vme()
    bench.cycles(21 - bench.kernel.cycle_number % 20)
    bench.kernel.reports.clear()
    for value in range(1, 151):
        bench.play(master.put("DLI_MachHeadSpeed", value, 0))
        if value % 10 == 0:
            bench.cycles()
    bench.cycles(20)
    assert [code for code, _ in bench.kernel.reports] == ["07..E02B"] * 6
    assert bench.kernel.reports[0][1][:2] == (20, 144)
    assert bench.value("DLI_MachHeadSpeed", 0) == 144


@pytest.mark.manual("PAMS-073")
def test_the_crcs_of_an_original_include_file_replace_ours(tmp_path: Path) -> None:
    path = tmp_path / "PAM_VME.H"
    path.write_text("/* original */\n#define DWI_MachPressure  0xBEEF\r\n# define DFO_MachStopped 4660\n")
    options = PortOptions(pam_vme_h=path)
    bench = PortBench(options=options)
    bench.begin()
    master = VmeMaster(bench.variables, options)
    bench.play(master.synchronise())
    crcs = []
    while bench.play(master.command(Command.ASK_DEF_IN)) == Answer.ACK_OK:
        crcs += bench.memory.read(34 // 2, 1)
    assert crcs[4:6] == [0xBEEF, crc_of("DLI_MachHeadSpeed")]
    assert bench.play(master.command(Command.DEF_OUT, 0x1234, 1, 0)) == Answer.ACK_OK
    bench.begin()
    bench.play(master.start_up({"DWI_MachPressure": 8}))
    assert not master.mistakes
    assert bench.value("DWI_MachPressure") == 8


def test_an_include_file_without_crcs_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "PAM_VME.H"
    path.write_text("#define DWI_MachPressure\n// nothing else\n")
    with pytest.raises(ValidationError, match="no line such as #define DFI_Start 0x1A2B"):
        PortOptions(pam_vme_h=path)


def started(port: str, **options: Any) -> Started:
    settings = PortOptions(**options)
    return started_vme(options=settings) if port == "vme" else started_simatic(settings)


PORTS = pytest.mark.parametrize("port", ["vme", "simatic"])


@pytest.mark.manual("PAMS-081", "PAMS-093")
@PORTS
@pytest.mark.parametrize("lost", ["until_reset", "resumes"])
def test_a_master_that_serves_the_watchdog_again_is_heard_or_not(port: str, lost: str) -> None:
    bench, master = started(port, lost_master=lost)
    bench.cycles(600)
    assert bench.kernel.codes[-1] == "07..E01E"
    bench.play(master.put("DWI_MachPressure", 5))
    bench.cycles(50)
    assert bench.value("DWI_MachPressure") == 0
    for _ in range(100):
        bench.play(master.watch())
        bench.cycles(10)
    assert bench.item("DualPort").ask("error", ()) is (lost == "until_reset")
    assert bench.value("DWI_MachPressure") == (0 if lost == "until_reset" else 5)
    bench.cycles(1000)
    assert bench.kernel.codes.count("07..E01E") == (1 if lost == "until_reset" else 2)


@pytest.mark.manual("PAMS-107")
@pytest.mark.parametrize(("text", "message", "output"), [(VME, "07..M01F", 2), (SIMATIC, "07..M01E", 0x104)])
def test_an_application_works_without_a_master(text: str, message: str, output: int) -> None:
    bench = PortBench(GROUP + text, PortOptions(without_master=True))
    bench.begin()
    before = bench.memory.read(0, 2048)
    assert bench.kernel.codes == [message]
    assert bench.ports.may_run
    bench.item("DFO_MachStopped").do("set", ())
    assert bench.value("DFO_MachStopped") is True
    bench.cycles(30_000)
    assert bench.kernel.codes == [message]
    assert not bench.item("DualPort").ask("error", ())
    assert bench.memory.read(0, 2048) == before


@pytest.mark.manual("PAMS-078", "PAMS-107")
@PORTS
def test_a_change_that_finds_the_output_fifo_full_is_lost(port: str) -> None:
    bench, master = started(port)
    for value in range(1, 201):
        bench.item("DWO_MachCurrentPressure").set_value(value)
    bench.item("DFO_MachStopped").do("set", ())
    bench.cycles()
    assert bench.kernel.codes.count("07..E008") == 1
    bench.play(master.take())
    bench.cycles()
    assert bench.play(master.take()) == []
    assert master.values["DFO_MachStopped"] == [False]
    bench.item("DWO_MachCurrentPressure").set_value(-1)
    assert bench.play(master.take()) == [("DWO_MachCurrentPressure", 0, -1)]
    for value in range(300):
        bench.item("DWO_MachCurrentPressure").set_value(value)
    assert bench.kernel.codes.count("07..E008") == 2


@pytest.mark.manual("PAMS-089")
@pytest.mark.parametrize(("byte", "cells"), [("even", [4, 2, 2]), ("odd", [0x400, 0x200, 0x200])])
def test_head_and_tail_are_in_the_byte_of_the_settings(byte: Literal["even", "odd"], cells: list[int]) -> None:
    bench, master = started_simatic(PortOptions(fifo_index_byte=byte))
    bench.play(master.put("DWI_MachPressure", 5))
    bench.cycles(20)
    bench.item("DWO_MachCurrentPressure").set_value(7)
    bench.play(master.put("DWI_MachPressure", 6))
    assert [bench.memory.read(cell, 1)[0] for cell in (HEAD_IN, TAIL_IN, HEAD_OUT)] == cells
    bench.cycles(20)
    assert bench.value("DWI_MachPressure") == 6
    assert bench.play(master.take()) == [("DWO_MachCurrentPressure", 0, 7)]
