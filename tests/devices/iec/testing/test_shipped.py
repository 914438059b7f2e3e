"""The tests of the shipped rigs' programs pass, and run nearly all of them: conveyor, feeder, labeller and wrapper."""

from pathlib import Path

import pytest

from fieldrig.coverage.collecting import collecting
from fieldrig.coverage.summary import Coverage
from fieldrig_devices.iec.dialect import EPAS_4
from fieldrig_devices.iec.testing.blocks import BlockSource
from fieldrig_devices.iec.testing.case import Limits, Verdict

pytestmark = pytest.mark.lean

CONFIGS = Path(__file__).parents[4] / "configs"
FILES = sorted(CONFIGS.rglob("*_test.st"))
LEAST = 90.0
"""The least share of statements and branches that they run, in per cent."""
PATIENCE_S = 600.0
"""Bounds a test that hangs, also on a busy host."""


@pytest.mark.long
@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_the_program_does_what_its_tests_say(file: Path) -> None:
    source = BlockSource(file, EPAS_4)
    with collecting() as collected:
        done = list(source.run(source.cases(), Limits(PATIENCE_S)))
        coverage = Coverage(collected.news())
    assert len(done) >= 5
    assert [(one.case.name, one.failures) for one in done if one.verdict is not Verdict.PASSED] == []
    least = {part.name: part.count().per_cent for part in coverage.files()}
    assert least
    assert min(least.values()) > LEAST, least
