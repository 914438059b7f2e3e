"""The labelling machine in virtual time: the same bytes on every bus, in one process or in one for each device."""

from pathlib import Path
from typing import Any

import pytest

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS
from fieldrig.config.rig_file import load
from fieldrig.virtual.rig import Rig

pytestmark = [pytest.mark.system, pytest.mark.timeout(400)]

RIG = Path(__file__).parents[2] / "configs/pam-machine.yaml"
Line = tuple[int, str, str, bytes]


def trace_of(processes: str) -> list[Line]:
    """Return the trace from power-on to the search of the knife's zero switch, and a break of the ring."""
    lines: list[Line] = []

    def on_delivery(bus: Bus[Any], delivery: Delivery[Any]) -> None:
        lines.append((delivery.time_ns, bus.name, delivery.sender, bus.encode(delivery.message)))

    with Rig(load(RIG, ["time=virtual", f"processes={processes}"]), on_delivery) as rig:
        rig.run_until(700 * MS)
        rig.set("keys", "key3", True)
        rig.run_until(1_000 * MS)
        assert rig.get("cutter", "speed") != 0.0
        rig.add_fault("pamring", {"what": "break", "after": "cutter"})
        rig.run_until(1_100 * MS)
        assert rig.get("pam", "state") == "fatal"
    return lines


def test_labelling_machine_says_in_one_process_what_it_says_in_many() -> None:
    one = trace_of("one")
    assert {bus for _, bus, _, _ in one} >= {"pamring", "dualport", "wires"}
    assert one == trace_of("each")
