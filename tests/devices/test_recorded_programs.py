"""Variables of programs in recordings, by the names that the debugger has for them."""

import math
from pathlib import Path

import pytest

from fieldrig.clock import MS
from fieldrig.config.rig_file import load
from fieldrig.errors import ControlError
from fieldrig.virtual.rig import Rig

CONFIGS = Path(__file__).parents[2] / "configs"


@pytest.mark.long
@pytest.mark.parametrize(
    ("file", "device", "variable", "cycles"),
    [
        ("feeder.yaml", "feeder", "g_udiSpeed", 10),
        ("pam-machine.yaml", "pam", "IFV_Run", 50),
        ("arp-cell.yaml", "line", "V1", 50),
    ],
)
def test_a_variable_of_a_program_is_recorded_in_each_cycle(file: str, device: str, variable: str, cycles: int) -> None:
    with Rig(load(CONFIGS / file, ["time=virtual"])) as rig:
        rig.run_for(250 * MS)
        signal = f"{device}/program:{variable}"
        recording = rig.record(signal)
        rig.run_for(100 * MS)
        assert len(recording.values[signal]) == cycles
        assert not any(map(math.isnan, recording.values[signal]))
        with pytest.raises(ControlError, match=f"{device} has no value 'program:nothing'"):
            rig.record(f"{device}/program:nothing")
