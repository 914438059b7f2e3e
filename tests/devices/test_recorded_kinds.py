"""Recordings of every kind of device: its own cycle is the rhythm, and the buses carry the same with and without it."""

from pathlib import Path
from typing import Any

import pytest
from every_kind import whole

from fieldrig.clock import MS
from fieldrig.config.kinds import find_device
from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig

BEGIN_NS, LENGTH_NS = 30 * MS, 60 * MS
RESTING = 1
"""Samples of a device whose cycle rests in this time."""
STANDING = "cia402.drive"
"""A kind whose cycle rests while it stands."""
COUNTERS = {"max4": "cycles", "pam": "cycle", "arp": "cycles"}
"""Points that count the cycles of a kind."""


def signals_of(rig: Rig) -> list[str]:
    """Return every seventh point of each device: a reading changes nothing, whatever else is read."""
    return [f"{device}/{key}" for device in rig.config.devices for key in list(rig.keys(device))[::7]]


@pytest.mark.long
def test_a_recording_of_every_kind_changes_nothing_on_any_bus(tmp_path: Path) -> None:
    def trace(is_recorded: bool) -> list[Any]:
        heard: list[Any] = []
        with Rig(from_dict(whole(tmp_path)), lambda bus, delivery: heard.append((bus.name, delivery))) as rig:
            rig.run_until(BEGIN_NS)
            if is_recorded:
                rig.record(signals_of(rig))
            rig.run_for(LENGTH_NS)
        return heard

    assert trace(True) == trace(False)


@pytest.mark.long
def test_a_kind_with_a_cycle_is_sampled_in_each_of_them(tmp_path: Path) -> None:
    with Rig(from_dict(whole(tmp_path))) as rig:
        rig.run_until(BEGIN_NS)
        kinds = {name: entry.kind for name, entry in rig.config.devices.items()}
        cyclic = [name for name, kind in kinds.items() if find_device(kind).has_cycle]
        counted = {name: f"{name}/{COUNTERS[kinds[name]]}" for name in cyclic if kinds[name] in COUNTERS}
        first = {name: f"{name}/{next(iter(rig.keys(name)))}" for name in cyclic}
        recording = rig.record([*first.values(), *counted.values()])
        before = {name: rig.get(signal) for name, signal in counted.items()}
        rig.run_for(LENGTH_NS)
        for name, signal in counted.items():
            passed = int(rig.get(signal)) - int(before[name])
            assert passed > RESTING
            assert list(recording.values[signal]) == [int(before[name]) + number for number in range(1, passed + 1)]
        rows = {name: len(recording.times_ns[signal]) for name, signal in first.items()}
    working = {kinds[name] for name, number in rows.items() if number > RESTING}
    assert working | {STANDING} == {kinds[name] for name in cyclic}
