"""Rules about the code as a whole: who imports whom, and that every test belongs to a stage of `make test`."""

import re
import subprocess
import sys
from pathlib import Path

import grimp  # import-linter is built on it
import pytest

TESTS = Path(__file__).parent
PACKAGES = ("fieldrig", "fieldrig_bus", "fieldrig_devices", "fieldrig_page")

LARGEST_CIRCLE = 2
"""Two classes may know each other; of three that do, none can be read or tested without the other two."""


@pytest.mark.long
def test_devices_stand_on_buses_and_buses_on_the_kernel() -> None:
    # In a process of its own: import-linter turns off all loggers that it finds.
    command = [str(Path(sys.prefix) / "bin" / "lint-imports"), "--no-logo", "--no-cache"]
    result = subprocess.run(command, cwd=TESTS.parent, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr


def circles() -> set[tuple[str, ...]]:
    """Return the files that import each other in a circle; imports that only types need (TYPE_CHECKING) count."""
    graph = grimp.build_graph(*PACKAGES, exclude_type_checking_imports=False, cache_dir=None)
    mutual = {
        name: {name, *(graph.find_upstream_modules(name) & graph.find_downstream_modules(name))}
        for name in graph.modules
    }
    return {tuple(sorted(circle)) for circle in mutual.values() if len(circle) > LARGEST_CIRCLE}


@pytest.mark.long
def test_no_three_files_know_each_other_in_a_circle() -> None:
    assert circles() == set()


@pytest.mark.long
@pytest.mark.parametrize(
    ("mark", "folders"),
    [("vcan", ["real"]), ("ppp", ["real"]), ("docker", ["docker"]), ("real", ["real", "page/browser"])],
)
def test_marks_of_a_stage_stand_in_its_folder(mark: str, folders: list[str]) -> None:
    marked = [path for path in TESTS.rglob("test_*.py") if re.search(rf"\bmark\.{mark}\b", path.read_text())]
    assert [path for path in marked if not any((TESTS / folder) in path.parents for folder in folders)] == []
