"""Advice before the start: a process each cannot keep a cycle on this number of cores, and the line that helps."""

from pathlib import Path
from typing import Any

import pytest
from pam_machine import application_text
from pam_machine import rig_of as pam_rig

from fieldrig.config.rig_file import RigConfig, from_dict, load
from fieldrig.real.core_advice import advice

ROOT = Path(__file__).parents[3]
SHIPPED = sorted((ROOT / "configs").glob("*.yaml"))


def ring_of(drives: int, kind: str, cycle_ms: int, **keys: Any) -> RigConfig:
    plate = str(ROOT / "configs/plates/sm-100-30-080.yaml")
    links = {"ring": "fibre"}
    axes = {
        f"drive{number}": {"kind": "mc4", "ring_address": number, "motor": {"name_plate": plate}, "links": links}
        for number in range(1, drives + 1)
    }
    controller = {"kind": "max4", "cycle_ms": cycle_ms, "links": links}
    rig = {"time": "real", "buses": {"fibre": {"kind": kind}}, "devices": {"max4": controller, **axes}}
    return from_dict({**rig, **keys}, ROOT)


SERCOS_LINE = "this line in the rig file helps: processes: {max4: max4, fibre: fibre}"


@pytest.mark.parametrize(
    ("drives", "kind", "cycle_ms", "cores", "needed"),
    [
        (4, "ring.zenoh", 4, 2, None),
        (40, "ring.zenoh", 4, 2, "1.2"),
        (40, "ring.zenoh", 4, 8, None),
        (40, "ring.shm", 4, 2, None),
        (40, "ring.shm", 1, 2, "1.2"),
        (1, "ring.zenoh", 1, 1, None),
        (4, "ring.zenoh", 1, 2, "0.6"),
    ],
)
def test_a_ring_with_too_many_processes_for_the_cores_is_warned_of(
    drives: int, kind: str, cycle_ms: int, cores: int, needed: str | None
) -> None:
    text = (
        f"fibre has a cycle of {cycle_ms} ms and {drives + 1} processes: to wake them takes {needed} cores or more,"
        f" and this host has {cores}, so cycles may be lost\n{SERCOS_LINE}"
    )
    assert list(advice(ring_of(drives, kind, cycle_ms), cores)) == ([text] if needed else [])


def test_the_line_that_is_named_helps() -> None:
    assert list(advice(ring_of(40, "ring.zenoh", 1, processes={"max4": "max4", "fibre": "fibre"}), 2)) == []


@pytest.mark.parametrize(("cycle", "milliseconds", "needed"), [(3, "1", "1.1"), (6, "2", "0.6"), (12, "4", None)])
def test_the_basic_cycle_of_a_pam_counts(tmp_path: Path, cycle: int, milliseconds: str, needed: str | None) -> None:
    application = tmp_path / "machine.pam"
    application.write_text(application_text().replace("BASIC_PAM_CYCLE = 3;", f"BASIC_PAM_CYCLE = {cycle};"))
    rig = pam_rig(application, "real")
    found = list(advice(from_dict(rig, tmp_path), 2))
    assert [text.partition(" cores")[0] for text in found] == (
        [f"ring0 has a cycle of {milliseconds} ms and 23 processes: to wake them takes {needed}"] if needed else []
    )
    together = {**rig, "processes": {"pam": "pam", "ring0": "ring0"}}
    assert list(advice(from_dict(together, tmp_path), 2)) == []


@pytest.mark.long
@pytest.mark.parametrize("file", SHIPPED, ids=lambda file: file.name)
def test_no_shipped_rig_is_warned_of_on_two_cores(file: Path) -> None:
    assert list(advice(load(file), 2)) == []
