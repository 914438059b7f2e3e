"""Garbage in circles that is older than a block, in a process of its own: that of the tests is frozen as a whole."""

import subprocess
import sys

import pytest

pytestmark = pytest.mark.system

PROGRAM = """
import gc

from fieldrig import Rig, from_dict, virtual_time

class Bus:
    def __init__(self):
        self.itself = self

    def __del__(self):
        print("closed")

gc.disable()
Bus()
with Rig(from_dict({"time": "virtual", "buses": {}, "devices": {}})) as rig:
    with virtual_time(rig):
        gc.collect()
        print("end of the block")
    gc.collect()
    gc.freeze()
    with virtual_time(rig):
        pass
    print("still frozen:", gc.get_freeze_count() > 0)
"""


def test_what_an_earlier_test_has_left_ends_after_the_block_and_what_is_frozen_stays_so() -> None:
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.splitlines() == ["end of the block", "closed", "still frozen: True"]
