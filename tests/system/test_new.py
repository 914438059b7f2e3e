"""`fieldrig new` as a user has it: all that it makes passes `fieldrig check`, and its own test."""

import os
import subprocess
from pathlib import Path

import forked_cli
import pytest
from terminal import Terminal

from fieldrig.real.live_rig import FIELDRIG
from fieldrig_devices.begin.examples import menu

pytestmark = [pytest.mark.system, pytest.mark.timeout(600)]

DRIVE = "devices/fieldrig_devices/cia402/single/cia402-drive.eds"
EDS_FILES = ("configs/eds/io32.eds", "devices/fieldrig_devices/arp/can/arp-card.eds", DRIVE)
ROOT = Path(__file__).parents[2]
LIMIT_S = 500.0
OPTIONS = [["new", example] for example in menu()] + [["new", "--eds", str(ROOT / file)] for file in EDS_FILES]


def run(folder: Path, *words: str, module: str = "fieldrig") -> subprocess.CompletedProcess[str]:
    return forked_cli.run(words, folder, os.environ, limit_s=LIMIT_S, module=module)


@pytest.mark.parametrize("words", OPTIONS, ids=lambda words: words[-1].rpartition("/")[2])
def test_what_is_made_passes_check_and_its_own_test(tmp_path: Path, words: list[str]) -> None:
    assert run(tmp_path, *words, "made").returncode == 0
    rigs = [str(file.relative_to(tmp_path)) for file in (tmp_path / "made").glob("*.yaml")]
    for rig in rigs:
        checked = run(tmp_path, "check", rig)
        assert checked.returncode == 0, checked.stderr
    tested = run(tmp_path, "-W", "error", "-p", "no:cacheprovider", "made", module="pytest")
    assert tested.returncode == 0, tested.stdout
    assert rigs
    assert " passed" in tested.stdout


def test_the_eds_of_a_drive_makes_a_drive(tmp_path: Path) -> None:
    made = run(tmp_path, "new", "--eds", str(ROOT / DRIVE))
    assert "a `cia402.drive` with a motor" in made.stdout
    assert "kind: cia402.drive" in (tmp_path / "cia402-drive" / "cia402-drive.yaml").read_text()
    other = run(tmp_path, "new", "--eds", str(ROOT / EDS_FILES[0]))
    assert (other.returncode, "drive" in other.stdout) == (0, False)


def test_at_a_terminal_it_shows_the_menu_and_asks(tmp_path: Path) -> None:
    with Terminal(" ".join([*FIELDRIG, "new"]), tmp_path) as terminal:
        terminal.until_shown("packaging-line", "Example [lab]")
        terminal.type("own-device\n")
        terminal.until_shown("Folder [own-device]")
        assert terminal.press("bench\n") == 0
    assert (tmp_path / "bench/press.py").is_file()


@pytest.mark.parametrize("arguments", [("lab", ""), ("", "x"), ("lab", "  "), ("--eds", "eds/io32.eds", "")])
def test_an_empty_name_is_no_folder(arguments: tuple[str, ...], tmp_path: Path) -> None:
    done = run(tmp_path, "new", *arguments)
    assert done.returncode == 2
    assert "expected the name of" in done.stderr
    assert list(tmp_path.iterdir()) == []
