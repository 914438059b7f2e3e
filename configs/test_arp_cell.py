"""The ARP cell in virtual time: the cards run their programs, and the film is kept at 100 N."""

from pathlib import Path

from fieldrig import RigMaker, S

RIG = Path(__file__).with_name("arp-cell.yaml")
FILM_RUNS = 3


def test_the_tension_is_100_n_while_the_film_runs(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    rig.set("panel/6200:01", 1)  # Enable
    rig.run_until(1 * S)
    rig.set("line/F33", True)  # start
    rig.run_until(8 * S)
    assert rig.get("line/V20") == FILM_RUNS
    tension_n = rig.get("roll/tension")
    assert isinstance(tension_n, float)
    assert 98 < tension_n < 102
