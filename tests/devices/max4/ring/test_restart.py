"""A controller that is switched off and on while its ring runs is the only master of the ring, and brings it up."""

from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS, S
from fieldrig.config.rig_file import load
from fieldrig.virtual.rig import Rig
from fieldrig_bus.ring.sercos.message import Cycle

CONVEYOR = Path(__file__).parents[4] / "configs/conveyor.yaml"


@pytest.mark.long
def test_a_controller_that_was_restarted_sends_one_mst_in_a_cycle_and_has_its_axes_again() -> None:
    """It once powered up twice, as its faults were given to it before it started."""
    cycles: Counter[int] = Counter()

    def count(bus: Bus[Any], delivery: Delivery[Any]) -> None:
        if isinstance(delivery.message, Cycle):
            cycles[delivery.time_ns // MS] += 1

    with Rig(load(CONVEYOR, ["time=virtual"])) as rig:
        rig.run_until(5 * S)
        before = rig.get("max4/Cutter.MC4State")
        rig.restart("max4")
        rig.run_for(10 * MS)  # until what it has sent before is heard
        end = rig.on_delivery(count)
        rig.run_for(500 * MS)
        end()
        assert max(cycles.values()) == 1
        rig.run_for(4500 * MS)
        assert (rig.get("max4/Cutter.MC4State"), rig.get("max4/DiagCode")) == (before, 0)
