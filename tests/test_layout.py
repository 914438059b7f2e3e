"""Rules about the code as a whole: who imports whom, and that every test belongs to a stage of `make test`."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).parent


@pytest.mark.long
def test_devices_stand_on_buses_and_buses_on_the_kernel() -> None:
    # In a process of its own: import-linter turns off all loggers that it finds.
    command = [str(Path(sys.prefix) / "bin" / "lint-imports"), "--no-logo", "--no-cache"]
    result = subprocess.run(command, cwd=TESTS.parent, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr


@pytest.mark.long
@pytest.mark.parametrize(
    ("mark", "folder"), [("vcan", "real"), ("ppp", "real"), ("docker", "docker"), ("real", "real")]
)
def test_marks_of_a_stage_stand_in_its_folder(mark: str, folder: str) -> None:
    marked = [path for path in TESTS.rglob("test_*.py") if re.search(rf"\bmark\.{mark}\b", path.read_text())]
    assert [path for path in marked if path.parent.relative_to(TESTS).parts[:1] != (folder,)] == []
