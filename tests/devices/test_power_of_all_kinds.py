"""Every device of the shipped rigs can be switched off and on, while the others go on without it."""

from typing import Final

import pytest
from shipped import RIGS, in_virtual_time

from fieldrig.clock import MS
from fieldrig.device import POWER_OFF
from fieldrig.errors import ControlError
from fieldrig.virtual.rig import Rig

pytestmark = pytest.mark.long

LARGE: Final = {"conveyor.yaml", "machine.yaml", "packaging-line.yaml"}
"""Rigs whose kinds the others have too."""
FILES: Final = [file for file in RIGS if file not in LARGE]


@pytest.mark.parametrize("file", FILES)
def test_each_device_loses_its_power_and_starts_again(file: str) -> None:
    with Rig(in_virtual_time(file)) as rig:
        rig.run_for(100 * MS)
        for device, entry in rig.config.devices.items():
            number = rig.add_fault(device, {"what": POWER_OFF, "duration_ms": 30})
            rig.run_for(20 * MS)
            assert rig.faults(device)[number]["state"] == "on"
            if POWER_OFF not in entry.cls.fault_models and rig.config.processes == "one":
                with pytest.raises(ControlError, match="switched off"):
                    rig.answer(device, "debug", {})
            rig.run_for(20 * MS)
            rig.clear_fault(device, number)
            rig.restart(device)
            rig.run_for(20 * MS)
            assert all(rig.get(device, key) == rig.get(device, key) for key in list(rig.keys(device))[:3])


def test_the_large_rigs_have_no_kind_of_their_own() -> None:
    kinds = {file: {entry.kind for entry in in_virtual_time(file).devices.values()} for file in (*FILES, *LARGE)}
    tried = set().union(*(kinds[file] for file in FILES))
    assert set().union(*(kinds[file] for file in LARGE)) <= tried
