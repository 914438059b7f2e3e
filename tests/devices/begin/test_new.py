"""`fieldrig new`: the files that it writes, those that it doesn't touch, and what it refuses."""

import re
from pathlib import Path, PurePosixPath
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner, Result

from fieldrig.cli.app import app
from fieldrig.clock import S
from fieldrig.config.keys import NAME
from fieldrig.errors import UsageError
from fieldrig.pytest_plugin import RigMaker
from fieldrig.text.device_names import name_for
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.begin.command import complete_example
from fieldrig_devices.begin.eds_rig import content_for
from fieldrig_devices.begin.examples import content_of, folder, menu

CONFIGS = Path(__file__).parents[3] / "configs"
SENSOR = CONFIGS / "eds" / "level-sensor.eds"
COMMISSIONING = b"\r\n[DeviceComissioning]\r\nNodeID=0x22\r\nBaudrate=125\r\n"


def new(*words: str | Path) -> Result:
    return CliRunner().invoke(app, ["new", *map(str, words)])


def test_a_clone_has_the_examples_of_its_configs() -> None:
    assert folder() == CONFIGS


@pytest.mark.long
def test_every_rig_file_of_the_folder_belongs_to_an_example() -> None:
    written = {path for example in menu() for path in content_of(example)}
    assert {file.name for file in CONFIGS.glob("*.yaml")} <= {str(path) for path in written}


@pytest.mark.long
def test_the_menu_is_a_table_with_a_sentence_for_each_example() -> None:
    shown = new().stdout
    for example, about in menu().items():
        assert re.search(rf"^{example} +{re.escape(about)}\s*$", shown, re.MULTILINE)
        assert about.endswith(".")


@pytest.mark.long
def test_an_example_comes_with_its_eds_register_table_variants_and_test(tmp_path: Path) -> None:
    assert new("lab", tmp_path / "bench").exit_code == 0
    written = {str(file.relative_to(tmp_path / "bench")) for file in (tmp_path / "bench").rglob("*") if file.is_file()}
    assert written == {
        "lab.yaml",
        "lab-vcan.yaml",
        "test_lab.py",
        "eds/io32.eds",
        "eds/level-sensor.eds",
        "registers/pump-drive.yaml",
    }
    assert (tmp_path / "bench/lab.yaml").read_bytes() == (CONFIGS / "lab.yaml").read_bytes()


def test_the_class_of_a_kind_of_ones_own_is_written_too() -> None:
    assert PurePosixPath("press.py") in content_of("own-device")


@pytest.mark.long
def test_the_next_three_commands_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    next_ones = new("lab", "my bench").stdout.partition("next:\n")[2].splitlines()
    assert next_ones == [
        "  fieldrig check 'my bench/lab.yaml'",
        "  fieldrig up 'my bench/lab.yaml'",
        "  python -m pytest 'my bench'",
    ]


@pytest.mark.long
def test_the_folder_has_the_name_of_the_example(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    new("lab")
    new("--eds", SENSOR)
    assert (tmp_path / "lab/lab.yaml").is_file()
    assert (tmp_path / "level-sensor/level-sensor.yaml").is_file()


@pytest.mark.long
def test_no_file_is_overwritten_and_then_none_is_written(tmp_path: Path) -> None:
    (tmp_path / "registers").mkdir()
    table = tmp_path / "registers/pump-drive.yaml"
    table.write_text("mine")
    refused = new("lab", tmp_path).exception
    assert isinstance(refused, UsageError)
    assert "registers/pump-drive.yaml" in refused.what
    assert [file for file in tmp_path.rglob("*") if file.is_file()] == [table]
    assert table.read_text() == "mine"


@pytest.mark.long
def test_examples_that_share_a_file_go_into_one_folder(tmp_path: Path) -> None:
    assert [new(example, tmp_path).exit_code for example in ("lab", "ring", "lab")] == [0, 0, 0]


@pytest.mark.long
@pytest.mark.parametrize("taken", ["eds", "eds/io32.eds/x", "lab.yaml/x"])
def test_a_folder_that_cannot_be_is_refused(tmp_path: Path, taken: str) -> None:
    """A file in the place of a folder is refused, and so is a folder in the place of a file."""
    place = tmp_path / taken
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_text("mine")
    assert isinstance(new("lab", tmp_path).exception, UsageError)
    assert [file for file in tmp_path.rglob("*") if file.is_file()] == [place]


@pytest.mark.long
@pytest.mark.parametrize(
    ("words", "remedy"),
    [(("lba",), "did you mean lab?"), (("x.eds",), "fieldrig new --eds x.eds"), (("--eds", "no.eds"), "expected an")],
)
def test_what_cannot_be_made_is_refused_with_a_remedy(words: tuple[str, ...], remedy: str) -> None:
    refused = new(*words).exception
    assert isinstance(refused, UsageError)
    assert remedy in refused.remedy


def test_an_eds_becomes_a_node_that_a_master_finds(tmp_path: Path, fieldrig_rig: RigMaker) -> None:
    assert new("--eds", SENSOR, tmp_path).exit_code == 0
    assert (tmp_path / "eds/level-sensor.eds").read_bytes() == SENSOR.read_bytes()
    rig = fieldrig_rig(tmp_path / "level-sensor.yaml")
    received: list[CanFrame] = []
    can = rig.attach("master").link("can0")
    can.on_receive(received.append)
    rig.run_until(1 * S)
    can.send(CanFrame(0x601, bytes.fromhex("40 00 10 00 00 00 00 00")))
    rig.run_until(2 * S)
    # CiA 404 (0194h) with an analog input; the EDS file says so in 1000h.
    assert [frame.data.hex(" ") for frame in received] == ["00", "43 00 10 00 94 01 02 00"]


def test_a_dcf_says_node_id_and_bit_rate(tmp_path: Path) -> None:
    dcf = tmp_path / "Level Sensor #2.dcf"
    dcf.write_bytes(SENSOR.read_bytes() + COMMISSIONING)
    content = content_for(dcf)
    rig = content[PurePosixPath("level-sensor-2.yaml")].decode()
    assert "node_id: 34\n" in rig
    assert "bitrate: 125000\n" in rig
    assert 'eds: "eds/Level Sensor #2.dcf"\n' in rig


def test_an_eds_that_makes_no_node_is_refused_with_what_is_wrong(tmp_path: Path) -> None:
    broken = tmp_path / "broken.eds"
    broken.write_text("[DeviceInfo]\nVendorName=nobody\n")
    refused = new("--eds", broken, tmp_path / "made").exception
    assert isinstance(refused, UsageError)
    assert "1000" in refused.what
    assert not (tmp_path / "made").exists()


@given(st.text(max_size=20))
def test_every_file_name_gives_a_name_for_a_rig(stem: str) -> None:
    assert re.fullmatch(NAME, name_for(Path(f"x{stem}.eds".replace("/", "").replace("\0", ""))))
    assert re.fullmatch(NAME, name_for(Path("/").joinpath(stem.replace("/", "").replace("\0", "") + ".eds")))


@given(st.binary(max_size=200))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_bytes_make_a_node_or_are_refused(tmp_path: Path, data: bytes) -> None:
    file = tmp_path / "any.eds"
    file.write_bytes(data + COMMISSIONING + data)
    with pytest.raises(UsageError):
        content_for(file)


@pytest.mark.long
def test_the_shell_is_told_of_the_examples() -> None:
    assert complete_example("la") == [("lab", menu()["lab"])]
    assert [name for name, _ in complete_example("")] == list(menu())


def test_a_full_disk_leaves_no_half_of_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = Path.mkdir

    def fails_in_eds(path: Path, *arguments: Any, **keys: Any) -> None:
        if path.name == "eds":
            raise OSError(28, "No space left on device")
        real(path, *arguments, **keys)

    monkeypatch.setattr(Path, "mkdir", fails_in_eds)
    result = new("--eds", SENSOR, tmp_path / "bench")
    assert result.exit_code != 0
    assert f"{tmp_path / 'bench/eds/level-sensor.eds'} cannot be written: No space" in str(result.exception)
    assert list(tmp_path.iterdir()) == []
