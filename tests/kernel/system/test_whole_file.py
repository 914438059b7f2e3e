"""Files that a command writes: whole or not at all, in the place that the user has named."""

import os
from pathlib import Path

import pytest

from fieldrig.system.whole_file import replace_file, whole_file


def test_a_pipe_or_device_gets_the_data_and_stays_what_it_is(tmp_path: Path) -> None:
    """As root, `--junit /dev/null` made a plain file of the device."""
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


def _write_half(path: Path) -> None:
    with whole_file(path) as file:
        file.write(b"half")
        raise OSError("full")
