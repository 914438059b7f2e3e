"""Names of the messages of a telephone network: a whole call, from the first tone to its end."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.config.rig_file import from_dict
from fieldrig.faults.note import FaultNote
from fieldrig.traces.names import Named, Namer, namer_of
from fieldrig_bus.telephone.bus import TelephoneSettings
from fieldrig_bus.telephone.codec import decode
from fieldrig_bus.telephone.message import Carrier, Dial, Heard, Hook, Offer, Ready, Ring, Tone
from fieldrig_bus.telephone.modulation import Modulation
from fieldrig_devices.line_names.telephone import MOST_CALLERS, TelephoneNames

RIG = {
    "time": "virtual",
    "buses": {
        "office_com": {"kind": "serial.virtual"},
        "machine_com": {"kind": "serial.virtual"},
        "telephone": {
            "kind": "telephone.virtual", "numbers": {"office": "100", "machine": "200"}, "outside_prefix": "0",
        },
    },
    "devices": {
        name: {"kind": "modem", "links": {"line": f"{name}_com", "telephone": "telephone"}}
        for name in ("office", "machine")
    },
}  # fmt: skip


@pytest.fixture
def name() -> Namer:
    return namer_of(from_dict(RIG), "telephone")


def called(name: Namer) -> Namer:
    name(Hook(True), "office")
    name(Dial("200"), "office")
    return name


def test_a_call_says_who_calls_whom(name: Namer) -> None:
    assert name(Hook(True), "office") == Named("seize", "", "off hook")
    assert name(Heard(Tone.DIAL), "exchange") == Named("tone", "", "dial")
    assert name(Dial("0"), "office") == Named("dial", "", "0")
    assert name(Dial("20"), "office") == Named("dial", "", "20")
    assert name(Dial("0"), "office") == Named("call", "machine", "0: office calls machine")
    assert name(Ring(True, "100"), "exchange") == Named("ring", "machine", "on, called by office (100)")
    assert name(Hook(True), "machine") == Named("answer", "office", "off hook")


def test_modems_agree_and_their_data_have_a_direction(name: Namer) -> None:
    called(name)
    offer = Offer((Modulation("V34", 300, 33_600),))
    assert name(offer, "office") == Named("handshake", "machine", "offers V34 300-33600")
    assert name(Carrier(33_600, is_corrected=True), "machine") == Named(
        "connect", "office", "carrier 33600 bit/s, error correction"
    )
    assert name(b"login: ", "machine") == Named("data: text", "office", "machine to office: login: ")
    assert name(b"lab\r", "office") == Named("data: text", "machine", "office to machine: lab<CR>")
    assert name(Ready(False), "office") == Named("flow control", "machine", "not ready")
    assert name(Carrier(0), "machine") == Named("carrier lost", "office", "no carrier")


def test_the_end_of_a_call_is_named_for_both_ends(name: Namer) -> None:
    called(name)
    assert name(Hook(False), "office") == Named("hang up", "machine", "on hook")
    assert name(Heard(Tone.BUSY), "exchange") == Named("tone", "", "busy")
    assert name(Hook(False), "machine") == Named("hang up", "office", "on hook")
    assert name(Hook(True), "office") == Named("seize", "", "off hook")


def test_a_call_from_outside_has_no_name(name: Namer) -> None:
    assert name(Ring(True), "exchange").text == "on, called by outside"
    assert name(FaultNote(1, "busy"), "office") == Named("fault", "office", "fault 1: busy")


def test_a_trace_that_begins_within_a_call_has_no_other_end(name: Namer) -> None:
    assert name(b"AT\r", "office") == Named("data: AT command", "", "office: AT")


def test_callers_that_come_and_go_take_no_more_memory(name: Namer) -> None:
    assert isinstance(name, TelephoneNames)
    for number in range(10 * MOST_CALLERS):
        name(Hook(True), f"outside {number}")
        name(Dial("200"), f"outside {number}")
        name(b"x" * 100, f"outside {number}")
    for table in (name._others, name._dialled, name._texts):
        assert len(table) <= MOST_CALLERS


@given(st.lists(st.tuples(st.sampled_from(["office", "machine", ""]), st.binary(max_size=30)), max_size=6))
def test_any_message_has_some_name(sent: list[tuple[str, bytes]]) -> None:
    names = TelephoneNames(TelephoneSettings(numbers={"office": "100", "machine": "200"}))
    for sender, data in sent:
        try:
            message = decode(data)
        except ValueError:
            continue
        assert isinstance(names(message, sender), Named)
