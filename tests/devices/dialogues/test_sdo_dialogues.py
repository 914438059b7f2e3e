"""SDO transfers of a log: the bytes are those of CiA 301's pictures of the protocols (7.2.4.3), or python canopen's."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from canopen.sdo.exceptions import SdoAbortedError
from canopen_bench import CanopenBench
from canopen_wire import Wire
from hypothesis import given, settings
from hypothesis import strategies as st
from logs import can_entry, can_log

from fieldrig.clock import MS
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.eds.reader import load
from fieldrig_devices.dialogues import Dialogue, SdoTransfer, Stray, dialogues
from fieldrig_devices.dialogues.sdo_dialogues import MOST_OPEN, SdoDialogues

WRITE = ("605#2F 00 62 01 0F 00 00 00", "585#60 00 62 01 00 00 00 00")
READ = ("605#40 00 10 00 00 00 00 00", "585#43 00 10 00 91 01 0F 00")
READ_TEXT = (
    "605#40 08 10 00 00 00 00 00", "585#41 08 10 00 09 00 00 00",
    "605#60 00 00 00 00 00 00 00", "585#00 31 32 33 34 35 36 37",
    "605#70 00 00 00 00 00 00 00", "585#1B 38 39 00 00 00 00 00",
)  # fmt: skip
WRITE_TEXT = (
    "605#21 00 20 00 09 00 00 00", "585#60 00 20 00 00 00 00 00",
    "605#00 31 32 33 34 35 36 37", "585#20 00 00 00 00 00 00 00",
    "605#1B 38 39 00 00 00 00 00", "585#30 00 00 00 00 00 00 00",
)  # fmt: skip
# 31C3h is the checksum of "123456789" in 7.2.4.3.16; five bytes of the last segment are unused
WRITE_BLOCK = (
    "605#C6 00 20 00 09 00 00 00", "585#A4 00 20 00 7F 00 00 00",
    "605#01 31 32 33 34 35 36 37", "605#82 38 39 00 00 00 00 00", "585#A2 02 7F 00 00 00 00 00",
    "605#D5 C3 31 00 00 00 00 00", "585#A1 00 00 00 00 00 00 00",
)  # fmt: skip
READ_BLOCK = (
    "605#A4 00 20 00 7F 00 00 00", "585#C6 00 20 00 09 00 00 00", "605#A3 00 00 00 00 00 00 00",
    "585#01 31 32 33 34 35 36 37", "585#82 38 39 00 00 00 00 00", "605#A2 02 7F 00 00 00 00 00",
    "585#D5 C3 31 00 00 00 00 00", "605#A1 00 00 00 00 00 00 00",
)  # fmt: skip
DIGITS = b"123456789"


def of(frames: Sequence[str]) -> list[Dialogue]:
    return list(dialogues(can_log(*frames)))


def one(*frames: str) -> SdoTransfer:
    """Return the only dialogue of these frames."""
    (found,) = of(frames)
    assert isinstance(found, SdoTransfer)
    return found


@pytest.mark.parametrize(
    ("frames", "index", "is_download", "data", "form"),
    [
        (WRITE, 0x6200, True, b"\x0f", "expedited"),
        (READ, 0x1000, False, bytes.fromhex("91 01 0F 00"), "expedited"),
        (READ_TEXT, 0x1008, False, DIGITS, "segmented"),
        (WRITE_TEXT, 0x2000, True, DIGITS, "segmented"),
        (WRITE_BLOCK, 0x2000, True, DIGITS, "block"),
        (READ_BLOCK, 0x2000, False, DIGITS, "block"),
    ],
)
def test_a_transfer_of_each_form_is_one_dialogue(
    frames: tuple[str, ...], index: int, is_download: bool, data: bytes, form: str
) -> None:
    found = one(*frames)
    assert (found.node_id, found.index, found.is_download, found.data, found.form) == (
        5,
        index,
        is_download,
        data,
        form,
    )
    assert (found.begin_ns, found.end_ns) == (0, (len(frames) - 1) * MS)
    assert found.entries == tuple(range(len(frames)))
    assert (found.abort, found.wrong, found.is_done) == (None, "", True)


ALL_FORMS = (WRITE, READ, READ_TEXT, WRITE_TEXT, WRITE_BLOCK, READ_BLOCK)


@pytest.mark.parametrize("is_client", [True, False], ids=["client", "server"])
@pytest.mark.parametrize("frames", ALL_FORMS)
def test_either_side_aborts_at_any_step(frames: tuple[str, ...], is_client: bool) -> None:
    multiplexer = frames[0][7:15]
    abort = f"{'605' if is_client else '585'}#80 {multiplexer} 22 00 00 08"
    for steps in range(1, len(frames)):
        found = one(*frames[:steps], abort)
        assert (found.abort, found.abort_by_client, found.end_ns) == (0x0800_0022, is_client, steps * MS)
        assert found.entries == tuple(range(steps + 1))
        assert found.data == (b"\x0f" if frames is WRITE else None)


@pytest.mark.parametrize("frames", ALL_FORMS)
def test_a_request_again_ends_what_was_open(frames: tuple[str, ...]) -> None:
    """The answers are missing from some step on, so the client asks for another object."""
    for steps in range(1, len(frames)):
        if frames is WRITE_BLOCK and 2 <= steps < 5:
            continue  # all that a client sends within a block is a segment of it
        first, second = of([*frames[:steps], "605#40 41 60 00 00 00 00 00", "585#4B 41 60 00 37 02 00 00"])
        assert isinstance(first, SdoTransfer)
        assert isinstance(second, SdoTransfer)
        assert (first.end_ns, first.wrong, first.is_done) == (None, "another request came before the answer", False)
        assert (second.index, second.data, second.wrong) == (0x6041, b"\x37\x02", "")


def test_a_request_that_is_repeated_is_told_so() -> None:
    first, second = of([READ[0], *READ])
    assert (first.end_ns, first.entries, second.entries) == (None, (0,), (1, 2))
    assert isinstance(first, SdoTransfer)
    assert first.wrong == "asked again"


@pytest.mark.parametrize(
    ("frames", "at"),
    [
        (READ_TEXT, 3),
        (READ_TEXT, 4),
        (READ_TEXT, 5),
        (WRITE_TEXT, 2),
        (WRITE_TEXT, 3),
        (WRITE_TEXT, 4),
        (WRITE_TEXT, 5),
    ],
)
def test_a_toggle_bit_that_does_not_alternate_spoils_the_data(frames: tuple[str, ...], at: int) -> None:
    identifier, first, *rest = frames[at].replace("#", " ").split()
    wrong = f"{identifier}#{int(first, 16) ^ 0x10:02X} {' '.join(rest)}"
    found = one(*frames[:at], wrong, "605#80 00 00 00 00 00 03 05")
    assert (found.wrong, found.abort, found.data) == ("the toggle bit did not alternate", 0x0503_0000, None)


def test_a_segment_that_is_sent_again_counts_once() -> None:
    found = one(*WRITE_TEXT[:3], *WRITE_TEXT[2:])
    assert (found.data, found.wrong) == (DIGITS, "")


def test_segments_of_a_block_after_a_gap_are_sent_again() -> None:
    found = one(*WRITE_BLOCK[:2], "605#82 38 39 00 00 00 00 00", "585#A2 00 7F 00 00 00 00 00", *WRITE_BLOCK[2:])
    assert (found.data, found.wrong) == (DIGITS, "")


def test_a_segment_that_the_log_lost_spoils_the_data() -> None:
    found = one(*(frame for frame in WRITE_BLOCK if frame[4:6] != "01"))
    assert (found.data, found.wrong) == (None, "segment 1 of a block is missing in the log")
    assert found.is_done


def test_a_wrong_checksum_and_a_wrong_size_are_told() -> None:
    found = one(*WRITE_BLOCK[:5], "605#D5 C4 31 00 00 00 00 00", WRITE_BLOCK[6])
    assert (found.data, found.wrong) == (DIGITS, "the checksum does not fit the data")
    found = one(READ_TEXT[0], "585#41 08 10 00 0A 00 00 00", *READ_TEXT[2:])
    assert (found.data, found.wrong) == (DIGITS, "9 bytes came, 10 were announced")


def test_a_block_upload_of_little_data_is_answered_in_another_form() -> None:
    """7.2.4.3.13: below the threshold of the client the server may switch to the other protocol."""
    found = one("605#A0 00 10 00 7F 0A 00 00", READ[1])
    assert (found.form, found.data) == ("expedited", bytes.fromhex("91 01 0F 00"))


def test_a_node_that_boots_up_has_forgotten_its_transfer() -> None:
    found = one(*READ_TEXT[:3], "705#00")
    assert (found.end_ns, found.wrong) == (None, "the node was restarted")
    assert of([*READ_TEXT[:3], "706#00", "705#05"])[0].end_ns is None  # another node, a heartbeat


@pytest.mark.parametrize("frames", ALL_FORMS)
def test_a_log_that_begins_in_the_middle_has_strays_and_then_transfers(frames: tuple[str, ...]) -> None:
    for missing in range(1, len(frames)):
        *strays, found = of([*frames[missing:], *READ])
        assert all(isinstance(stray, Stray) for stray in strays)
        assert [number for stray in strays for number in stray.entries] == list(range(len(frames) - missing))
        assert isinstance(found, SdoTransfer)
        assert found.data == bytes.fromhex("91 01 0F 00")


def test_segments_of_a_block_that_began_before_the_log_are_no_requests() -> None:
    """Segments 20h to 24h look like the beginning of downloads, and 40h to 5Fh like that of uploads."""
    numbers = [*range(0x3E, 0x43)]
    strays = of([f"605#{number:02X} 01 02 03 04 05 06 07" for number in numbers] + ["585#A2 7F 7F 00 00 00 00 00"])
    assert all(isinstance(stray, Stray) for stray in strays)
    assert sorted(number for stray in strays for number in stray.entries) == list(range(6))


@pytest.mark.parametrize(
    "answer",
    [
        "585#4F 00 10 01 01 00 00 00",  # another sub-index: an answer that comes too late
        "585#60 00 10 00 00 00 00 00",  # the answer to a download
        "585#80 18 10 00 00 00 02 06",  # an abort of another transfer
        "585#43 00 10 00",  # too short
    ],
)
def test_an_answer_that_belongs_to_no_request_changes_nothing(answer: str) -> None:
    stray, found = of([READ[0], answer, READ[1]])
    assert isinstance(stray, Stray)
    assert stray.entries == (1,)
    assert isinstance(found, SdoTransfer)
    assert (found.data, found.entries) == (bytes.fromhex("91 01 0F 00"), (0, 2))


@pytest.mark.parametrize(
    ("frames", "data"),
    [
        (("60A#40 00 1A 00", "58A#4F 00 1A 00 08 00 00 00"), b"\x08"),
        (("60A#2F 00 18 02 FE", "58A#60 00 18 02 00 00 00 00"), b"\xfe"),
        (("60A#2B 00 18 03 01 00", "58A#60 00 18 03"), b"\x01\x00"),
    ],
)
def test_messages_without_their_unused_bytes_are_taken_and_noted(frames: tuple[str, ...], data: bytes) -> None:
    """A CM588 of ABB answers to such requests; CiA 301 wants eight bytes always."""
    found = one(*frames)
    assert (found.node_id, found.data, found.wrong) == (10, data, "a message has fewer than eight bytes")


def test_another_channel_is_known_when_the_log_shows_its_identifiers() -> None:
    """7.5.2.33: 1201h:01 and :02 of node 5 become 3A0h and 3A1h, by a client on the default channel."""
    configured = (
        "605#23 01 12 01 A0 03 00 00", "585#60 01 12 01 00 00 00 00",
        "605#23 01 12 02 A1 03 00 00", "585#60 01 12 02 00 00 00 00",
    )  # fmt: skip
    other = [frame.replace("605#", "3A0#").replace("585#", "3A1#") for frame in READ]
    assert of(other) == []
    found = of([*configured, *other])[-1]
    assert isinstance(found, SdoTransfer)
    assert (found.node_id, found.index, found.request_id, found.entries) == (5, 0x1000, 0x3A0, (4, 5))
    closed = ("605#23 01 12 01 A0 03 00 80", "585#60 01 12 01 00 00 00 00")
    assert len(of([*configured, *closed, *other])) == 3


def test_another_channel_is_known_when_the_eds_file_of_the_node_has_it(tmp_path: Path) -> None:
    """7.5.2.33; the channel of node 5 depends on its node-ID, and that of 1202h is not used (bit 31)."""
    rows = ["[DeviceInfo]"]
    for index, ids in (("1201", ("$NODEID+0x3A0", "$NODEID+0x3B0")), ("1202", ("0x800003C0", "0x800003D0"))):
        rows += [f"[{index}]", "ParameterName=SDO", "ObjectType=9", "SubNumber=3"]
        for number, (kind, value) in enumerate(((5, "2"), (7, ids[0]), (7, ids[1]))):
            rows += [f"[{index}sub{number}]", f"ParameterName={number}", f"DataType={kind}", "AccessType=rw",
                     f"DefaultValue={value}"]  # fmt: skip
    (tmp_path / "two.eds").write_text("\n".join(rows))
    transfers = SdoDialogues()
    transfers.describe("can0", {5: load(tmp_path / "two.eds", 5)})
    other = [frame.replace("605#", "3A5#").replace("585#", "3B5#") for frame in READ]
    other += [frame.replace("605#", "3C0#").replace("585#", "3D0#") for frame in READ]
    found = [one for number, entry in enumerate(can_log(*other)) for one in transfers.take(number, entry)]
    assert [(one.node_id, one.index, one.entries) for one in found if isinstance(one, SdoTransfer)] == [
        (5, 0x1000, (0, 1))
    ]


def test_a_transfer_that_the_log_does_not_end_comes_last() -> None:
    first, second = of([READ_TEXT[0], *[frame.replace("05#", "06#").replace("85#", "86#") for frame in READ]])
    assert isinstance(first, SdoTransfer)
    assert isinstance(second, SdoTransfer)
    assert (first.node_id, second.node_id, second.wrong) == (6, 5, "the log ends before")


def test_buses_have_transfers_of_their_own() -> None:
    both = [entry for pair in zip(can_log(*READ_TEXT), can_log(*READ_TEXT, bus="can1"), strict=True) for entry in pair]
    assert [(found.bus, found.data) for found in dialogues(both) if isinstance(found, SdoTransfer)] == [
        ("can0", DIGITS),
        ("can1", DIGITS),
    ]


TEXT_EDS = (
    "[DeviceInfo]\n[1000]\nParameterName=Device type\nDataType=7\nAccessType=ro\n"
    "[2000]\nParameterName=Text\nDataType=9\nAccessType=rw\n"
)


@pytest.fixture(scope="module")
def eds(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("eds") / "text.eds"
    path.write_text(TEXT_EDS)
    return path


def connect(eds: Path) -> tuple[Wire, Any]:
    bench = CanopenBench(eds)
    assert bench.take() == ["705#00"]
    wire = Wire(bench)
    return wire, wire.add_node(5, str(eds))


ways = st.sampled_from(["plain", "segmented", "block"])


@settings(max_examples=20, deadline=None)
@given(content=st.binary(min_size=1, max_size=1000), way=ways, back=ways)
def test_transfers_of_python_canopen_have_the_data_that_it_sent(eds: Path, content: bytes, way: str, back: str) -> None:
    wire, node = connect(eds)
    _write(node, content, way)
    assert _read(node, back) == content
    found = list(dialogues(can_entry(time_ns, frame) for time_ns, frame in wire.frames))
    assert [(transfer.is_download, transfer.data, transfer.wrong) for transfer in found] == [  # type: ignore[attr-defined]
        (True, content, ""),
        (False, content, ""),
    ]
    assert sum(len(transfer.entries) for transfer in found) == len(wire.frames)


def test_an_access_that_the_node_refuses_has_its_abort_code(eds: Path) -> None:
    wire, node = connect(eds)
    with pytest.raises(SdoAbortedError, match="0x06010002"):
        node.sdo.download(0x1000, 0, b"1234")
    (found,) = dialogues(can_entry(time_ns, frame) for time_ns, frame in wire.frames)
    assert isinstance(found, SdoTransfer)
    assert (found.abort, found.abort_by_client) == (0x0601_0002, False)


def _write(node: Any, content: bytes, way: str) -> None:
    if way == "block":
        with node.sdo[0x2000].open("wb", size=len(content), block_transfer=True) as file:
            file.write(content)
    else:
        node.sdo.download(0x2000, 0, content, force_segment=way == "segmented")


def _read(node: Any, way: str) -> bytes:
    if way != "block":
        return bytes(node.sdo.upload(0x2000, 0))
    with node.sdo[0x2000].open("rb", block_transfer=True) as file:
        return bytes(file.read())


@settings(max_examples=40, deadline=None)
@given(st.data())
def test_any_interleaving_of_nodes_has_the_same_transfers(data: st.DataObject) -> None:
    forms = data.draw(st.lists(st.sampled_from(ALL_FORMS), min_size=2, max_size=6))
    streams = [
        [frame.replace("605#", f"60{node}#").replace("585#", f"58{node}#") for frame in frames]
        for node, frames in enumerate(forms, 1)
    ]
    order = data.draw(st.permutations([node for node, stream in enumerate(streams) for _ in stream]))
    waiting = [iter(stream) for stream in streams]
    found = of([next(waiting[node]) for node in order])
    told = {(one.node_id, one.index, one.data) for one in found if isinstance(one, SdoTransfer) and one.is_done}
    assert told == {(node, one(*frames).index, one(*frames).data) for node, frames in enumerate(forms, 1)}


frames_of_a_channel = st.builds(
    CanFrame, st.sampled_from([0x605, 0x585, 0x606, 0x586, 0x705, 0x6E0]), st.binary(max_size=8)
)


@settings(max_examples=60, deadline=None)
@given(st.lists(frames_of_a_channel, max_size=60))
def test_each_message_of_any_log_is_in_at_most_one_dialogue(frames: list[CanFrame]) -> None:
    entries = [can_entry(number, frame) for number, frame in enumerate(frames)]
    numbers = [number for found in dialogues(entries) for number in found.entries]
    assert len(numbers) == len(set(numbers))
    channels = {0x605, 0x585, 0x606, 0x586}
    assert {number for number, frame in enumerate(frames) if frame.identifier in channels} <= set(numbers)


@given(st.binary(max_size=20))
def test_any_bytes_of_an_entry_are_taken(data: bytes) -> None:
    assert list(dialogues([TraceEntry(0, "can0", "can", "", data)])) == [] or len(data) >= 5


def test_open_transfers_are_bounded() -> None:
    """A log may have any number of buses; the oldest transfer is given up."""
    sdo = SdoDialogues()
    ended = [
        found for number in range(MOST_OPEN + 10) for found in sdo.take(number, can_log(READ[0], bus=f"can{number}")[0])
    ]
    assert [found.entries for found in ended] == [(number,) for number in range(10)]
    assert len(sdo.unfinished()) == MOST_OPEN
