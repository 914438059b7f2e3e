"""A device that computes without end ends the block of a master, in whichever thread time passes."""

import threading
import time
from pathlib import Path

import pytest

from fieldrig import Rig, VirtualTimeError, from_dict, virtual_time

pytestmark = [pytest.mark.lean, pytest.mark.timeout(60), pytest.mark.long]
DATA = {
    "time": "virtual",
    "buses": {"wires": {"kind": "wires.virtual"}},
    "devices": {"endless": {"kind": "rig_kinds:Endless", "links": {"wires": "wires"}}},
}


@pytest.mark.parametrize("is_main_first", [True, False])
def test_a_device_that_computes_without_end_is_told_with_its_line(is_main_first: bool) -> None:
    def other() -> None:
        time.sleep(1)

    def act() -> None:
        with Rig(from_dict(DATA, Path(__file__).parents[1])) as rig, virtual_time(rig, patience_s=0.5):
            thread = threading.Thread(target=other, daemon=True)
            thread.start()
            if is_main_first:
                time.sleep(1)  # time passes in the thread that waits last
            else:
                thread.join()

    before = threading.active_count()
    with pytest.raises(VirtualTimeError) as caught:
        act()
    assert str(caught.value).startswith("a device has run for 0.5 s without time passing: ")
    assert "rig_kinds.py" in str(caught.value)
    assert threading.active_count() == before
