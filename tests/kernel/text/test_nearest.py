"""The answer to a name that does not exist."""

from pathlib import Path

import pytest

from fieldrig.cli.names import check_patterns, unfit
from fieldrig.errors import ControlError
from fieldrig.text.nearest import MOST_LISTED, closest, nearest_file


def test_the_nearest_name_is_proposed() -> None:
    assert closest("canO", ["can0", "wires"]) == "did you mean can0?"
    assert closest("IO", ["io", "sensor"]) == "did you mean io?"
    assert closest("x", ["io", "sensor"]) == "there are: io, sensor"
    assert closest("x", []) == "there are none"


def test_a_list_of_thousands_is_cut() -> None:
    shown = closest("x", [f"key{number}" for number in range(3000)])
    assert shown.endswith(f"key{MOST_LISTED - 1} and {3000 - MOST_LISTED} more")


def test_a_file_beside_it_is_proposed(tmp_path: Path) -> None:
    (tmp_path / "lab.yaml").touch()
    assert nearest_file(tmp_path / "labb.yaml") == f"did you mean {tmp_path}/lab.yaml?"
    assert nearest_file(tmp_path / "machine.yaml") == ""
    assert nearest_file(tmp_path / "lab.yaml") == ""
    assert nearest_file(tmp_path / "no-folder" / "lab.yaml") == ""
    (tmp_path / "lab.svg").touch()
    assert nearest_file(tmp_path / "lab") == f"did you mean {tmp_path}/lab.yaml?"


def test_every_pattern_has_to_fit() -> None:
    assert unfit(["can*", "wires"], ["can0", "wires"]) is None
    assert unfit(["can0", "wirse"], ["can0", "wires"]) == "wirse"
    with pytest.raises(ControlError, match="lab has no bus 'wirse'") as refused:
        check_patterns(["can0", "wirse"], ["can0", "wires"], "lab has no bus")
    assert refused.value.remedy == "did you mean wires?"


def test_a_folder_beside_it_is_proposed(tmp_path: Path) -> None:
    (tmp_path / "programs").mkdir()
    assert nearest_file(tmp_path / "program") == f"did you mean {tmp_path}/programs?"
