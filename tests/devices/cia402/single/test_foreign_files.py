"""EDS and DCF files of other makers' drives: each runs, has what it declares, and passes our conformance cases.

`drive_files` says what each is expected to declare, and where the files are.
"""

from pathlib import Path

import pytest
from drive_files import FILES, path_of
from single_drive_bench import SingleDriveBench

from fieldrig.config.rig_file import from_dict, load
from fieldrig.text.device_names import name_for
from fieldrig.virtual.rig import Rig
from fieldrig_devices.begin.eds_rig import content_for
from fieldrig_devices.cia402 import EDS
from fieldrig_devices.cia402.single.foreign import declared
from fieldrig_devices.cia402.single.oddities import oddities
from fieldrig_devices.conformance.description import Description
from fieldrig_devices.conformance.run import choose, conform_virtual
from fieldrig_devices.conformance.suite import Verdict

pytestmark = pytest.mark.long

EACH = pytest.mark.parametrize("name", FILES)
MOVES = [name for name, facts in FILES.items() if 1 in facts.modes]


@EACH
def test_a_file_declares_its_modes_and_its_encoder(name: str) -> None:
    path, facts = path_of(name), FILES[name]
    said = declared(path)
    assert set(said.behaviour.modes or ()) == facts.modes
    assert said.increments == facts.increments
    assert any(facts.oddity in finding.what and finding.line > 0 for finding in oddities(path)) or not facts.oddity


@pytest.mark.parametrize("name", MOVES)
def test_a_master_moves_the_drive_of_a_file(name: str) -> None:
    path, facts = path_of(name), FILES[name]
    bench = SingleDriveBench(eds=str(path))
    assert bench.get(0x1000) & 0xFFFF_FFFF == facts.device_type
    bench.enabled(1)
    begin = bench.get(0x6064)
    bench.put(0x607A, begin + 100).control(0x1F)
    bench.until(lambda: bench.get(0x6064) >= begin + 99, 20_000)
    assert bench.status(0x0008) == 0


@EACH
def test_the_drive_of_a_file_conforms(name: str) -> None:
    """All cases but 1.0, which is about the file itself."""
    device = {"kind": "cia402.drive", "node_id": 3, "eds": str(path_of(name)), "links": {"can": "can0"}}
    buses = {"can0": {"kind": "can.virtual", "bitrate": 1_000_000}}
    rig = Rig(from_dict({"time": "virtual", "buses": buses, "devices": {"axis": device}}))
    cases = [case for case in choose([]) if case.number != "1.0"]
    report = conform_virtual(rig, "can0", Description(path_of(name), 3), cases)
    assert [result.case.number for result in report.of(Verdict.FAILED)] == []
    assert len(report.of(Verdict.PASSED)) > 40


@EACH
def test_a_rig_is_made_from_a_file_and_its_oddities_are_warned_of(name: str, tmp_path: Path) -> None:
    for file, content in content_for(path_of(name)).items():
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).write_bytes(content)
    rig = load(tmp_path / f"{name_for(path_of(name))}.yaml", ["time=virtual"])
    (device,) = rig.devices.values()
    is_a_drive = FILES[name].device_type & 0xFFFF == 402 or FILES[name].modes
    assert device.kind == ("cia402.drive" if is_a_drive else "canopen.node")
    warned = {doubt.what for doubt in device.settings.doubts()}
    assert not is_a_drive or warned >= {finding.what for finding in oddities(path_of(name))}


@pytest.mark.parametrize("name", [name for name in FILES if "epos" in name.lower()])
def test_velocities_are_in_the_unit_of_the_file(name: str) -> None:
    """These files say turns per minute, by 608Ch (A4h) or by 60A9h (00B44700h)."""
    bench = SingleDriveBench(eds=str(path_of(name)))
    bench.enabled(3).put(0x60FF, 300).after(3_000)
    assert bench.read("speed") == pytest.approx(300, rel=0.01)
    assert bench.get(0x606C) == pytest.approx(300, abs=3)


@pytest.mark.parametrize(("index", "subindex", "start"), [(0x6086, 0, 1), (0x60D0, 1, 0), (0x60F2, 0, 4)])
def test_the_power_on_value_of_a_file_can_be_written_back(
    index: int, subindex: int, start: int, tmp_path: Path
) -> None:
    """A master that reads all parameters and writes them back meets no abort; other such values are refused."""
    key = f"{index:04X}sub{subindex}" if subindex else f"{index:04X}"
    head, rest = EDS.read_text(encoding="utf-8").split(f"[{key}]\n")
    section, others = rest.split("\n\n", 1)
    lines = [line for line in section.splitlines() if not line.startswith("DefaultValue")]
    path = tmp_path / "their-drive.eds"
    path.write_text("\n".join([f"{head}[{key}]", *lines, f"DefaultValue={start}", "", others]), encoding="utf-8")
    bench = SingleDriveBench(eds=str(path))
    assert bench.get(index, subindex) == start
    assert bench.try_put(index, start, subindex) == ""
    assert bench.try_put(index, 0x7F, subindex) in ("06090030", "06090031")
