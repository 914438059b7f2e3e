"""The program of the wrapper in configs/machine.yaml: packs, interlocks, and axes that it shares with other masters."""

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest
from in_fork import SHARED
from rig_hands import CanMaster, ModbusClient

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import load
from fieldrig.pytest_plugin import RigMaker
from fieldrig.virtual.rig import Rig

pytestmark = [pytest.mark.system, pytest.mark.in_fork]

RIG = Path(__file__).parents[2] / "configs/machine.yaml"
DRIVES = ("infeed", "film", "jaw", "outfeed")
AUTOMATIC, STATE, FAILURES = 32768, 32769, 32772
"""Registers of the program's markers: the order of the client, the state with the packs behind it, and failures."""
MANUAL, RUNNING = 0, 3
PACK = 2400.0
"""Increments of the film encoder for one pack."""


def modbus_client(rig: Rig) -> ModbusClient:
    return ModbusClient(rig, "modbus")


@pytest.fixture(scope=SHARED)
def rig() -> Iterator[Rig]:
    """The machine, booted, while its film runs."""
    with Rig(load(RIG, ["time=virtual"])) as rig:
        rig.run_until(5 * S)
        rig.set("line", "F33", True)
        rig.run_until(8 * S)
        assert rig.get("max4", "I_bFilmRuns.Value") is True
        yield rig


def speeds(rig: Rig) -> list[int]:
    """The speeds of the drives in whole revolutions a minute."""
    return [round(float(rig.get(name, "speed"))) for name in DRIVES]


def test_the_program_makes_packs_while_the_film_runs(rig: Rig) -> None:
    client = modbus_client(rig)
    client.write(AUTOMATIC, 1)
    rig.run_until(rig.now_ns + 3 * S)
    state, packs = client.read(STATE, 2)
    assert state == RUNNING
    film = float(rig.get("max4", "FilmEncoder.Velocity")) / PACK  # packs a second
    infeed, drawn, _, outfeed = speeds(rig)
    assert [infeed, drawn, outfeed] == pytest.approx([60 * film * turns for turns in (1, 2, 1.2)], abs=2)
    before = float(rig.get("max4", "FilmEncoder.Position"))
    rig.run_until(rig.now_ns + 10 * S)
    made = (float(rig.get("max4", "FilmEncoder.Position")) - before) / PACK
    assert client.read(STATE, 2) == [RUNNING, pytest.approx(packs + made, abs=1)]
    assert rig.get("max4", "O_bLampH1.Value") is True
    client.write(AUTOMATIC, 0)
    rig.run_until(rig.now_ns + 4 * S)
    assert (client.read(STATE), speeds(rig)) == ([MANUAL], [0, 0, 0, 0])
    assert (client.read(FAILURES), rig.get("max4", "DiagCode")) == ([0], 0)


def test_the_belts_start_and_stop_on_a_running_film_without_a_jump(rig: Rig) -> None:
    client, places = modbus_client(rig), []
    for turn in range(1500):
        if turn in (0, 900):
            client.write(AUTOMATIC, int(turn == 0))
        rig.run_until(rig.now_ns + 4 * MS)
        places.append(float(rig.get("max4", "film.SetValue")))
    ways = [later - earlier for earlier, later in pairwise(places)]
    # the start and the stop cam last for one pack of the film, about a second; a jump would be a whole way at once
    assert max(ways) > 7_000
    assert max(abs(later - earlier) for earlier, later in pairwise(ways)) < max(ways) / 20


def test_no_pack_is_made_without_film(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    rig.run_until(5 * S)
    client = modbus_client(rig)
    client.write(AUTOMATIC, 1)
    rig.run_until(rig.now_ns + 2 * S)
    assert (client.read(STATE, 2), speeds(rig)) == ([MANUAL, 0], [0, 0, 0, 0])


def test_a_canopen_master_takes_an_axis_over_and_the_program_stops_the_others(rig: Rig) -> None:
    client, master = modbus_client(rig), CanMaster(rig, "can2")
    client.write(AUTOMATIC, 1)
    rig.run_until(rig.now_ns + 3 * S)
    master.run_at(1, DRIVES.index("film"), 500_000)
    rig.run_until(rig.now_ns + 4 * S)
    assert client.read(STATE) == [MANUAL]
    assert client.read(FAILURES) == [1]
    assert speeds(rig) == [0, 30, 0, 0]
    client.write(AUTOMATIC, 0)
    rig.run_until(rig.now_ns + S)
    assert speeds(rig) == [0, 30, 0, 0]  # the program leaves the axis alone
    client.write(AUTOMATIC, 1)
    rig.run_until(rig.now_ns + 4 * S)
    assert client.read(STATE) == [RUNNING]  # and takes it over when automatic operation begins
    infeed, film, _, _ = speeds(rig)
    assert film == pytest.approx(2 * infeed, abs=2)
    master.write(1, 0x6040 + 0x800 * DRIVES.index("film"), 0, 0, 2)  # disables an axis that it controls no longer
    rig.run_until(rig.now_ns + S)
    assert client.read(STATE) == [RUNNING]


def test_a_modbus_master_takes_an_axis_over(rig: Rig) -> None:
    client = modbus_client(rig)
    client.write(AUTOMATIC, 1)
    rig.run_until(rig.now_ns + 3 * S)
    client.write(1000 + 100 * DRIVES.index("outfeed") + 1, 1, 0, 0, 0, 10_000, 0, 10_000, 0, 10_000, 0, 500, 0, 1)
    rig.run_until(rig.now_ns + 4 * S)
    assert client.read(STATE) == [MANUAL]
    assert speeds(rig) == [0, 0, 0, 30]


def test_the_emergency_stop_ends_automatic_operation(rig: Rig) -> None:
    client = modbus_client(rig)
    client.write(AUTOMATIC, 1)
    rig.run_until(rig.now_ns + 3 * S)
    rig.set("panel", "6200:01", 0)
    rig.run_until(rig.now_ns + 2 * S)
    assert (client.read(STATE), speeds(rig)) == ([MANUAL], [0, 0, 0, 0])
    rig.set("panel", "6200:01", 1)
    rig.run_until(rig.now_ns + 2 * S)
    assert client.read(STATE) == [MANUAL]  # nothing starts by itself
