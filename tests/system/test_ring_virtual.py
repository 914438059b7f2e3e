"""A controller and its drives on a ring in virtual time: the same bytes each time, in one process or many."""

from pathlib import Path
from typing import Any

import pytest

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig

PLATE = Path(__file__).parents[2] / "configs/plates/sm-100-30-080.yaml"
DRIVES = {"belt": 3, "lift": 1, "knife": 2}
MANY = {f"axis{address}": address for address in range(1, 13)}
Line = tuple[int, str, str, bytes]


def line_of(drives: dict[str, int], seed: int, processes: str) -> dict[str, Any]:
    return {
        "time": "virtual",
        "seed": seed,
        "processes": processes,
        "buses": {"ring0": {"kind": "ring.virtual"}, "wires": {"kind": "wires.virtual"}},
        "devices": {
            "max4": {
                "kind": "max4",
                "links": {"ring": "ring0", "wires": "wires"},
                "drives": {name: {"ring_address": address} for name, address in drives.items()},
            },
            **{
                name: {
                    "kind": "mc4",
                    "ring_address": address,
                    "motor": {"name_plate": str(PLATE)},
                    "links": {"ring": "ring0", "wires": "wires"},
                }
                for name, address in drives.items()
            },
        },
    }


class Lines(list[Line]):
    def on_delivery(self, bus: Bus[Any], delivery: Delivery[Any]) -> None:
        self.append((delivery.time_ns, bus.name, delivery.sender, bus.encode(delivery.message)))


def trace_of(seed: int, processes: str) -> list[Line]:
    """Return the trace from power-on to a ring in operation, with random distortion, and a break and its recovery."""
    lines = Lines()
    with Rig(from_dict(line_of(DRIVES, seed, processes)), lines.on_delivery) as running:
        running.run_until(1_800 * MS)
        running.add_fault("ring0", {"what": "distort", "station": "lift", "telegram": "at", "probability": 0.3})
        running.run_until(1_900 * MS)
        number = running.add_fault("ring0", {"what": "break", "after": "belt"})
        running.run_until(1_950 * MS)
        running.clear_fault("ring0", number)
        running.run_until(2_000 * MS)
    return lines


@pytest.mark.long
def test_the_same_seed_gives_the_same_bytes_and_another_seed_others() -> None:
    first = trace_of(7, "one")
    assert len(first) > 1_000
    assert first == trace_of(7, "one")
    assert first != trace_of(8, "one")


def many_at_work(processes: str) -> list[Line]:
    """Enabled, pulled at, asked."""
    lines = Lines()
    with Rig(from_dict(line_of(MANY, 7, processes)), lines.on_delivery) as running:
        running.run_until(2_400 * MS)
        for name in MANY:
            running.set("max4", f"{name}.ControllerEnable", True)
        running.run_until(3_200 * MS)
        for torque_nm, name in enumerate(list(MANY)[:6]):
            running.set(name, "load_torque", torque_nm / 3)
            running.run_until(running.now_ns + 9 * MS)
        running.add_fault("ring0", {"what": "distort", "station": "axis9", "telegram": "mdt", "count": 1})
        running.run_until(running.now_ns + 70 * MS)
    return lines


@pytest.mark.system
def test_drives_at_work_in_one_process_say_what_each_says_in_its_own() -> None:
    assert many_at_work("one") == many_at_work("each")


@pytest.mark.system
def test_a_process_for_each_device_gives_the_same_bytes() -> None:
    assert trace_of(7, "each") == trace_of(7, "one")
