"""The tests of the shipped programs notice changes of them, and what they need not notice is listed with its reason."""

from pathlib import Path

import pytest

from fieldrig_devices.iec.dialect import EPAS_4
from fieldrig_devices.iec.mutation.accepted import accepted, chosen
from fieldrig_devices.iec.mutation.changes import Change, changes_of
from fieldrig_devices.iec.testing import gathered, stands, trial
from fieldrig_devices.iec.testing.blocks import BlockSource
from fieldrig_devices.iec.testing.case import Limits

CONFIGS = Path(__file__).parents[4] / "configs"
LISTS = sorted((Path(__file__).parent / "accepted").glob("*.txt"))
SAMPLE = """\
conveyor.st:27  statement  without `lEndWaitTime := PacDriveM.Timer1 + lWaitTime;`
conveyor.st:57  constant  `50` -> `25`
conveyor.st:169  constant  `FALSE` -> `TRUE`
"""
"""Changes that the tests did not notice once, and one of the stop cam."""
TESTS = ("half a second", "less than 50 ms", "the belt starts")
"""The parts of the names of the tests that notice them."""


def changes(*programs: str) -> list[Change]:
    units = [gathered.read(CONFIGS / "programs" / name, EPAS_4).unit for name in programs]
    found = [made.change for unit in units for made in changes_of(unit)]
    return [change._replace(file=Path(change.file).name) for change in found]


@pytest.mark.parametrize("file", LISTS, ids=lambda file: file.stem)
def test_each_accepted_change_is_one_of_the_program_and_has_a_reason(file: Path) -> None:
    programs = ("feeder.st", "sealer.st") if file.stem == "feeder" else (f"{file.stem}.st",)
    lines = [line for line in file.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")]
    assert len(accepted(file, changes(*programs))) >= len(lines) > 0


@pytest.mark.long
def test_a_sample_of_changes_is_noticed(tmp_path: Path) -> None:
    (tmp_path / "sample.txt").write_text(SAMPLE, encoding="utf-8")
    sample = chosen(tmp_path / "sample.txt", changes("conveyor.st"))
    source = BlockSource(CONFIGS / "conveyor_test.st", EPAS_4)
    cases = [case for case in source.cases() if any(part in case.name for part in TESTS)]
    with stands.kept():
        one = trial.Trial([(source, cases)], Limits(600.0, has_diagrams=False), ())
        fates = {change.line: one.result(change).fate for change in sample}
    assert fates == dict.fromkeys((27, 57, 169), trial.Fate.NOTICED)
