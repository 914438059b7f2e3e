"""Rules about the code as a whole: who imports whom, and that every test belongs to a stage of `make test`."""

import re
from pathlib import Path

import pytest
from importlinter.cli import lint_imports

TESTS = Path(__file__).parent


def test_devices_stand_on_buses_and_buses_on_the_kernel() -> None:
    assert lint_imports(config_filename=str(TESTS.parent / "pyproject.toml"), no_cache=True) == 0


@pytest.mark.parametrize(("mark", "folder"), [("vcan", "real"), ("docker", "docker"), ("real", "real")])
def test_marks_of_a_stage_stand_in_its_folder(mark: str, folder: str) -> None:
    marked = [path for path in TESTS.rglob("test_*.py") if re.search(rf"\bmark\.{mark}\b", path.read_text())]
    assert [path for path in marked if path.parent.relative_to(TESTS).parts[:1] != (folder,)] == []
