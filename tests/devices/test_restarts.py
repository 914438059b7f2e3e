"""Every device of the shipped rigs is switched off and on while one of its faults lasts, and raises nothing.

It gets the fault before it starts, so what a change of faults does must not need a device that has started.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import load
from fieldrig.errors import ControlError
from fieldrig.virtual.rig import Rig
from fieldrig_devices.search.fault_choices import fault_choices

pytestmark = pytest.mark.lean

CONFIGS = Path(__file__).parents[2] / "configs"
BOOTED_S = {
    "arp-cell": 6,
    "conveyor": 5,
    "drive": 2,
    "feeder": 2,
    "lab": 2,
    "modems": 2,
    "pam-machine": 8,
    "smart-io": 2,
}


class AllFaults(NamedTuple):
    """A plan of each fault of all devices, for a second."""

    where: Sequence[str] = ("devices",)
    kinds: Sequence[str] = ("*",)
    durations: Sequence[int] = (1 * S,)
    when: Sequence[str] = ()
    given: Mapping[str, Any] = {}


def faults_of(rig: Rig) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield a form of each fault of each device."""
    forms = {(one.where, value["what"]): value for one in fault_choices(rig, AllFaults()) for value in one.values}
    for (where, _), form in forms.items():
        yield where, form


def restarted(rig: Rig, device: str, fault: Mapping[str, Any]) -> None:
    with suppress(ControlError):  # the device has no power, or refuses the fault in its present state
        rig.add_fault(device, fault)
        rig.run_for(100 * MS)
        rig.restart(device)
    rig.run_for(1500 * MS)


@pytest.mark.long
@pytest.mark.parametrize("name", BOOTED_S)
def test_a_device_that_is_restarted_during_a_fault_raises_nothing(name: str) -> None:
    with Rig(load(CONFIGS / f"{name}.yaml", ["time=virtual"])) as rig:
        rig.run_until(BOOTED_S[name] * S)
        for device, fault in faults_of(rig):
            with rig.branch() as branch:
                branch.call(restarted, device, fault)
