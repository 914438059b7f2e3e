"""The ARP cell in virtual time: the cards run their programs, and the film is kept at 100 N."""

from pathlib import Path

from fieldrig import MS, RigMaker, S

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


def test_slack_film_is_taken_up_gently_after_an_emergency_stop(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    rig.set("panel/6200:01", 1)
    rig.run_until(1 * S)
    rig.set("line/F33", True)
    rig.run_until(5 * S)
    rig.set("line/F33", False)
    rig.set("panel/6200:01", 0)  # Enable opens while the film runs, and the roll goes on for a moment
    rig.run_for(3 * S)
    slack_m = rig.get("roll/slack")
    assert isinstance(slack_m, float)
    assert 0.1 < slack_m < 0.3
    rig.set("panel/6200:01", 1)
    rig.run_for(1 * S)  # the programs of the cards begin again
    rig.set("line/F33", True)
    for _ in range(500):
        rig.run_for(10 * MS)
        tension_n = rig.get("roll/tension")
        assert isinstance(tension_n, float)
        assert tension_n < 200
    assert rig.get("line/V20") == FILM_RUNS
