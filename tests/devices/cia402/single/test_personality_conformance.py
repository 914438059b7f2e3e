"""`fieldrig conform` on each personality: docs/devices/drive-personalities.md names all that it finds.

The cases are those of CiA 301; a difference that the standard allows must pass them.
"""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any, get_args

import pytest
from doc_pages import page_named
from typer.testing import CliRunner

from fieldrig.cli.app import app
from fieldrig_devices.cia402.single.personality import Name

pytestmark = pytest.mark.long

NAMES = get_args(Name)
DOCS = page_named("drive-personalities.md")
BY_THE_BOOK: dict[str, dict[str, Any]] = {
    "mains-inverter": {"missing": []},
    "robot-joint": {"missing": [], "mapping": "free", "loses_first_sdo": False, "needs_reset_node": False},
    "late-and-thin": {"missing": [], "objects": {"1000:00": 0x0002_0192}},
}
"""The keys of a personality that break the standard or its own EDS, with the value that doesn't."""


def failures(folder: Path, drive: dict[str, Any], only: Iterable[str] = ()) -> tuple[set[str], int]:
    """Return the names of the cases that failed, and the number of those that passed."""
    device = {"kind": "cia402.drive", "node_id": 3, "links": {"can": "can0"}, **drive}
    buses = {"can0": {"kind": "can.virtual", "bitrate": 1_000_000}}
    rig = folder / "rig.yaml"
    rig.write_text(json.dumps({"time": "virtual", "buses": buses, "devices": {"axis": device}}))
    chosen = [word for case in only for word in ("--only", case)]
    command = ["conform", "--rig", str(rig), "--bus", "can0", "--node", "3", "--timeout-ms", "1000", "--json", *chosen]
    done = CliRunner().invoke(app, command)
    report = json.loads(done.stdout)
    failed = {case["name"] for case in report["cases"] if case["verdict"] == "failed"}
    assert done.exit_code == (8 if failed else 0)
    return failed, report["passed"]


@pytest.mark.parametrize("name", NAMES)
def test_a_personality_conforms_but_for_the_deviations_that_are_named(name: str, tmp_path: Path) -> None:
    failed, passed = failures(tmp_path, {"personality": name, "behaviour": BY_THE_BOOK.get(name, {})})
    assert failed == set()
    assert passed >= 117


@pytest.mark.parametrize(
    ("behaviour", "case"),
    [
        ({"missing": [0x605A]}, "OD 01"), ({"mapping": "fixed"}, "PDO 33"), ({"needs_reset_node": True}, "PDO 05"),
        ({"loses_first_sdo": True}, "Transition 01"), ({"objects": {"1000:00": 0x0002_0000}}, "SDO 01"),
    ],
)  # fmt: skip
def test_each_deviation_that_is_named_is_found(behaviour: dict[str, Any], case: str, tmp_path: Path) -> None:
    assert failures(tmp_path, {"behaviour": behaviour}, [case])[0] == {case}
    assert failures(tmp_path, {}, [case])[0] == set()


def test_the_docs_name_the_deviations() -> None:
    chapter = DOCS.read_text().split("## What `fieldrig conform` says")[1].split("\n## ")[0]
    rows = [line.split("|") for line in chapter.splitlines() if line.startswith("| `")]
    named = {row[1].strip(" `"): set(row[2].replace("`", " ").replace(",", " ").split()) - {"none"} for row in rows}
    assert named == {name: set(BY_THE_BOOK.get(name, ())) for name in NAMES}
