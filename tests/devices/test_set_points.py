"""A point that is set reads so at once, or it is refused: no value is taken without effect, in any shipped rig."""

import re
from pathlib import Path
from typing import Final

import pytest

from fieldrig.clock import S
from fieldrig.config.rig_file import load
from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.virtual.rig import Rig

CONFIGS: Final = Path(__file__).parents[2] / "configs"
RIGS: Final = (
    "arp-cell.yaml",
    "drive.yaml",
    "feeder.yaml",
    "lab.yaml",
    "pam-machine.yaml",
    "ring.yaml",
    "smart-io.yaml",
    "teleservice.yaml",
)
COMMANDS: Final = {"DiagQuit", "reset", "feed"}
"""Points that are pressed like a button, and read false again when it has been done."""
SECRETS: Final = {"Modem.Password": "********"}


def another(value: Value) -> Value:
    if isinstance(value, bool):
        return not value
    return value + 1 if isinstance(value, int | float) else "x"


@pytest.mark.long
@pytest.mark.parametrize("file", RIGS)
def test_a_point_that_is_set_reads_so_or_is_refused(file: str) -> None:
    """Points that differ in their numbers only are tried once for each kind of device."""
    seen = set[tuple[str, str]]()
    with Rig(load(CONFIGS / file, ("time=virtual",))) as rig:
        rig.run_until(3 * S)
        for device, entry in rig.config.devices.items():
            for key, value in rig.values(device).items():
                kind = entry.kind, re.sub(r"\d", "#", key)
                if kind in seen or key.rpartition(".")[2] in COMMANDS:
                    continue
                seen.add(kind)
                wanted = another(value)
                try:
                    rig.set(device, key, wanted)
                except ControlError:
                    continue
                assert rig.get(device, key) == SECRETS.get(key, wanted), f"{device}/{key}"
    assert seen
