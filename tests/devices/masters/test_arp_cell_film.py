"""The film of configs/arp-cell.yaml, driven by python canopen as its PLC, unchanged, in virtual time.

A film needs cards that are never late; in real time `tests/real/test_arp_cell.py` starts it, and asks no more of it.
"""

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest
from arp_cell import LINE, SHEETS, SPEED, STAGE, STOP, WAITS, Plc
from canopen_network import network_on
from running_rig import until

from fieldrig import Rig
from fieldrig.pytest_plugin import MasterRigMaker

pytestmark = [pytest.mark.lean, pytest.mark.long, pytest.mark.timeout(120)]
CELL = Path(__file__).parents[3] / "configs" / "arp-cell.yaml"


@pytest.fixture
def cell(fieldrig_master: MasterRigMaker) -> Rig:
    rig = fieldrig_master(CELL)
    assert isinstance(rig, Rig)
    return rig


@pytest.fixture
def plc(cell: Rig) -> Iterator[Plc]:
    with network_on({"interface": "fieldrig", "channel": "can0"}) as network:
        plc = Plc(network)
        plc.rest()
        yield plc


def tension(cell: Rig) -> float:
    return float(cell.get("roll/tension"))


def test_film_runs_at_its_tension_and_is_cut(cell: Rig, plc: Plc) -> None:
    plc.network.send_message(0x300 + LINE, bytes.fromhex("50 c3 00 00 c0 d4 01 00"))  # RPDO 2: 50 %, 120 N
    plc.run()
    until(lambda: plc.variable(SHEETS) >= 1_000)
    assert tension(cell) == pytest.approx(120, abs=2)
    assert abs(plc.unwinder.sdo[0x2000][128].raw - 120_000) < 2_000
    assert plc.speed() == pytest.approx(300, abs=30)  # of 600 mm/s
    assert abs(plc.line.sdo[0x2202][1].raw) < 30_000  # the knife follows its cam
    assert plc.line.sdo[0x2103].raw == plc.unwinder.sdo[0x2103].raw == 0
    plc.ask_for(STOP)
    until(lambda: plc.variable(STAGE) == WAITS)
    until(lambda: tension(cell) < 11)  # the drag brake holds 2 Nm at 0.2 m


def test_pdos_tell_positions_and_flags_while_it_runs(plc: Plc) -> None:
    heard: list[tuple[int, ...]] = []
    plc.line.tpdo.read()
    plc.run()
    plc.line.tpdo[2].add_callback(lambda pdo: heard.append(tuple(variable.raw for variable in pdo)))
    until(lambda: len(heard) > 50)
    knife, nip = zip(*heard, strict=True)
    assert all(0 <= position <= 360_000 for position in knife)
    assert all(0 <= position <= 1_000_000 for position in nip)
    assert all((after - before) % 1_000_000 > 0 for before, after in pairwise(nip)), "the film moves on in each cycle"
    # F261: the knife is in its cam; F296: axis 2 has its final speed
    until(lambda: bool(plc.line.tpdo[4][0].raw >> 4 & 1 and plc.line.tpdo[4][1].raw >> 7 & 1))


def test_speed_is_a_variable(plc: Plc) -> None:
    plc.run()
    until(lambda: abs(plc.speed() - 300) < 30)
    plc.put(SPEED, 80_000)
    until(lambda: abs(plc.speed() - 480) < 30)


def test_digital_cam_drives_an_output_of_the_remote_module(cell: Rig, plc: Plc) -> None:
    plc.run()
    mark = cell.get("line/O201")
    until(lambda: cell.get("line/O201") is not mark)
    until(lambda: cell.get("io1/6200:01") == 1)
    until(lambda: cell.get("io1/6200:01") == 0)
    until(lambda: cell.get("io2/6200:01") == 1)  # O301: it runs


def test_terminal_shows_what_the_cards_exchange(cell: Rig, plc: Plc) -> None:
    plc.run()
    until(lambda: abs(tension(cell) - 100) < 5)

    def shown() -> float:
        line = cell.get("terminal/screen.4")
        assert isinstance(line, str)
        return float(line.removeprefix("TENSION"))

    until(lambda: 90 < shown() < 110)
