"""Rigs that only go on hold no more memory later than before: what they keep is bounded."""

import gc
import tracemalloc

import pytest
from rig_hands import SYNC, CanMaster, ModbusClient
from ring_lab import RING

from fieldrig.clock import MS, S
from fieldrig.config import load
from fieldrig.rig import Rig

pytestmark = pytest.mark.long

NOISE_BYTES = 10_000
"""Integers, floats and buffers of the moment; a cycle that left one object would leave 1,250 of them."""


def held(rig: Rig, seconds: int, master: CanMaster) -> int:
    """Bytes that this time has left."""
    gc.collect()
    before, _ = tracemalloc.get_traced_memory()
    for _ in range(seconds * 10):
        master.send(SYNC)
        rig.run_until(rig.now_ns + 100 * MS)
    gc.collect()
    after, _ = tracemalloc.get_traced_memory()
    return after - before


def test_moving_ring_leaves_nothing_behind() -> None:
    with Rig(load(RING)) as rig:
        rig.run_until(9 * S)
        client, master = ModbusClient(rig, "modbus"), CanMaster(rig, "can0")
        master.start_all()
        for axis in (0, 1):
            master.run_at(1, axis, 1_000_000)
        client.write(1300, 1)
        rig.run_until(rig.now_ns + 500 * MS)
        client.write(1301, 1, 0, 0, 0, 10_000, 0, 10_000, 0, 10_000, 0, 1_000, 0, 1)
        tracemalloc.start()
        try:
            held(rig, 5, master)  # caches fill, logs come to their length
            assert held(rig, 5, master) < NOISE_BYTES
        finally:
            tracemalloc.stop()
