"""A controller and its drives on a ring in virtual time: the same bytes each time, in one process or many."""

from pathlib import Path
from typing import Any

import pytest

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS
from fieldrig.config import from_dict
from fieldrig.rig import Rig

PLATE = Path(__file__).parents[2] / "configs/plates/sm-100-30-080.yaml"
DRIVES = {"belt": 3, "lift": 1, "knife": 2}
Line = tuple[int, str, str, bytes]


def trace_of(seed: int, processes: str) -> list[Line]:
    """From power-on to a ring in operation, through distortion by chance, a break and its healing."""
    rig = {
        "time": "virtual",
        "seed": seed,
        "processes": processes,
        "buses": {"ring0": {"kind": "ring.virtual"}, "wires": {"kind": "wires.virtual"}},
        "devices": {
            "max4": {
                "kind": "max4",
                "links": {"ring": "ring0", "wires": "wires"},
                "drives": {name: {"ring_address": address} for name, address in DRIVES.items()},
            },
            **{
                name: {
                    "kind": "mc4",
                    "ring_address": address,
                    "motor": {"name_plate": str(PLATE)},
                    "links": {"ring": "ring0", "wires": "wires"},
                }
                for name, address in DRIVES.items()
            },
        },
    }
    lines: list[Line] = []

    def on_delivery(bus: Bus[Any], delivery: Delivery[Any]) -> None:
        lines.append((delivery.time_ns, bus.name, delivery.sender, bus.encode(delivery.message)))

    with Rig(from_dict(rig), on_delivery) as running:
        running.run_until(1_800 * MS)
        running.add_fault("ring0", {"what": "distort", "station": "lift", "telegram": "at", "probability": 0.3})
        running.run_until(1_900 * MS)
        number = running.add_fault("ring0", {"what": "break", "after": "belt"})
        running.run_until(1_950 * MS)
        running.clear_fault("ring0", number)
        running.run_until(2_000 * MS)
    return lines


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others() -> None:
    first = trace_of(7, "one")
    assert len(first) > 1_000
    assert first == trace_of(7, "one")
    assert first != trace_of(8, "one")


@pytest.mark.system
def test_a_process_for_each_device_gives_the_same_bytes() -> None:
    assert trace_of(7, "each") == trace_of(7, "one")
