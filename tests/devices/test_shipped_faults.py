"""Every fault of the shipped rigs: the machine is safe, does not start by itself, and comes back as documented.

The faults come from the rig files, and each machine has a table of what they do to it.  A rig is shared by the faults
that are tried in it, as long as it works.
"""

from collections.abc import Iterator
from typing import Final

import pytest
from bus_machines import Lab, Press
from fault_choices import CONFIGS, Injected, faults_of
from faulted_machine import Machine, expected_of, keys_of, stops, try_fault
from labelling_machine import Labeller
from max4_machines import Conveyor, PackagingLine, RingLab
from small_machines import Cell, Feeder, SmartIo
from telephone_machines import Modems, Teleservice
from whole_line import WholeLine

from fieldrig.config.rig_file import load

pytestmark = pytest.mark.long

MACHINES: Final[tuple[type[Machine], ...]] = (
    Cell,
    Conveyor,
    Feeder,
    Lab,
    Labeller,
    Modems,
    PackagingLine,
    Press,
    RingLab,
    SmartIo,
    Teleservice,
    WholeLine,
)


NO_MACHINE: Final = {
    "drive.yaml": "a drive that a master moves, and no program: tests/devices/cia402/single",
    "energy-meter.yaml": "meters, which only measure",
}


def faults_tried(machine: type[Machine]) -> list[Injected]:
    return faults_of(load(CONFIGS / machine.file, (*machine.overrides, "time=virtual")), machine.wheres)


class Yard:
    """The machine that is used at present."""

    def __init__(self) -> None:
        self._machine: Machine | None = None

    def take(self, kind: type[Machine]) -> Machine:
        """Return a machine that works, the last one or a new one, and expect it back when it works again."""
        machine, self._machine = self._machine, None
        if type(machine) is kind:
            return machine
        if machine is not None:
            machine.rig.close()
        machine = kind()
        assert machine.works()
        return machine

    def give_back(self, machine: Machine) -> None:
        self._machine = machine

    def close(self) -> None:
        if self._machine is not None:
            self._machine.rig.close()


@pytest.fixture(scope="module")
def yard() -> Iterator[Yard]:
    yard = Yard()
    yield yard
    yard.close()


@pytest.mark.parametrize(
    ("kind", "injected"),
    [
        pytest.param(kind, injected, id=" ".join((kind.__name__, injected.where, *injected.words[1:])))
        for kind in MACHINES
        for injected in faults_tried(kind)
    ],
)
def test_a_fault_leaves_the_machine_safe_and_it_comes_back(yard: Yard, kind: type[Machine], injected: Injected) -> None:
    expected = expected_of(kind.table, injected)
    assert expected is not None, f"say in the table of {kind.__name__} what this fault does to it"
    machine = yard.take(kind)
    try_fault(machine, injected, expected)
    yard.give_back(machine)


def test_a_nip_without_its_encoder_is_switched_off_and_comes_back() -> None:
    cell = Cell()
    assert cell.works()
    try_fault(cell, Injected("nip", "plant.servo", {"what": "encoder_signal"}), stops())
    cell.rig.close()


def test_a_guide_that_moves_inwards_without_pulses_is_found_again() -> None:
    """It is counted 50 pulses too far out each time, until its lower stop is nearer than where it shall go."""
    machine = Labeller()
    assert machine.works()
    for _ in range(2):
        machine.provoke()
        machine.wait(2)
        injected = Injected("rail", "plant.dc-motor", {"what": "no_pulses"})
        try_fault(machine, injected, Labeller.table["plant.dc-motor no_pulses"])
    machine.rig.close()


def test_a_reset_of_the_pam_ends_the_error_that_its_plc_sees() -> None:
    """A PAM that starts again sends only what changes, and no error ends then."""
    machine = Labeller()
    assert machine.works()
    number = machine.rig.add_fault("paper", {"what": "overload"})
    machine.until(lambda: machine.get("plc", "DOF_Error"), 2)
    machine.rig.clear_fault("paper", number)
    machine.set("pam", "reset", True)
    machine.wait(1)
    machine.start()
    assert not machine.get("plc", "DOF_Error")
    assert machine.works()
    machine.rig.close()


@pytest.mark.parametrize("kind", MACHINES, ids=lambda kind: kind.__name__)
def test_a_table_has_no_entry_without_a_fault(kind: type[Machine]) -> None:
    keys = {key for injected in faults_tried(kind) for key in keys_of(injected.words)}
    assert set(kind.table) <= keys


def test_every_shipped_rig_has_a_machine() -> None:
    """A variant has the devices of the rig that it extends."""
    files = {path.name for path in CONFIGS.glob("*.yaml")}
    assert files - {machine.file for machine in MACHINES} - set(NO_MACHINE) == {"lab-vcan.yaml"}


@pytest.mark.parametrize(
    "replaced",
    [
        {"node": "unwinder", "xor": "00 00 00 00 01"},
        {"node": "unwinder", "xor": "00 00 00 00 ff ff ff ff"},
        {"node": "unwinder", "data": "a0 86 01 00 01"},
        {"node": "unwinder", "data": "a0 86 01 00 03"},
        {"data": "00 00 00 00 00 00 00 00"},
    ],
    ids=["not kept", "all flags inverted", "no sign of life", "no sign of life, high", "zeros"],
)
def test_wrong_flags_between_the_cards_stop_the_film(yard: Yard, replaced: dict[str, str]) -> None:
    """The first flag of the unwinder is F97, it keeps the tension, the second F98, its sign of life."""
    machine = yard.take(Cell)
    try_fault(machine, Injected("can0", "can.virtual", {"what": "replace", **replaced}), stops())
    yard.give_back(machine)


@pytest.mark.parametrize("axis", Conveyor.axes)
def test_a_short_fault_of_any_axis_stops_the_conveyor(yard: Yard, axis: str) -> None:
    """Once, only the belt was watched: the others started again by themselves when their fault was over."""
    machine = yard.take(Conveyor)
    injected = Injected(axis, "mc4", {"what": "enable_lost", "duration_ms": 300})
    machine.rig.add_fault(axis, injected.fault)
    machine.wait(1)
    fed = machine.get("line", "fed")
    for _ in range(20):
        machine.wait(0.1)
        assert machine.is_safe(axis)
    assert machine.get("line", "fed") == fed
