"""`fieldrig iec test --watch` runs the tests that a change touches, and no others."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from st_tests import MOTOR, written

from fieldrig_devices.iec.dialect import EDITION_3
from fieldrig_devices.iec.testing import watching
from fieldrig_devices.iec.testing.chosen import sources_of
from fieldrig_devices.iec.testing.parallel import Work

TEST = "TEST 'it' ASSERT_EQ(Step(1), 1); END_TEST"


def work_of(folder: Path) -> Callable[[], list[Work]]:
    return lambda: [(source, source.cases()) for source in sources_of([folder], EDITION_3)]


def touched(folder: Path, monkeypatch: pytest.MonkeyPatch, *changes: Callable[[], object]) -> list[list[str]]:
    """Make one change after the other, each between two looks; return the names of the files that ran after them."""

    def looks(speed: float) -> Iterator[int]:
        for number, change in enumerate([lambda: None, *changes], 1):
            change()
            yield number * watching.PERIOD_NS

    monkeypatch.setattr(watching, "elapsed_ns", looks)
    return [[cases[0].file.name for _, cases in work] for work in watching.changes(work_of(folder))]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    other = "FUNCTION Other : INT Other := 3; END_FUNCTION"
    written(tmp_path, motor=MOTOR, motor_test=TEST, other=other)
    return written(tmp_path, other_test="TEST 'it' ASSERT_EQ(Other(), 3); END_TEST")


def test_a_change_of_the_code_runs_the_tests_that_need_it(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    changes = [
        lambda: written(folder, motor=MOTOR + "\n"),
        lambda: None,
        lambda: written(folder, other_test="TEST 'it' ASSERT_EQ(Other(), 4); END_TEST"),
        lambda: written(folder, unrelated="PROGRAM Unrelated END_PROGRAM"),
    ]
    assert touched(folder, monkeypatch, *changes) == [["motor_test.st"], ["other_test.st"]]


def test_a_file_of_code_that_is_deleted_runs_the_tests_that_needed_it(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    changes: list[Callable[[], object]] = [
        (folder / "motor.st").unlink,
        lambda: written(folder, unrelated="PROGRAM Unrelated END_PROGRAM"),
        lambda: written(folder, motor=MOTOR),
    ]
    assert touched(folder, monkeypatch, *changes) == [["motor_test.st"], ["motor_test.st"]]


def test_a_file_that_the_rig_of_a_test_names_runs_it(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "base.yaml").write_text("devices: {plc: {kind: max4, program: plc.st}}")
    (folder / "rig.yaml").write_text("extends: base.yaml")
    written(folder, plc="PROGRAM Main END_PROGRAM", rig_test="TEST 'it' RIG 'rig.yaml' ASSERT_TRUE(TRUE); END_TEST")
    changes: list[Callable[[], object]] = [
        lambda: written(folder, plc="PROGRAM Main VAR a : INT; END_VAR END_PROGRAM"),
        lambda: (folder / "base.yaml").write_text("devices: {plc: {kind: max4}}"),
    ]
    assert touched(folder, monkeypatch, *changes) == [["rig_test.st"], ["rig_test.st"]]


def test_a_new_file_of_tests_runs(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert touched(folder, monkeypatch, lambda: written(folder, third_test=TEST)) == [["third_test.st"]]


def test_a_file_that_is_just_being_written_is_waited_for(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    changes = [
        lambda: (folder / "motor_test.st").write_bytes(b"\xff\xfe\x00"),
        lambda: written(folder, motor_test=TEST + "\n"),
    ]
    assert touched(folder, monkeypatch, *changes)[-1] == ["motor_test.st"]
