"""The cell of configs/arp-cell.yaml, driven by python canopen as its PLC: a CANopen master that is not ours.

How the film runs is in `tests/devices/masters/test_arp_cell_film.py`, with the same master in virtual time, as a busy
host stops it.  The rig runs once for all tests here; each finds it with Enable low, and nothing that asks for a start.
"""

import os
import signal
from collections.abc import Iterator
from typing import Any

import pytest
from arp_cell import (
    IO1,
    IO2,
    LINE,
    PANEL,
    RUN,
    RUNS,
    STAGE,
    STOPPED,
    TENSION,
    TERMINAL,
    UNWINDER,
    WAITS,
    Cell,
    Plc,
    plc_of,
)
from canopen.sdo.exceptions import SdoAbortedError
from running_rig import until

from fieldrig_devices.arp.terminal.settings import EDS
from fieldrig_devices.arp.user_port.client import ArpPort

pytestmark = pytest.mark.real


@pytest.fixture(scope="module")
def running_cell() -> Iterator[Cell]:
    with Cell() as cell:
        yield cell.until_ready()
        assert cell.end(signal.SIGINT) == 0, cell.output()


@pytest.fixture
def plc(running_cell: Cell) -> Iterator[Plc]:
    with plc_of(running_cell) as plc:
        plc.rest()
        yield plc


@pytest.fixture
def cell(running_cell: Cell, plc: Plc) -> Cell:
    return running_cell


def codes(node: Any) -> list[int]:
    """Error codes that a node has sent since the master started."""
    return [entry.code for entry in node.emcy.log]


# What is there


@pytest.mark.manual("ARP-010")
def test_scanner_finds_every_node_under_its_id(plc: Plc) -> None:
    plc.network.scanner.search()
    everybody = {IO1, IO2, PANEL, LINE, UNWINDER, TERMINAL}
    until(lambda: everybody <= set(plc.network.scanner.nodes))
    assert set(plc.network.scanner.nodes) == everybody


def test_cards_say_what_they_are(plc: Plc) -> None:
    for node, number, name in ((plc.line, 1, "line"), (plc.unwinder, 2, "tension")):
        assert node.sdo[0x1008].raw == "ARP"
        assert node.sdo[0x1018][2].raw == 0xA29
        assert node.sdo[0x1018][4].raw == node.sdo["Number of the card"].raw == number
        assert node.sdo["Name of the program"].raw.lower() == name


@pytest.mark.manual("ARP-119")
def test_terminal_is_a_canopen_node(plc: Plc) -> None:
    terminal: Any = plc.network.add_node(TERMINAL, str(EDS))
    assert terminal.sdo[0x1008].raw == "TR4"
    assert terminal.sdo[0x1018][2].raw == 4


@pytest.mark.manual("ARP-003")
def test_exchange_of_the_cards_is_in_their_pdo_parameters(plc: Plc) -> None:
    sent, received = plc.line.sdo, plc.unwinder.sdo
    assert sent[0x1804][1].raw == received[0x1404][1].raw == 0x240 + LINE
    assert [sent[0x1A04][entry].raw for entry in (1, 2)] == [0x2000_0220, 0x2010_0320]  # V2, F65 to F96
    assert [received[0x1604][entry].raw for entry in (1, 2)] == [0x2000_6420, 0x2010_0320]  # V100
    plc.put(TENSION, 123_456)
    until(lambda: received[0x2000][100].raw == 123_456)


# Commands


def test_enable_runs_the_programs_and_ends_the_emergency(plc: Plc) -> None:
    assert plc.line.sdo[0x2103].raw == 105
    plc.enable(True)
    until(lambda: codes(plc.line)[-1:] == codes(plc.unwinder)[-1:] == [0x0000])
    assert plc.line.sdo[0x2103].raw == 0
    plc.enable(False)
    until(lambda: codes(plc.line)[-1:] == codes(plc.unwinder)[-1:] == [0x9000])


def test_commands_that_do_not_fit_are_refused(plc: Plc) -> None:
    for index, subindex, data, code in (
        (0x2100, 0, "01", 0x0800_0022),  # run, with Enable low
        (0x2011, 1, "01000000", 0x0800_0022),  # an output that is held at 0
        (0x2300, 6, "400d0300", 0x0609_0030),  # 200 kbaud
        (0x2302, 21, "efd8ffff", 0x0609_0032),  # a gear of -10.001
        (0x2200, 1, "00000000", 0x0601_0002),  # a position
        (0x2000, 251, "00000000", 0x0609_0011),  # V251 is 2001h sub-index 1
    ):
        with pytest.raises(SdoAbortedError) as refused:
            plc.line.sdo.download(index, subindex, bytes.fromhex(data))
        assert refused.value.code == code, hex(index)


def test_program_is_stopped_and_started_again(plc: Plc) -> None:
    plc.enable(True)
    plc.line.sdo["Command"].raw = 2
    until(lambda: plc.line.sdo["State"].raw == STOPPED)
    plc.put(STAGE, 9_000)
    plc.line.sdo["Command"].raw = 1
    until(lambda: plc.variable(STAGE) == WAITS)
    assert plc.line.sdo["State"].raw == RUN


def test_variables_of_all_blocks_and_parameters_are_kept(plc: Plc) -> None:
    for number, raw in ((999, -1), (1000, 2_147_483_647), (500, 1)):
        block, offset = divmod(number - 1, 250)
        variable = plc.line.sdo[0x2000 + block][offset + 1]
        variable.raw = raw
        assert variable.raw == raw
    gain = plc.line.sdo["Parameters of axis 2"]["@Par2[13] KD"]
    gain.raw = 4
    assert gain.raw == 4
    plc.enable(True)
    assert gain.raw == 3  # a start takes the copy in flash


# The I/O modules


@pytest.mark.manual("ARP-040")
def test_remote_inputs_arrive_at_the_card_and_the_master(cell: Cell, plc: Plc) -> None:
    cell.put("io1/6000:02", 0x80)
    cell.put("io2/6000:04", 0x01)
    until(lambda: plc.line.sdo[0x2012][2].raw == 0x8000)  # I216
    until(lambda: plc.line.sdo[0x2012][3].raw == 0x0100_0000)  # I325
    cell.put("io1/6000:02", 0)
    cell.put("io2/6000:04", 0)
    until(lambda: plc.line.sdo[0x2012][2].raw == plc.line.sdo[0x2012][3].raw == 0)


@pytest.mark.manual("ARP-040")
def test_master_sets_remote_outputs_through_the_card(cell: Cell, plc: Plc) -> None:
    plc.enable(True)
    plc.line.sdo[0x2011][2].raw = 0x8000_0000  # O232
    until(lambda: cell.value("io1/6200:04") == 0x80)
    plc.enable(False)
    until(lambda: cell.value("io1/6200:04") == 0)


def test_a_button_at_the_remote_module_starts_the_film(cell: Cell, plc: Plc) -> None:
    plc.enable(True)
    cell.put("io1/6000:01", 1)  # I201
    until(lambda: plc.variable(STAGE) == RUNS)
    cell.put("io1/6000:01", 2)  # I202
    until(lambda: plc.variable(STAGE) == WAITS)
    cell.put("io1/6000:01", 0)


def test_a_pulled_module_is_an_emergency_and_the_film_runs_on(cell: Cell, plc: Plc) -> None:
    plc.run()
    restarts = cell.status()["processes"]["io2"]["restarts"]
    cell.put("io2/6000:01", 1)
    until(lambda: plc.line.sdo[0x2012][3].raw == 1)
    plc.line.emcy.log.clear()
    os.kill(cell.pid("io2"), signal.SIGKILL)
    until(lambda: 0x8130 in codes(plc.line))
    assert plc.line.emcy.log[-1].data == bytes.fromhex("6a 00 00 03 00")  # 106, no axis, run
    assert plc.line.sdo[0x2103].raw == 106
    assert plc.variable(STAGE) == RUNS
    cell.until_back("io2", restarts + 1)
    plc.enable(False)
    plc.enable(True)
    until(lambda: plc.line.sdo[0x2103].raw == 0)
    until(lambda: codes(plc.line)[-1] == 0)
    assert codes(plc.unwinder)[-1:] in ([], [0])


# USER ports, while a master is at work


def test_user_ports_answer_on_pty_and_tcp(cell: Cell, plc: Plc) -> None:
    ports = (str(cell.run / "line-user"), 1), (f"socket://127.0.0.1:{cell.user_port}", 2)
    for port, number in ports:
        with ArpPort.open(port) as card:
            assert card.hello().number == number
            assert card.condition().error == 105
