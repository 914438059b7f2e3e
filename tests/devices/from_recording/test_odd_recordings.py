"""Recordings of which no rig can be made, or only a part of one: sensible words, and never half a folder."""

import re
from heapq import merge
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from made_rigs import keys_of, read_by_sdo, rig_file, virtual, written_log
from typer.testing import CliRunner

from fieldrig.cli.app import app
from fieldrig.errors import UsageError
from fieldrig_devices.from_recording.content import content_for

ASKED = [f"{turn} 605#4000100000000000" for turn in range(5)]


def words_about(log: Path, *words: str) -> str:
    with pytest.raises(UsageError) as refused:
        content_for(log, words)
    return str(refused.value)


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ([], "has no message"),
        (["0 20000080#0000000000000000"], "has no message"),
        ([f"{turn} 18FEF100#FFFFFFFFFFFFFFFF" for turn in range(9)], "9 frames with identifiers of 29 bits, as J1939"),
        ([f"{turn} 123#0102" for turn in range(9)], "identifiers that no node accounts for: 123h (9 frames)"),
        (ASKED, "node 5 never answered 5 SDO requests"),
        ([f"{turn} 705#R" for turn in range(3)], "node 5 never answered 3 guarding requests"),
        (
            [f"{node / 100} {0x600 + node:03X}#4000100000000000" for node in (1, 2, 3, 9)],
            "nodes 1 to 3, 9 never answered 1 SDO request each: they are no devices here",
        ),
        ([f"{turn} 0A5#0102030405060708" for turn in range(3)], "shows no device"),
        (["0 5E3#9C3B2F774B25865A", "1 663#3E32EA5A14A9272B", "2 3E3#01"], "node 99 never answered 1 SDO request"),
    ],
)
def test_a_log_without_a_device_says_what_it_has(tmp_path: Path, lines: list[str], words: str) -> None:
    assert words in words_about(written_log(tmp_path, *lines))


def test_no_folder_is_made_of_such_a_log(tmp_path: Path) -> None:
    log = written_log(tmp_path, *ASKED)
    result = CliRunner().invoke(app, ["new", "--from", str(log), str(tmp_path / "rig")])
    assert result.exit_code != 0
    assert not (tmp_path / "rig").exists()


def test_two_buses_are_two_parts_of_one_rig(tmp_path: Path) -> None:
    log = written_log(
        tmp_path, "0 can0 705#00", "0.1 can1 705#00", "0.2 can0 705#7F", "0.3 can1 705#05", "0.4 can1 705#05"
    )
    keys = keys_of(rig_file(log))
    assert list(keys["buses"]) == ["can0", "can1"]
    assert {name: device["links"]["can"] for name, device in keys["devices"].items()} == {
        "can0-node5": "can0",
        "can1-node5": "can1",
    }


def test_a_log_that_begins_in_a_transfer_is_read_from_the_next_one_on(tmp_path: Path) -> None:
    middle = ["0 585#0041424344454647", "0.01 605#7000000000000000", "0.02 585#1041424344454647"]
    log = written_log(tmp_path, *middle, *read_by_sdo(0.1, 5, "4B00200007000000"))
    with virtual(rig_file(log)) as rig:
        assert rig.get("node5/2000:00") == 7


@pytest.mark.parametrize(("first", "is_lost"), [("8000100000000405", True), ("", True), ("4300100092010200", False)])
def test_a_drive_that_loses_its_first_request_is_known_by_what_its_master_did_then(
    tmp_path: Path, first: str, is_lost: bool
) -> None:
    """A master aborts by 0504 0000h when its time is over (CiA 301, 7.2.4.3.17), asks again, or has its answer."""
    then = [f"1.5 {'604' if first[:2] == '80' else '584'}#{first}"] if first else []
    log = written_log(
        tmp_path, "0 000#8104", "0.5 704#00", "1 604#4000100000000000", *then,
        *read_by_sdo(2, 4, "4300100092010200"), *read_by_sdo(2.1, 4, "4B41600050020000"),
        *read_by_sdo(2.2, 4, "43026500C0000000"), *(f"{3 + turn / 10} 704#7F" for turn in range(5)),
    )  # fmt: skip
    rig = rig_file(log)
    text = rig.read_text(encoding="utf-8")
    assert f"loses_first_sdo {str(is_lost).lower()}" in " ".join(text.replace("#", "").split())
    checked = CliRunner().invoke(app, ["check", str(rig)])
    assert (checked.exit_code, "warning" in checked.output) == (0, False), checked.output


def test_a_master_that_others_watch_is_no_device(tmp_path: Path) -> None:
    watched = ["0.1 605#23161001C8007F00", "0.101 585#6016100100000000"]
    log = written_log(tmp_path, "0 705#00", *watched, *(f"{0.2 + turn / 10} 77F#05" for turn in range(9)))
    rig = rig_file(log)
    assert list(keys_of(rig)["devices"]) == ["node5"]
    assert "node 127 sends nothing but a heartbeat" in " ".join(rig.read_text().split("#"))


@pytest.mark.long
def test_127_nodes_share_the_process_of_their_bus(tmp_path: Path) -> None:
    log = written_log(tmp_path, *(f"{node / 1000} {0x700 + node:03X}#00" for node in range(1, 128)))
    keys = keys_of(rig_file(log))
    assert len(keys["devices"]) == 127
    assert {device["process"] for device in keys["devices"].values()} == {"can0"}


def test_a_file_that_fits_no_node_is_refused_with_the_nodes(tmp_path: Path) -> None:
    eds = Path(__file__).parents[3] / "configs/eds/io32.eds"
    log = written_log(
        tmp_path,
        "0 705#00",
        "0.1 706#00",
        *read_by_sdo(1, 5, "4300100001000000"),
        *read_by_sdo(2, 6, "4300100002000000"),
    )
    assert "the nodes are 5, 6: write --with NODE=" in words_about(log, str(eds))
    assert "the nodes are 5, 6" in words_about(log, f"7={eds}")
    assert "128 is no node-ID" in words_about(log, f"128={eds}")


def test_a_file_describes_a_node_of_one_of_two_buses(tmp_path: Path) -> None:
    eds = Path(__file__).parents[3] / "configs/eds/io32.eds"
    keys = keys_of(rig_file(written_log(tmp_path, "0 can0 705#00", "0.1 can1 706#00"), f"6={eds}"))
    assert [device["eds"] for device in keys["devices"].values()] == ["eds/can0-node5.eds", "eds/io32.eds"]


def test_a_file_that_cannot_do_what_the_recording_shows_is_said(tmp_path: Path) -> None:
    text = (Path(__file__).parents[3] / "configs/eds/io32.eds").read_text(encoding="ascii")
    for gone in ("[1017]", "[1800sub5]"):
        text = re.sub(rf"{re.escape(gone)}\n(?:[^\[\n].*\n)*", "", text)
        assert gone not in text
    eds = tmp_path / "old.eds"
    eds.write_text(text, encoding="ascii")
    both = (
        (f"{1 + turn / 20:.3f} 185#00000000" for turn in range(60)),
        (f"{1 + turn / 10:.3f} 705#05" for turn in range(30)),
    )
    log = written_log(tmp_path, "0 705#00", "0.1 000#0105", *merge(*both), *read_by_sdo(9, 5, "4300100001000000"))
    said = rig_file(log, f"5={eds}").read_text(encoding="utf-8")
    assert "# - the file has no 1017h: the heartbeat every 100 ms is not sent\n" in said
    assert "# - the file has no 1800:05: the PDO is not sent every 50 ms\n" in said
    assert "# - 1000:00 is 1h in the recording, and " in said


def test_a_name_that_fits_on_no_line_is_written_all_the_same(tmp_path: Path) -> None:
    log = written_log(tmp_path, "0 705#00").rename(tmp_path / "ma\nchine\udcff.log")
    with virtual(rig_file(log)) as rig:
        rig.run_until(10_000_000)
        assert rig.get("node5/nmt.state") == "pre_operational"


def test_with_needs_from() -> None:
    result = CliRunner().invoke(app, ["new", "--with", "x.eds"])
    assert result.exit_code != 0
    assert "--with goes with --from" in result.output


FRAMES = st.tuples(
    st.sampled_from(["000", "080", "085", "100", "185", "205", "285", "585", "605", "705", "7E5", "123", "18FEF100"]),
    st.one_of(st.binary(max_size=8).map(bytes.hex), st.sampled_from(["R", "R1", "00", "05", "7F"])),
)


@pytest.mark.long
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(FRAMES, max_size=40))
def test_any_frames_make_a_valid_rig_or_a_refusal(tmp_path: Path, frames: list[tuple[str, str]]) -> None:
    log = written_log(
        tmp_path, *(f"{place / 100} {identifier}#{data}" for place, (identifier, data) in enumerate(frames))
    )
    try:
        rig = rig_file(log)
    except UsageError:
        return
    with virtual(rig) as running:
        running.run_until(100_000_000)


@pytest.mark.parametrize(
    ("device_type", "words"), [("92010200", "8611h following error"), ("91010F00", "8611h monitoring")]
)
def test_an_error_code_is_named_by_the_profile_of_its_node(tmp_path: Path, device_type: str, words: str) -> None:
    """8611h is the following error of CiA 402; CiA 301 knows its class only."""
    log = written_log(
        tmp_path, *read_by_sdo(0, 4, f"43001000{device_type}"), *read_by_sdo(0.1, 4, "4B41600050020000"),
        "1 084#1186200000000000",
    )  # fmt: skip
    text = " ".join(rig_file(log).read_text(encoding="utf-8").replace("#", "").split())
    assert f"EMCY: {words}, register 20h" in text
