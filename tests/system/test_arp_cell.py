"""The programs and the iron of configs/arp-cell.yaml in virtual time."""

from pathlib import Path

import pytest

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import load
from fieldrig.pytest_plugin import RigMaker
from fieldrig.virtual.rig import Rig

CONFIGS = Path(__file__).parents[2] / "configs"
CELL = "configs/arp-cell.yaml"

pytestmark = pytest.mark.system


@pytest.fixture
def cell(fieldrig_rig: RigMaker) -> Rig:
    """Enabled a second ago."""
    rig = fieldrig_rig(CELL)
    rig.run_until(100 * MS)
    assert rig.get("line", "error") == rig.get("unwinder", "error") == 105
    rig.set("panel", "6200:01", 1)
    rig.run_until(1 * S)
    assert rig.get("line", "state") == rig.get("unwinder", "state") == "run"
    return rig


def press(rig: Rig, inputs: int) -> None:
    """I201 starts, I202 stops."""
    rig.set("io1", "6000:01", inputs)
    wait(rig, 0.1)
    rig.set("io1", "6000:01", 0)


def wait(rig: Rig, seconds: float) -> None:
    rig.run_until(rig.now_ns + round(seconds * S))


def number(rig: Rig, device: str, key: str) -> float:
    value = rig.get(device, key)
    assert not isinstance(value, str)
    return value


def test_tension_reaches_its_set_point_and_is_kept(cell: Rig) -> None:
    press(cell, 1)
    wait(cell, 6)
    assert number(cell, "roll", "tension") == pytest.approx(100, abs=1.5)
    cell.set("line", "V1", 100)  # 600 mm/s
    tensions = []
    for _ in range(300):
        wait(cell, 0.01)
        tensions.append(number(cell, "roll", "tension"))
    assert 85 < min(tensions) < max(tensions) < 120  # the roll is brought to speed
    cell.set("line", "V2", 150)
    wait(cell, 4)
    assert number(cell, "roll", "tension") == pytest.approx(150, abs=1.5)
    assert cell.get("line", "error") == cell.get("unwinder", "error") == 0


@pytest.mark.manual("ARP-003")
def test_measure_and_set_point_are_exchanged(cell: Rig) -> None:
    press(cell, 1)
    wait(cell, 6)
    assert cell.get("unwinder", "V100") == cell.get("line", "V2") == 100
    assert number(cell, "line", "V21") == pytest.approx(number(cell, "unwinder", "V128"), abs=1)


def test_knife_follows_the_film_and_sheets_are_counted(cell: Rig) -> None:
    press(cell, 1)
    wait(cell, 4)
    turns, film = number(cell, "knife", "position"), number(cell, "nip", "position")
    sheets = number(cell, "line", "V22")
    wait(cell, 20)  # 6 m of film
    turned = (number(cell, "knife", "position") - turns) / (2 * 3.141593)
    passed_m = (number(cell, "nip", "position") - film) / (2 * 3.141593) * 0.5
    assert passed_m == pytest.approx(6, abs=0.1)
    assert turned == pytest.approx(passed_m, abs=0.15)  # a sheet is a metre and a turn
    assert number(cell, "line", "V22") - sheets == 6


def test_glue_and_mark_are_digital_cams_on_the_film(cell: Rig) -> None:
    press(cell, 1)
    wait(cell, 3)
    glued, marked = set(), set()
    for _ in range(350):
        wait(cell, 0.01)
        position = number(cell, "line", "axis2.position")
        glued |= {position} if cell.get("line", "O102") else set()
        marked |= {position} if cell.get("line", "O201") else set()
    assert 50 <= min(glued) < 60
    assert 140 < max(glued) <= 151
    assert 500 <= min(marked) < 510
    assert 690 < max(marked) <= 701


def test_torn_film_stops_the_line(cell: Rig) -> None:
    press(cell, 1)
    wait(cell, 6)
    cell.set("roll", "break_web", True)
    wait(cell, 3)
    assert cell.get("line", "V20") == 0
    assert cell.get("line", "F292") is True  # the nip stands
    assert cell.get("roll", "torque") == 0


def test_stop_lets_the_tension_go(cell: Rig) -> None:
    press(cell, 1)
    wait(cell, 4)
    press(cell, 2)
    wait(cell, 4)
    assert cell.get("line", "V20") == 0
    assert number(cell, "roll", "tension") < 11  # the drag brake holds 2 Nm at 0.2 m
    assert cell.get("line", "O301") is False


def test_enable_takes_everything_off_at_once(cell: Rig) -> None:
    press(cell, 1)
    wait(cell, 4)
    cell.set("panel", "6200:01", 0)
    wait(cell, 0.1)
    assert cell.get("line", "state") == cell.get("unwinder", "state") == "reset_enable"
    assert cell.get("nip", "torque") == cell.get("knife", "torque") == cell.get("roll", "torque") == 0
    assert cell.get("io2", "6200:01") == 0


def test_the_same_bytes_at_every_run() -> None:
    def trace() -> list[object]:
        with Rig(load(CONFIGS / "arp-cell.yaml", ["time=virtual"])) as rig:
            heard: list[object] = []
            rig.attach("ear").link("can0").on_receive(heard.append)
            rig.set("panel", "6200:01", 1)
            rig.run_until(200 * MS)
            rig.set("io1", "6000:01", 1)
            rig.run_until(3 * S)
            return heard

    first = trace()
    assert len(first) > 500
    assert trace() == first
