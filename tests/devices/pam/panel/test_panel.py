"""The panel of a PAM: codes, display, and what the debugger prints."""

from datetime import datetime

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import MS, S
from fieldrig_devices.pam.panel.catalogue import text_of
from fieldrig_devices.pam.panel.codes import MOST_NUMBER, Code, Kind, code_of
from fieldrig_devices.pam.panel.display import DIGITS, Display, floating
from fieldrig_devices.pam.panel.messages import Message, Messages
from fieldrig_devices.pam.panel.pam_display import PamDisplay

DATE = datetime(1995, 10, 15, 14, 30, 45)  # noqa: DTZ001 - the PAM's clock knows no time zone


@pytest.mark.manual("PAMS-045", "PAMS-046")
@pytest.mark.parametrize(
    ("function", "number", "shown"),
    [
        ("message", 12, "0080M00C"),  # T16
        ("warning", 23, "0080W017"),  # T17
        ("end_warning", 23, "0080K017"),
        ("error", 6, "0080E006"),  # T18
        ("end_error", 7, "0080S007"),
    ],
)
def test_application_messages_have_the_codes_of_the_manual(function: str, number: int, shown: str) -> None:
    codes: list[str] = []
    item = PamDisplay(lambda code, text, details: codes.append(str(code)), lambda value: None)
    item.do(function, (number, "Reached trace point No:", 33))
    assert codes == [shown]


@pytest.mark.manual("PAMS-046")
def test_text_of_an_application_message_is_cut_after_40_characters() -> None:
    texts: list[str] = []
    item = PamDisplay(lambda code, text, details: texts.append(text), lambda value: None)
    item.do("message", (1, "x" * 50))
    assert texts == ["x" * 40]


@pytest.mark.manual("PAMS-060")
@pytest.mark.parametrize(
    ("text", "shown"),
    [("06..F003", "0680F003"), ("02..FFF3", "0200FFF3"), ("02..F060", "0280F060"), ("01..E022", "0100E022")],
)
def test_dots_stand_for_the_digits_of_real_time(text: str, shown: str) -> None:
    assert str(code_of(text)) == shown


@given(st.integers(0, 0xFF), st.sampled_from(Kind), st.integers(0, MOST_NUMBER), st.booleans())
def test_a_code_is_read_as_it_is_written(origin: int, kind: Kind, number: int, is_real_time: bool) -> None:
    code = Code(origin, kind, number, is_real_time)
    assert code_of(str(code)) == code


@given(st.text(alphabet="0123456789ABCDEFGHIMWKS.x", max_size=9).filter(lambda text: len(text) != 8))
def test_other_texts_are_no_codes(text: str) -> None:
    with pytest.raises(ValueError, match="message code"):
        code_of(text)


@pytest.mark.manual("PAMS-107", "PAMS-103")
def test_the_same_number_has_another_text_as_a_message() -> None:
    assert text_of(code_of("0780M01E")) == "working without PLC"
    assert text_of(code_of("0780E01E")) == "DualPort watchdog"
    assert "corrupted" in text_of(code_of("0100E022"))
    assert text_of(code_of("0080E01E")) == ""  # the application's own


@pytest.mark.manual("PAMS-047")
def test_debugger_prints_an_error_and_its_end_as_in_the_manual() -> None:
    sent: list[bytes] = []
    messages = Messages(sent.append)
    for text in ("0780E039", "0780S039"):
        messages.add(Message(code_of(text), "RS422 : comm. disconnected", (), DATE))
    assert b"".join(sent).decode().splitlines() == [
        "15.10.95 14:30:45 [0780E039] real time Error",
        "automate RS422 : comm. disconnected",
        "15.10.95 14:30:45 [0780S039] real time Error Canceled",
        "automate RS422 : comm. disconnected",
    ]


@pytest.mark.manual("PAMS-045")
def test_error_list_has_errors_and_ends_but_no_warnings() -> None:
    messages = Messages(lambda text: None)
    for text in ("0080M001", "0080W002", "0080K002", "0080E003", "0080S003", "0680F010"):
        messages.add(Message(code_of(text), "", (), DATE))
    assert [str(entry.code) for entry in messages.listed] == ["0080K002", "0080E003", "0080S003", "0680F010"]


@pytest.mark.manual("PAMS-056")
def test_first_fatal_error_counts() -> None:
    messages = Messages(lambda text: None)
    for text in ("0680F010", "0380F02D"):
        messages.add(Message(code_of(text), "", (), DATE))
    assert messages.fatal is not None
    assert str(messages.fatal.code) == "0680F010"


@pytest.fixture
def display() -> Display:
    found = Display()
    found.restart("PACKER V1.02", 0)
    return found


@pytest.mark.manual("PAML-011")
def test_name_and_version_scroll(display: Display) -> None:
    seen = {display.text(instant * 100 * MS) for instant in range(100)}
    assert "PACKER V" in seen
    assert "ER V1.02" in seen
    assert not display.blinks()


@pytest.mark.manual("PAMS-047")
def test_ended_warning_is_shown_for_two_more_seconds(display: Display) -> None:
    display.show(code_of("0080W017"), S)
    assert display.text(100 * S) == "0080W017"
    assert display.show(code_of("0080K017"), 100 * S)
    assert display.text(102 * S - 1) == "0080W017"
    assert display.text(102 * S) != "0080W017"


@pytest.mark.manual("PAMS-047")
def test_error_blinks_until_its_end(display: Display) -> None:
    display.show(code_of("0780E039"), S)
    assert display.blinks()
    assert display.text(2 * S) == "0780E039"
    assert display.show(code_of("0780S039"), 3 * S)
    assert not display.blinks()
    assert display.text(3 * S) != "0780E039"


@pytest.mark.manual("PAMS-046")
def test_end_with_another_number_ends_nothing(display: Display) -> None:
    display.show(code_of("0080E006"), S)
    assert not display.show(code_of("0080S007"), 2 * S)  # T18
    assert display.text(2 * S) == "0080E006"


def test_fatal_error_covers_everything(display: Display) -> None:
    display.show(code_of("0680F010"), S)
    display.show(code_of("0780E01E"), S)
    display.show(code_of("0080M001"), S)
    assert display.text(S) == "0680F010"


def test_earlier_error_is_shown_again_when_the_later_one_has_ended(display: Display) -> None:
    for text in ("0080E001", "0080E002", "0080S002"):
        display.show(code_of(text), S)
    assert display.text(S) == "0080E001"


def test_of_several_errors_the_latest_is_shown_and_then_the_earlier_ones(display: Display) -> None:
    for text in ("0080W003", "0080E001", "0080E002"):
        display.show(code_of(text), 0)
    seen = [display.text(0)]
    for text in ("0080S002", "0080S001", "0080K003"):
        display.show(code_of(text), 10 * S)
        seen.append(display.text(13 * S))
    assert seen[:3] == ["0080E002", "0080E001", "0080W003"]
    assert "0080" not in seen[3]


IN_TABLE_12_7 = [f"0680F{number}" for number in ("002", "003", "004", "005", "007", "008", "009", "016", "006", "022")]
OTHERS = ["0780F025", "0680F010", "0680F00C", "0200FFF2", "0380E02C", "0780F020"]


@pytest.mark.manual("PAMS-060")
@pytest.mark.parametrize("cause", IN_TABLE_12_7)
@pytest.mark.parametrize("other", OTHERS)
def test_of_several_fatal_errors_that_of_the_ring_is_shown(display: Display, cause: str, other: str) -> None:
    for order in ((cause, other), (other, cause), (cause, other, "0680F006", "0080E001")):
        display.restart("PACKER", 0)
        for text in order:
            display.show(code_of(text), 0)
        assert display.text(S) == cause
        assert display.blinks()


@pytest.mark.manual("PAMS-056")
@pytest.mark.parametrize("first", IN_TABLE_12_7[:4])
@pytest.mark.parametrize("second", IN_TABLE_12_7[:4])
def test_of_several_fatal_errors_of_one_sort_the_first_is_shown(display: Display, first: str, second: str) -> None:
    for text in (first, second):
        display.show(code_of(text), 0)
    assert display.text(0) == first


def test_a_fatal_error_stays_whatever_follows() -> None:
    display = Display()
    for text in ("0380E02C", "0080E002", "0080S002", "0200FFF3"):
        display.show(code_of(text), 0)
    assert display.text(S) == "0380E02C"


@pytest.mark.parametrize("condition", ["0080W017", "0080E017"])
def test_an_older_message_does_not_hide_a_warning(display: Display, condition: str) -> None:
    display.show(code_of("0780M017"), 0)
    assert display.text(S) == "0780M017"
    display.show(code_of(condition), S)
    assert display.text(S) == condition


def test_a_warning_that_has_ended_does_not_hide_the_next_one(display: Display) -> None:
    for text in ("0080W001", "0080K001", "0080W002"):
        display.show(code_of(text), S)
    assert display.text(S) == "0080W002"


def test_a_message_is_shown_for_two_seconds_over_an_older_warning(display: Display) -> None:
    display.show(code_of("0080W017"), 0)
    display.show(code_of("0080M001"), S)
    assert [display.text(instant) for instant in (S, 3 * S - 1, 3 * S)] == ["0080M001", "0080M001", "0080W017"]


def test_the_name_moves_by_a_digit_in_300_ms(display: Display) -> None:
    assert [display.text(instant * MS) for instant in (0, 299, 300, 600)] == [
        "        ", "        ", "       P", "      PA",
    ]  # fmt: skip


def test_the_error_list_has_the_latest_100_entries() -> None:
    messages = Messages(lambda text: None)
    for number in range(105):
        messages.add(Message(Code(0, Kind.ERROR, number), "", (), DATE))
    assert [entry.code.number for entry in messages.listed] == list(range(5, 105))


@pytest.mark.manual("PAMS-048")
def test_monitored_value_is_refreshed_periodically(display: Display) -> None:
    display.monitor(1.5, 0)
    display.monitor(2.5, 100 * MS)
    assert display.text(200 * MS).strip() == "1.5"
    assert display.text(500 * MS).strip() == "2.5"
    display.monitor(3453.56, 600 * MS)
    assert display.text(700 * MS).strip() == "2.5"
    assert display.text(1000 * MS).strip() == "3453.56"
    assert display.text(200 * S).strip() == "3453.56"


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_monitored_value_fits_the_display(value: float) -> None:
    assert len(floating(value)) == DIGITS or len(floating(value)) == len(f"{value:.0e}")
    assert float(floating(value)) == pytest.approx(value, rel=0.5, abs=1e-323) or abs(value) > 1e308
