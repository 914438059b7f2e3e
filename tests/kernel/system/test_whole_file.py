"""Files that a command writes: whole or not at all, in the place that the user has named."""

import os
import stat
from collections.abc import Callable
from pathlib import Path

import pytest

from fieldrig.system.whole_file import replace_file, replace_own_file, whole_file


def test_a_pipe_or_device_gets_the_data_and_stays_what_it_is(tmp_path: Path) -> None:
    """Root once made a plain file of a device: `--junit /dev/null`."""
    if not hasattr(os, "mkfifo"):
        pytest.skip("needs named pipes")
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    try:
        replace_file(pipe, b"report")
        assert pipe.is_fifo()
        assert os.read(reader, 100) == b"report"
    finally:
        os.close(reader)


def test_a_link_stays_one_and_its_file_gets_the_data(tmp_path: Path) -> None:
    (tmp_path / "shared.st").write_bytes(b"old")
    (tmp_path / "link.st").symlink_to("shared.st")
    replace_file(tmp_path / "link.st", b"new")
    assert (tmp_path / "link.st").is_symlink()
    assert (tmp_path / "shared.st").read_bytes() == b"new"


def test_a_file_keeps_its_mode(tmp_path: Path) -> None:
    file = tmp_path / "report.xml"
    file.write_bytes(b"old")
    file.chmod(0o640)
    replace_file(file, b"new")
    assert file.stat().st_mode & 0o777 == 0o640


def test_a_file_that_could_not_be_written_whole_is_as_it_was(tmp_path: Path) -> None:
    file = tmp_path / "report.xml"
    file.write_bytes(b"old")
    with pytest.raises(OSError, match="full"):
        _write_half(file)
    assert [path.name for path in tmp_path.iterdir()] == ["report.xml"]
    assert file.read_bytes() == b"old"


def test_the_folder_of_a_file_is_made(tmp_path: Path) -> None:
    replace_file(tmp_path / "reports" / "ci" / "junit.xml", b"new")
    assert (tmp_path / "reports" / "ci" / "junit.xml").read_bytes() == b"new"


@pytest.mark.parametrize("replace", [replace_file, replace_own_file])
def test_what_a_killed_process_of_the_same_number_left_is_no_obstacle(
    tmp_path: Path, replace: Callable[[Path, bytes], None]
) -> None:
    """The first process of a container always has the number 1."""
    (tmp_path / f".report.xml.{os.getpid()}").write_bytes(b"half")
    replace(tmp_path / "report.xml", b"new")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"report.xml": b"new"}


def test_a_file_of_a_rig_is_for_its_user_and_takes_the_place_of_a_link(tmp_path: Path) -> None:
    (tmp_path / "foreign").write_bytes(b"foreign")
    (tmp_path / "setup.json").symlink_to("foreign")
    replace_own_file(tmp_path / "setup.json", b"new")
    assert (tmp_path / "foreign").read_bytes() == b"foreign"
    assert (tmp_path / "setup.json").read_bytes() == b"new"
    assert (tmp_path / "setup.json").lstat().st_mode & 0o777 == 0o600


@pytest.mark.skipif(not hasattr(os, "O_DIRECTORY"), reason="the system cannot write a folder through")
@pytest.mark.parametrize("replace", [replace_file, replace_own_file])
def test_the_new_name_is_written_through_as_the_data_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, replace: Callable[[Path, bytes], None]
) -> None:
    written: list[bool] = []
    real = os.fsync

    def fsync(number: int) -> None:
        written.append(stat.S_ISDIR(os.fstat(number).st_mode))
        real(number)

    monkeypatch.setattr(os, "fsync", fsync)
    replace(tmp_path / "plate.yaml", b"new")
    assert written == [False, True]


def _write_half(path: Path) -> None:
    with whole_file(path) as file:
        file.write(b"half")
        raise OSError("full")
