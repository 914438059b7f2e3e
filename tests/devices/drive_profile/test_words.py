"""States, commands, modes and errors of drives in words, after the tables of CiA 402-2 (IEC 61800-7-201)."""

import pytest

from fieldrig_devices.canopen.emcy_words import emcy_words
from fieldrig_devices.drive_profile.words import command_words, meaning_of, state_words


@pytest.mark.parametrize(
    ("low_byte", "words"),
    [
        (0b0000_0000, "not ready to switch on"),
        (0b0010_0000, "not ready to switch on"),
        (0b0100_0000, "switch on disabled"),
        (0b0110_0000, "switch on disabled"),
        (0b0010_0001, "ready to switch on"),
        (0b0010_0011, "switched on"),
        (0b0010_0111, "operation enabled"),
        (0b0000_0111, "quick stop active"),
        (0b0000_1111, "fault reaction active"),
        (0b0010_1111, "fault reaction active"),
        (0b0000_1000, "fault"),
        (0b0010_1000, "fault"),
        (0b0000_0001, ""),
        (0b0110_0111, ""),
    ],
)
@pytest.mark.parametrize("others", [0, 0xFF90])
def test_a_status_word_has_its_state(low_byte: int, words: str, others: int) -> None:
    """The table masks with 4Fh or 6Fh: the other bits do not count."""
    assert state_words(low_byte | others) == words


@pytest.mark.parametrize(
    ("control_word", "words"),
    [
        (0x06, "shutdown"),
        (0x07, "switch on"),
        (0x0F, "enable operation"),
        (0x1F, "enable operation"),
        (0x10F, "enable operation, halt"),
        (0x00, "disable voltage"),
        (0x0D, "disable voltage"),
        (0x02, "quick stop"),
        (0x80, "fault reset"),
        (0x8F, "fault reset"),
    ],
)
def test_a_control_word_has_its_command(control_word: int, words: str) -> None:
    assert command_words(control_word) == words


@pytest.mark.parametrize(
    ("index", "name", "number", "words"),
    [
        (0x6041, "Statusword", 0x0237, "operation enabled"),
        (0x6841, "Status word 2", 0x0237, "operation enabled"),
        (0x6061, "Modes of operation display", 8, "cyclic synchronous position"),
        (0x6060, "Modes of operation", -3, ""),
        (0x603F, "Error code", 0x8611, "following error"),
        (0x603F, "Error code", 0, ""),
    ],
)
def test_objects_have_their_meaning(index: int, name: str, number: int, words: str) -> None:
    meaning = meaning_of(index, name)
    assert meaning is not None
    assert meaning(number) == words


@pytest.mark.parametrize(("index", "name"), [(0x6041, "Analogue input 5"), (0x2041, "Status"), (0x6064, "Position")])
def test_objects_of_other_profiles_and_makers_have_none(index: int, name: str) -> None:
    assert meaning_of(index, name) is None


@pytest.mark.parametrize(
    ("code", "of_drive", "of_others"),
    [
        (0x7320, "position", "additional modules"),
        (0x2310, "continuous over-current of the motor", "current, output side"),
        (0x5112, "device hardware", "device hardware"),
        (0x8130, "life guard or heartbeat error", "life guard or heartbeat error"),
        (0x8611, "following error", "monitoring"),
        (0xA123, "", ""),
    ],
)
def test_an_emcy_of_a_drive_has_the_words_of_its_profile(code: int, of_drive: str, of_others: str) -> None:
    """A code that no table has is named by its class: 73xxh by 70xxh."""
    data = code.to_bytes(2, "little") + bytes(6)
    assert emcy_words(data, is_drive=True) == f"{code:04X}h {of_drive}".rstrip() + ", register 00h"
    assert emcy_words(data) == f"{code:04X}h {of_others}".rstrip() + ", register 00h"
