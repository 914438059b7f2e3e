"""Files and folders that another user has prepared are neither used nor deleted."""

import os
import stat
from pathlib import Path

import pytest
from pydantic import ValidationError
from running_rig import RunningRig

from fieldrig.config.rig_file import load
from fieldrig.control import endpoint
from fieldrig.errors import ConfigError, RigError
from fieldrig.real.child import not_started
from fieldrig.settings import RunPath, Settings
from fieldrig.storage.store import FileStore, StoreError
from fieldrig.system.own_files import OUTSIDE_VARIABLE, open_file, open_own, own_folder, part_of, remove_socket
from fieldrig.system.run_folder import RunFolder, join_run

pytestmark = pytest.mark.system

AS_ROOT = pytest.mark.skipif(os.geteuid() != 0, reason="needs root, which can make files of another user")
OTHER_USER = 12_345


def mode_of(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@pytest.fixture
def precious(tmp_path: Path) -> Path:
    """A file of another program."""
    file = tmp_path / "precious"
    file.write_text("keep me")
    return file


def test_a_new_run_folder_is_for_this_user_only(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path / "run/lab")
    folder.claim([])
    assert mode_of(folder.folder) == 0o700
    assert mode_of(folder.folder / "log") == mode_of(folder.folder / "state") == 0o700
    assert mode_of(folder.folder / "rig.lock") == 0o600
    folder.release()


@AS_ROOT
@pytest.mark.parametrize("use", [lambda path: RunFolder(path).claim([]), join_run])
def test_a_run_folder_of_another_user_is_refused(use: object, tmp_path: Path) -> None:
    assert callable(use)
    folder = tmp_path / "lab"
    folder.mkdir()
    os.chown(folder, OTHER_USER, OTHER_USER)
    with pytest.raises(RigError, match="belongs to another user") as refused:
        use(folder)
    assert "--set run=FOLDER" in refused.value.remedy
    assert list(folder.iterdir()) == []


@AS_ROOT
def test_a_link_of_another_user_to_a_folder_of_ours_is_refused(tmp_path: Path) -> None:
    """The other user could let it lead to another folder of ours while the rig runs."""
    folder, link = tmp_path / "lab", tmp_path / "link"
    own_folder(folder)
    link.symlink_to(folder)
    own_folder(link)  # our own link
    os.chown(link, OTHER_USER, OTHER_USER, follow_symlinks=False)
    with pytest.raises(RigError, match="link of another user"):
        RunFolder(link).claim([])


@pytest.mark.parametrize("mode", [0o770, 0o707, 0o777, 0o1777])
@pytest.mark.parametrize("use", [lambda path: RunFolder(path).claim([]), join_run])
def test_a_run_folder_that_others_may_write_to_is_refused(use: object, mode: int, tmp_path: Path) -> None:
    assert callable(use)
    folder = tmp_path / "lab"
    folder.mkdir()
    folder.chmod(mode)
    with pytest.raises(RigError, match="other users may write") as refused:
        use(folder)
    assert "chmod go-w" in refused.value.remedy


def test_a_folder_with_other_files_is_no_run_folder(tmp_path: Path, precious: Path) -> None:
    tmp_path.chmod(0o700)
    with pytest.raises(RigError, match="is no run folder: it has other files, such as precious"):
        RunFolder(tmp_path).claim([])
    assert precious.read_text(encoding="utf-8") == "keep me"


@pytest.mark.parametrize("name", ["log", "state"])
def test_a_project_with_a_folder_of_a_common_name_is_no_run_folder(name: str, tmp_path: Path, precious: Path) -> None:
    tmp_path.chmod(0o700)
    (tmp_path / name).mkdir()
    with pytest.raises(RigError, match="is no run folder: it has other files, such as precious"):
        RunFolder(tmp_path).claim([])
    precious.unlink()
    folder = RunFolder(tmp_path)  # as a rig leaves it that is killed while it makes the folder
    folder.claim([])
    folder.release()


@pytest.mark.parametrize("suffix", ["", ".lock"])
def test_a_control_socket_takes_no_file_of_others(suffix: str, tmp_path: Path) -> None:
    """Zenoh deletes what is at the path of its socket, and at that of its lock beside it."""
    precious = tmp_path / f"precious{suffix}"
    precious.write_text("keep me")
    with pytest.raises(RigError, match=f"precious{suffix} is there, and does not belong to a socket"):
        endpoint.listen(f"unixsock-stream/{tmp_path}/precious")
    assert precious.read_text() == "keep me"


@pytest.mark.parametrize("path", ["/tmp/rig.sock", "up.sock", "run/lab/../up", "../up"])
def test_a_control_socket_of_a_rig_file_stays_in_the_run_folder(
    path: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(OUTSIDE_VARIABLE, raising=False)
    file = tmp_path / "rig.yaml"
    file.write_text(f"time: virtual\nrun: run/lab\ncontrol: unixsock-stream/{path}\n")
    with pytest.raises(ConfigError, match=r"rig.yaml:3: control: .* is outside the run folder run/lab"):
        load(file)
    control = f"unixsock-stream/{path}"
    assert load(file, [f"control={control}"]).control == control, "the user has typed it"
    monkeypatch.setenv(OUTSIDE_VARIABLE, "1")
    assert load(file).control == control
    monkeypatch.delenv(OUTSIDE_VARIABLE)
    file.write_text("time: virtual\nrun: run/lab\ncontrol: unixsock-stream/run/lab/c\n")
    assert load(file).control == "unixsock-stream/run/lab/c"


WRITTEN = {
    "a pty of a serial line": ("buses.line.path", "{kind: serial.pty, path: PATH}"),
    "a pty of a Modbus line": ("buses.line.pty", "{kind: modbus.rtu, pty: PATH}"),
    "a pty of Lawicel": ("buses.line.slcan.path", "{kind: can.hub, slcan: {path: PATH}}"),
}


@pytest.mark.long
@pytest.mark.parametrize("name", WRITTEN)
def test_paths_outside_are_for_the_user_to_allow_where_he_starts_the_rig(name: str, tmp_path: Path) -> None:
    """Each key of a rig file that is a path to be written, beside `control`."""
    key, bus = WRITTEN[name]
    outside = tmp_path / "outside"
    text = f"time: real\nbuses: {{line: {bus.replace('PATH', str(outside))}}}\ndevices: {{}}\n"
    with RunningRig(text, None) as refused:
        assert refused.ended() == 2
        assert f"lab.yaml:2: {key}: {outside} is outside the run folder" in refused.output()
        assert "--outside-paths" in refused.output()
    assert not outside.is_symlink()
    with RunningRig(text, None, "--outside-paths") as rig:
        rig.until_ready()
        assert str(outside.readlink()).startswith("/dev/pts/")
    assert not outside.is_symlink()


@pytest.mark.parametrize("name", ["rig.lock", "processes.lock"])
def test_a_lock_that_is_a_link_is_not_followed(name: str, tmp_path: Path, precious: Path) -> None:
    folder = tmp_path / "lab"
    folder.mkdir()
    (folder / name).symlink_to(precious)
    claimed = RunFolder(folder)

    def start() -> None:
        claimed.claim([])
        claimed.wait_for_the_last()

    with pytest.raises(RigError, match=f"{name} is a link"):
        start()
    claimed.release()
    if name == "processes.lock":
        with pytest.raises(RigError, match=f"{name} is a link"):
            join_run(folder)
    assert precious.read_text(encoding="utf-8") == "keep me"


def test_a_log_that_is_a_link_is_named(tmp_path: Path, precious: Path) -> None:
    """Once, it was said that the system had no room for the process."""
    log = tmp_path / "meters.log"
    log.symlink_to(precious)
    with pytest.raises(OSError) as failed:  # noqa: PT011  the error of the system
        open_file(log, "ab")
    said = not_started(failed.value, "meters", "the rig takes 1 process")
    assert str(said) == f"{log} is a link\n  remove it, and start the rig again"
    no_process = not_started(OSError(11, "Resource temporarily unavailable"), "meters", "the rig takes 1 process")
    assert "no room for the process meters" in str(no_process)


@pytest.mark.parametrize("part", ["log", "state", "serial"])
def test_a_part_of_the_run_folder_that_is_a_link_is_refused(part: str, tmp_path: Path) -> None:
    folder, elsewhere = tmp_path / "lab", tmp_path / "elsewhere"
    own_folder(folder)
    own_folder(elsewhere)
    (folder / part).symlink_to(elsewhere)
    with pytest.raises(RigError, match="is a link"):
        part_of(folder, f"{part}/x")
    assert list(elsewhere.iterdir()) == []


def test_a_store_follows_no_link_and_is_readable_by_its_user_only(tmp_path: Path, precious: Path) -> None:
    store = FileStore(own_folder(tmp_path / "state") / "max4.bin", "max4")
    (tmp_path / "state/max4.bin.new").symlink_to(precious)
    with pytest.raises(StoreError):
        store.save(b"password")
    store.save(b"password")  # the link itself was removed, as what is left of a save that failed
    assert mode_of(tmp_path / "state/max4.bin") == 0o600
    (tmp_path / "state/max4.ram").symlink_to(precious)
    with pytest.raises(StoreError):
        store.buffered_ram(16)
    (tmp_path / "state/max4.bin").unlink()
    (tmp_path / "state/max4.bin").symlink_to(precious)
    assert store.load() is None
    assert precious.read_text(encoding="utf-8") == "keep me"


def test_a_file_of_an_earlier_version_is_no_longer_readable_by_all(tmp_path: Path) -> None:
    file = tmp_path / "max4.ram"
    file.write_bytes(bytes(4))
    file.chmod(0o644)
    open_file(file, "r+b").close()
    assert mode_of(file) == 0o600


def test_a_second_name_of_a_file_is_not_written(tmp_path: Path, precious: Path) -> None:
    (tmp_path / "log").hardlink_to(precious)
    with pytest.raises(PermissionError):
        open_own(tmp_path / "log", os.O_WRONLY | os.O_APPEND)


@pytest.mark.parametrize("flags", [os.O_RDONLY, os.O_RDWR, os.O_WRONLY | os.O_CREAT | os.O_APPEND])
def test_a_named_pipe_is_refused_at_once(flags: int, tmp_path: Path) -> None:
    pipe = tmp_path / "processes.lock"
    os.mkfifo(pipe)
    with pytest.raises(PermissionError, match="not a plain file"):
        open_own(pipe, flags)


@AS_ROOT
def test_a_file_of_another_user_is_not_opened(tmp_path: Path, precious: Path) -> None:
    os.chown(precious, OTHER_USER, OTHER_USER)
    with pytest.raises(PermissionError):
        open_own(precious, os.O_RDONLY)


def test_only_a_socket_is_deleted_as_one(tmp_path: Path, precious: Path) -> None:
    with pytest.raises(FileExistsError):
        remove_socket(precious)
    link = tmp_path / "link"
    link.symlink_to(precious)
    with pytest.raises(FileExistsError):
        remove_socket(link)
    assert precious.read_text(encoding="utf-8") == "keep me"


class Keys(Settings):
    path: RunPath


@pytest.mark.parametrize("path", ["/dev/ttyLAB", "../up", "serial/../../up", "/tmp/x"])
def test_a_path_that_leaves_the_run_folder_is_for_the_user_to_allow(
    path: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(OUTSIDE_VARIABLE, raising=False)
    with pytest.raises(ValidationError, match="outside the run folder"):
        Keys(path=path)
    with pytest.raises(RigError, match="outside the run folder") as refused:
        part_of(tmp_path / "lab", path)
    assert "--outside-paths" in refused.value.remedy
    monkeypatch.setenv(OUTSIDE_VARIABLE, "1")
    assert Keys(path=path).path == path


@pytest.mark.parametrize("path", ["modbus", "serial/com1", "a/b/c"])
def test_a_path_in_the_run_folder_is_taken(path: str, tmp_path: Path) -> None:
    assert Keys(path=path).path == path
    folder = own_folder(tmp_path / "lab")
    assert part_of(folder, path) == folder / path
    assert (folder / path).parent.is_dir()
