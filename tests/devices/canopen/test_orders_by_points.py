"""A point of an object that a master can write does what the master's write does, and is refused as that is."""

from pathlib import Path

import pytest

from fieldrig.clock import MS
from fieldrig.config.rig_file import load
from fieldrig.errors import ControlError
from fieldrig.virtual.rig import Rig

RIG = Path(__file__).parents[3] / "configs" / "drive.yaml"


def test_control_words_enable_a_drive_and_a_wrong_mode_is_refused() -> None:
    """Once, 6040h showed what was written, and the drive stayed where it was."""
    with Rig(load(RIG, ("time=virtual",))) as rig:
        rig.run_for(20 * MS)
        for word, state in ((0x06, 0x21), (0x07, 0x23)):  # CiA 402-2, the transitions 2 and 3
            rig.set("axis/6040:00", word)
            rig.run_for(20 * MS)
            assert int(rig.get("axis/6041:00")) & 0x6F == state
        with pytest.raises(ControlError, match="INVALID_VALUE"):
            rig.set("axis/6060:00", 99)
        assert rig.get("axis/6060:00") == 0
        for key in ("6041:00", "6064:00", "60FD:00"):  # once, these were taken without effect
            with pytest.raises(ControlError, match=f"the device determines {key}"):
                rig.set(f"axis/{key}", 5)
