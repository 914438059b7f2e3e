"""SDO client against byte tables of CiA 301 7.2.4.3, our server, and that of python-canopen; the server is node 1."""

from collections.abc import Callable
from typing import Any

import canopen
import pytest
from canopen_bench import IO32, CanopenBench, parse, show
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.clock import MS, VirtualClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.sdo.client import SdoClient

Script = list[tuple[str, str]]
"""Expected requests of the client, each with the server's answer, "" for none."""
TEXT = bytes.fromhex("46 69 65 6c 64 20 72 69 67 21")


class Bench:
    """A client, whose link and clock the test drives."""

    def __init__(self, node_id: int = 1) -> None:
        self.clock, self.can = VirtualClock(), RecordedLink[CanFrame]()
        self.client = SdoClient(self.clock, self.can, node_id, 100 * MS)
        self.results: list[Any] = []

    def upload(self, index: int, subindex: int) -> None:
        self.client.upload(index, subindex, self._done)

    def download(self, index: int, subindex: int, data: bytes) -> None:
        self.client.download(index, subindex, data, self._done)

    def _done(self, result: object) -> None:
        self.results.append(f"{result.code:08x}" if isinstance(result, Abort) else result)

    def play(self, script: Script) -> list[Any]:
        """Play the server's part, and return the result of the client."""
        for request, answer in script:
            assert self.take() == [f"601#{request}"]
            if answer:
                self.answer(answer)
        assert self.take() == []
        return self.results

    def answer(self, *answers: str) -> None:
        for answer in answers:
            self.can.deliver(parse(f"581#{answer}"))

    def take(self) -> list[str]:
        return [show(frame) for frame in self.can.take()]

    def after(self, ms: int) -> list[str]:
        self.clock.advance_to(self.clock.now_ns() + ms * MS)
        return self.take()


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_client_hears_its_server_only(bench: Bench) -> None:
    assert bench.can.interest == [[0x581, 0x8000_07FF]]


@pytest.mark.parametrize(
    ("data", "request_"),
    [
        ("5a", "2f 17 10 00 5a 00 00 00"),
        ("e8 03", "2b 17 10 00 e8 03 00 00"),
        ("01 02 03", "27 17 10 00 01 02 03 00"),
        ("01 02 03 04", "23 17 10 00 01 02 03 04"),
    ],
)
def test_up_to_four_bytes_are_written_at_once(bench: Bench, data: str, request_: str) -> None:
    bench.download(0x1017, 0, bytes.fromhex(data))
    assert bench.play([(request_, "60 17 10 00 00 00 00 00")]) == [None]


@pytest.mark.parametrize(
    ("answer", "data"),
    [
        ("4f 00 60 01 5a 00 00 00", "5a"),
        ("4b 00 60 01 e8 03 00 00", "e8 03"),
        ("47 00 60 01 01 02 03 00", "01 02 03"),
        ("43 00 60 01 01 02 03 04", "01 02 03 04"),
        ("42 00 60 01 01 02 03 04", "01 02 03 04"),  # without a size
    ],
)
def test_up_to_four_bytes_are_read_at_once(bench: Bench, answer: str, data: str) -> None:
    bench.upload(0x6000, 1)
    assert bench.play([("40 00 60 01 00 00 00 00", answer)]) == [bytes.fromhex(data)]


def test_more_is_written_in_segments(bench: Bench) -> None:
    bench.download(0x1F50, 1, TEXT + b"?" * 5)
    script = [
        ("21 50 1f 01 0f 00 00 00", "60 50 1f 01 00 00 00 00"),
        ("00 46 69 65 6c 64 20 72", "20 00 00 00 00 00 00 00"),
        ("10 69 67 21 3f 3f 3f 3f", "30 00 00 00 00 00 00 00"),
        ("0d 3f 00 00 00 00 00 00", "20 00 00 00 00 00 00 00"),
    ]
    assert bench.play(script) == [None]


def test_a_multiple_of_seven_ends_with_a_full_segment(bench: Bench) -> None:
    bench.download(0x1F50, 1, bytes(7))
    script = [
        ("21 50 1f 01 07 00 00 00", "60 50 1f 01 00 00 00 00"),
        ("01 00 00 00 00 00 00 00", "20 00 00 00 00 00 00 00"),
    ]
    assert bench.play(script) == [None]


def test_nothing_is_written_as_an_empty_segment(bench: Bench) -> None:
    bench.download(0x1F50, 1, b"")
    script = [
        ("21 50 1f 01 00 00 00 00", "60 50 1f 01 00 00 00 00"),
        ("0f 00 00 00 00 00 00 00", "20 00 00 00 00 00 00 00"),
    ]
    assert bench.play(script) == [None]


@pytest.mark.parametrize("first", ["41 08 10 00 0a 00 00 00", "40 08 10 00 00 00 00 00"], ids=["size", "no size"])
def test_more_is_read_in_segments(bench: Bench, first: str) -> None:
    bench.upload(0x1008, 0)
    script = [
        ("40 08 10 00 00 00 00 00", first),
        ("60 00 00 00 00 00 00 00", "00 46 69 65 6c 64 20 72"),
        ("70 00 00 00 00 00 00 00", "19 69 67 21 00 00 00 00"),
    ]
    assert bench.play(script) == [TEXT]


@pytest.mark.parametrize(
    ("begin", "script"),
    [
        (lambda bench: bench.upload(0x1009, 0), [("40 09 10 00 00 00 00 00", "80 09 10 00 00 00 02 06")]),
        (lambda bench: bench.download(0x1009, 0, b"1"), [("2f 09 10 00 31 00 00 00", "80 09 10 00 00 00 02 06")]),
        (
            lambda bench: bench.upload(0x1009, 0),
            [("40 09 10 00 00 00 00 00", "41 09 10 00 0a 00 00 00"), ("60" + " 00" * 7, "80 09 10 00 00 00 02 06")],
        ),
    ],
    ids=["upload", "download", "between segments"],
)
def test_servers_abort_is_handed_on(bench: Bench, begin: Callable[[Bench], None], script: Script) -> None:
    begin(bench)
    assert bench.play(script) == ["06020000"]


def test_abort_code_that_no_standard_has_is_handed_on_too(bench: Bench) -> None:
    bench.upload(0x1009, 0)
    assert bench.play([("40 09 10 00 00 00 00 00", "80 09 10 00 ff ee dd cc")]) == ["ccddeeff"]
    assert str(Abort(0xCCDDEEFF)) == "CCDDEEFFh an unknown code"


UPLOADING = [("40 08 10 00 00 00 00 00", "41 08 10 00 0a 00 00 00"), ("60" + " 00" * 7, "")]
DOWNLOADING = [("21 08 10 00 0a 00 00 00", "60 08 10 00 00 00 00 00"), ("00 46 69 65 6c 64 20 72", "")]


@pytest.mark.parametrize(
    ("script", "answer", "code"),
    [
        (UPLOADING, "10 46 69 65 6c 64 20 72", Code.TOGGLE_BIT_NOT_ALTERNATED),
        (DOWNLOADING, "30 00 00 00 00 00 00 00", Code.TOGGLE_BIT_NOT_ALTERNATED),
        (UPLOADING, "20 00 00 00 00 00 00 00", Code.UNKNOWN_COMMAND_SPECIFIER),
        (DOWNLOADING, "00 00 00 00 00 00 00 00", Code.UNKNOWN_COMMAND_SPECIFIER),
        (UPLOADING, "e0 00 00 00 00 00 00 00", Code.UNKNOWN_COMMAND_SPECIFIER),
        (UPLOADING, "01 46 69 65 6c 64 20 72", Code.LENGTH_TOO_LOW),
    ],
)
def test_wrong_answer_is_aborted(bench: Bench, script: Script, answer: str, code: Code) -> None:
    if script is UPLOADING:
        bench.upload(0x1008, 0)
    else:
        bench.download(0x1008, 0, TEXT)
    bench.play(script)
    bench.answer(answer)
    assert bench.take() == ["601#80 08 10 00 " + int(code).to_bytes(4, "little").hex(" ")]
    assert bench.results == [f"{code:08x}"]
    bench.answer(answer)
    assert bench.after(1000) == []
    assert len(bench.results) == 1


@pytest.mark.parametrize("answer", ["20 08 10 00 00 00 00 00", "c6 08 10 00 0a 00 00 00"])
def test_wrong_first_answer_is_aborted(bench: Bench, answer: str) -> None:
    bench.upload(0x1008, 0)
    bench.take()
    bench.answer(answer)
    assert bench.take() == ["601#80 08 10 00 01 00 04 05"]
    assert bench.results == ["05040001"]


def test_server_that_sends_more_than_it_said_is_stopped(bench: Bench) -> None:
    bench.upload(0x1008, 0)
    bench.play([UPLOADING[0], ("60" + " 00" * 7, "00" + " 41" * 7), ("70" + " 00" * 7, "")])
    bench.answer("11" + " 41" * 7)
    assert bench.take() == ["601#80 08 10 00 12 00 07 06"]


@pytest.mark.long
def test_server_that_never_ends_is_stopped(bench: Bench) -> None:
    bench.upload(0x1008, 0)
    bench.answer("40 08 10 00 00 00 00 00")
    for number in range((1 << 20) // 7 + 1):
        bench.answer(f"{number % 2 * 16:02x}" + " 41" * 7)
    assert bench.take()[-1] == "601#80 08 10 00 05 00 04 05"


def test_silence_is_aborted_when_the_time_is_over(bench: Bench) -> None:
    bench.upload(0x1008, 0)
    assert bench.after(99) == ["601#40 08 10 00 00 00 00 00"]
    assert bench.after(1) == ["601#80 08 10 00 00 00 04 05"]
    assert bench.results == ["05040000"]


def test_each_answer_gives_the_server_new_time(bench: Bench) -> None:
    bench.upload(0x1008, 0)
    bench.after(99)
    bench.answer("41 08 10 00 0a 00 00 00")
    assert bench.after(99) == ["601#60 00 00 00 00 00 00 00"]
    assert bench.after(1) == ["601#80 08 10 00 00 00 04 05"]


def test_answer_that_comes_too_late_is_not_taken_for_the_next_one(bench: Bench) -> None:
    bench.upload(0x1008, 0)
    bench.after(100)
    bench.upload(0x6000, 1)
    bench.answer("43 08 10 00 01 02 03 04", "80 08 10 00 00 00 02 06")
    bench.answer("4f 00 60 01 5a 00 00 00")
    assert bench.results == ["05040000", b"\x5a"]


def test_requests_wait_for_each_other(bench: Bench) -> None:
    bench.upload(0x6000, 1)
    bench.download(0x1017, 0, b"\x64\x00")
    bench.upload(0x6000, 2)
    assert bench.client.is_busy
    script = [
        ("40 00 60 01 00 00 00 00", "4f 00 60 01 5a 00 00 00"),
        ("2b 17 10 00 64 00 00 00", "80 17 10 00 02 00 01 06"),
        ("40 00 60 02 00 00 00 00", "4f 00 60 02 a5 00 00 00"),
    ]
    assert bench.play(script) == [b"\x5a", "06010002", b"\xa5"]
    assert not bench.client.is_busy


def test_what_is_asked_for_by_an_answer_comes_after_what_was_asked_before(bench: Bench) -> None:
    bench.client.upload(0x6000, 1, lambda result: bench.upload(0x6000, 3))
    bench.upload(0x6000, 2)
    bench.take()
    bench.answer("4f 00 60 01 5a 00 00 00")
    assert bench.take() == ["601#40 00 60 02 00 00 00 00"]
    bench.answer("4f 00 60 02 5a 00 00 00")
    assert bench.take() == ["601#40 00 60 03 00 00 00 00"]


def test_cancelled_requests_are_forgotten(bench: Bench) -> None:
    bench.upload(0x6000, 1)
    bench.upload(0x6000, 2)
    bench.take()
    bench.client.cancel()
    bench.answer("4f 00 60 01 5a 00 00 00")
    assert bench.after(1000) == []
    assert bench.results == []


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(st.booleans(), st.integers(0, 3), st.lists(st.binary(max_size=8), max_size=6))
def test_whatever_comes_back_there_is_one_result(is_upload: bool, good: int, answers: list[bytes]) -> None:
    bench = Bench()
    if is_upload:
        bench.upload(0x1008, 0)
    else:
        bench.download(0x1008, 0, TEXT)
    sound = ("41 08 10 00 0a", "00" + " 41" * 7) if is_upload else ("60 08 10 00", "20")
    for answer in (*(bytes.fromhex(text).ljust(8, b"\0") for text in sound[:good]), *answers):
        bench.can.deliver(CanFrame(0x581, answer))
    bench.after(100)
    assert len(bench.results) == 1
    assert not bench.client.is_busy


# Real servers


class OurServer:
    """Our server: the I/O module as node 5."""

    def __init__(self) -> None:
        self.bench, self.client = CanopenBench(), Bench(5)

    def run(self) -> list[Any]:
        while requests := self.client.can.take():
            for request in requests:
                self.bench.can.deliver(request)
            for answer in self.bench.can.take():
                if answer.identifier == 0x585:
                    self.client.can.deliver(answer)
        return self.client.results


class CanopenServer(canopen.Network):
    """The server of python-canopen, with the same EDS."""

    def __init__(self) -> None:
        super().__init__()
        self.client = Bench(5)
        self.add_node(canopen.LocalNode(5, str(IO32)))

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        if can_id == 0x585:
            self.client.can.deliver(CanFrame(can_id, bytes(data)))

    def run(self) -> list[Any]:
        while requests := self.client.can.take():
            for request in requests:
                self.notify(request.identifier, bytearray(request.data), 0.0)
        return self.client.results


SERVERS = pytest.mark.parametrize("make", [OurServer, CanopenServer])


@SERVERS
def test_objects_of_a_server_are_read_and_written(make: type[OurServer] | type[CanopenServer]) -> None:
    server = make()
    client = server.client
    client.upload(0x1000, 0)
    client.upload(0x2000, 0)
    client.download(0x2000, 0, b"beside the press")
    client.upload(0x2000, 0)
    client.download(0x6200, 1, b"\xa5")
    client.upload(0x6200, 1)
    client.upload(0x5FFF, 0)
    client.download(0x1000, 0, bytes(4))
    assert server.run() == [
        bytes.fromhex("91 01 0f 00"),
        b"control cabinet 1",
        None,
        b"beside the press",
        None,
        b"\xa5",
        "06020000",
        "06010002",
    ]
