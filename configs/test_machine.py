"""The whole machine in virtual time: the ring of drives comes up beside the film and the glue."""

from pathlib import Path

from fieldrig.clock import S
from fieldrig.pytest_plugin import RigMaker

RIG = Path(__file__).with_name("machine-virtual.yaml")


def test_the_ring_comes_up_beside_the_film_and_the_glue(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    while not rig.get("max4", "booted"):
        rig.run_until(rig.now_ns + S)
    rig.run_until(rig.now_ns + 2 * S)
    assert (rig.get("max4", "ring.state"), rig.get("max4", "DiagCode")) == ("up", 0)
    assert rig.get("tank", "level") == 0.5
