"""Rigs that only go on hold no more memory later than before: what they keep is bounded."""

import gc
import tracemalloc
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from pam_machine import application_text, rig_of
from rig_hands import SYNC, CanMaster, ModbusClient
from ring_lab import RING

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import from_dict, load
from fieldrig.virtual.rig import Rig

pytestmark = pytest.mark.long

NOISE_BYTES = 10_000
"""Integers, floats and buffers of the moment; a cycle that left one object would leave 1,250 of them."""


def held(run: Callable[[int], object], seconds: int) -> int:
    """Bytes that this time has left; `run` lets a rig go on for a number of seconds."""
    gc.collect()
    before, _ = tracemalloc.get_traced_memory()
    run(seconds)
    gc.collect()
    after, _ = tracemalloc.get_traced_memory()
    return after - before


def held_in_the_end(run: Callable[[int], object], seconds: int) -> int:
    """Bytes that this time leaves, once as much time has filled caches and brought logs to their length."""
    tracemalloc.start()
    try:
        held(run, seconds)
        return held(run, seconds)
    finally:
        tracemalloc.stop()


def with_sync(rig: Rig, master: CanMaster, seconds: int) -> None:
    """Go on with a SYNC every 100 ms."""
    for _ in range(seconds * 10):
        master.send(SYNC)
        rig.run_until(rig.now_ns + 100 * MS)


def test_moving_ring_leaves_nothing_behind() -> None:
    with Rig(load(RING, ["time=virtual"])) as rig:
        rig.run_until(9 * S)
        client, master = ModbusClient(rig, "modbus"), CanMaster(rig, "can0")
        master.start_all()
        for axis in (0, 1):
            master.run_at(1, axis, 1_000_000)
        client.write(1300, 1)
        rig.run_until(rig.now_ns + 500 * MS)
        client.write(1301, 1, 0, 0, 0, 10_000, 0, 10_000, 0, 10_000, 0, 1_000, 0, 1)
        assert held_in_the_end(partial(with_sync, rig, master), 5) < NOISE_BYTES


def test_pam_with_moving_axes_leaves_nothing_behind(tmp_path: Path) -> None:
    application = tmp_path / "machine.pam"
    application.write_text(application_text())
    with Rig(from_dict(rig_of(application, "virtual"), tmp_path)) as rig:
        rig.run_until(3 * S)
        assert rig.get("pam", "IFV_Moving")
        assert held_in_the_end(lambda seconds: rig.run_until(rig.now_ns + seconds * S), 1) < NOISE_BYTES
