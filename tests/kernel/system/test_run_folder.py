"""The owner of a run folder, and the files that are removed from it."""

import os
import socket
from pathlib import Path

import pytest

from fieldrig.errors import RigError
from fieldrig.system.run_folder import RunFolder, join_run

pytestmark = pytest.mark.system


def test_a_folder_belongs_to_one_rig_until_it_lets_go(tmp_path: Path) -> None:
    first, second = RunFolder(tmp_path / "lab"), RunFolder(tmp_path / "lab")
    first.claim([])
    with pytest.raises(RigError, match=rf"another rig runs in .*lab \(process {os.getpid()}\)") as refused:
        second.claim([])
    assert "--set run=FOLDER" in refused.value.remedy
    first.release()
    second.claim([])
    second.release()


def test_a_new_rig_waits_for_the_processes_of_a_killed_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fieldrig.system.run_folder.LINGER_S", 0.05)
    folder = RunFolder(tmp_path)
    folder.claim([])
    with join_run(tmp_path), join_run(tmp_path), pytest.raises(RigError, match="processes of an earlier rig"):
        folder.wait_for_the_last()
    folder.wait_for_the_last()
    folder.release()


def test_sockets_and_pty_links_are_swept_and_all_else_stays(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path / "r")
    folder.claim([])
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(folder.folder / "w.sock"))
    (folder.folder / "modbus").symlink_to("/dev/pts/999")
    (folder.folder / "mine").symlink_to(tmp_path)
    (folder.folder / "state/io.bin").write_bytes(b"1")
    folder.release()
    left = {str(path.relative_to(folder.folder)) for path in folder.folder.rglob("*")}
    assert {"mine", "state/io.bin"} <= left
    assert not {"w.sock", "modbus"} & left


def test_a_folder_too_deep_for_unix_sockets_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RigError, match="too long a path") as refused:
        RunFolder(tmp_path / ("x" * 100)).claim(["can0.sock"])
    assert "--set run=" in refused.value.remedy


@pytest.mark.parametrize("name", ["file", "file/lab", "file/lab/run"])
def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(RigError, match=r"file.* is no folder") as refused:
        RunFolder(tmp_path / name).claim([])
    assert refused.value.remedy == "name another folder: --set run=FOLDER"
