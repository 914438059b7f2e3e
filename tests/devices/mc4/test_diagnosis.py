"""DiagCode and DiagMsg of an axis; classes and reactions."""

import pytest

from fieldrig_devices.mc4.diagnosis import MANUFACTURER_BITS, MESSAGES, REACTIONS, Code, Diagnosis
from fieldrig_devices.mc4.enable import Reaction


@pytest.fixture
def reactions() -> list[Reaction]:
    return []


@pytest.fixture
def diagnosis(reactions: list[Reaction]) -> Diagnosis:
    return Diagnosis(reactions.append, language="de")  # as the manual prints its texts


# digest 1.5 and 3.2, row by row: code, class, text, reaction
MANUAL = [
    (1117, 1, "Lesefehler Geber-EEPROM", Reaction.A),
    (2106, 2, "Kommunikationsfehler ZK-Controller", Reaction.B),
    (3117, 3, "Motortemperatur zu hoch", Reaction.B),
    (7134, 7, "Externe 24V-Versorgung zu niedrig", Reaction.NONE),
]


@pytest.mark.manual("PD-097", "PD-098")
@pytest.mark.parametrize(("code", "number", "text", "reaction"), MANUAL)
def test_codes_of_the_manual(code: int, number: int, text: str, reaction: Reaction, diagnosis: Diagnosis) -> None:
    assert (diagnosis.class_of(Code(code)), diagnosis.text_of(Code(code))) == (number, text)
    assert diagnosis.reaction_to(Code(code)) is reaction


def test_both_limits_are_told_in_the_manuals_words(diagnosis: Diagnosis) -> None:
    diagnosis.language = "en"
    assert diagnosis.text_of(Code.STOP_TIME_LIMIT) == "Stop time limit exceeded"
    assert diagnosis.text_of(Code.OVERLOAD_STOP_TIME) == "ramping-down time exceeded"
    assert diagnosis.text_of(Code.MOTOR_TEMPERATURE) == "motor temperature too high"  # manual 4184
    assert {diagnosis.reaction_to(code) for code in (Code.STOP_TIME_LIMIT, Code.OVERLOAD_STOP_TIME)} == {Reaction.B}


@pytest.mark.manual("PD-092", "PD-093")
def test_only_a_higher_class_overwrites(diagnosis: Diagnosis) -> None:
    seen = []
    for code in (Code.SUPPLY_24V, Code.MOTOR_TEMPERATURE, Code.AMPLIFIER_TEMPERATURE, Code.ENCODER_MEMORY, Code.RING):
        diagnosis.raise_(code)
        seen.append(diagnosis.code)
    assert seen == [7134, 3117, 3117, 1117, 1117]
    assert diagnosis.text == "Lesefehler Geber-EEPROM"


@pytest.mark.manual("PD-092")
def test_only_quitting_takes_it_away(diagnosis: Diagnosis) -> None:
    diagnosis.raise_(Code.MOTOR_TEMPERATURE, stays=True)
    diagnosis.end(Code.MOTOR_TEMPERATURE)
    assert diagnosis.code == 3117
    assert diagnosis.quit()
    assert (diagnosis.code, diagnosis.text) == (0, "")


def test_a_cause_that_is_still_there_outlives_quitting(diagnosis: Diagnosis) -> None:
    diagnosis.raise_(Code.ENCODER_MEMORY, stays=True)
    diagnosis.raise_(Code.RING)
    assert not diagnosis.quit()
    assert diagnosis.pending == (Code.ENCODER_MEMORY,)


def test_a_cause_that_stays_is_not_forgotten_when_the_same_happens_again(diagnosis: Diagnosis) -> None:
    diagnosis.raise_(Code.ENCODER_SIGNAL, stays=True)
    diagnosis.raise_(Code.ENCODER_SIGNAL)
    assert not diagnosis.quit()
    diagnosis.end(Code.ENCODER_SIGNAL)
    assert diagnosis.quit()


def test_reacts_once(diagnosis: Diagnosis, reactions: list[Reaction]) -> None:
    for _ in range(3):
        diagnosis.raise_(Code.DC_BUS_CONTROLLER, stays=True)
    assert reactions == [Reaction.B]


@pytest.mark.manual("PD-097")
def test_class_is_configurable(reactions: list[Reaction]) -> None:
    diagnosis = Diagnosis(reactions.append, {3117: 1, 2106: 6})
    diagnosis.raise_(Code.DC_BUS_CONTROLLER)
    diagnosis.raise_(Code.MOTOR_TEMPERATURE)
    assert reactions == [Reaction.NONE, Reaction.A]
    assert diagnosis.code == 3117


def test_class_1_diagnostics_have_the_bits_of_the_standard(diagnosis: Diagnosis) -> None:
    for code in (Code.OVERLOAD, Code.AMPLIFIER_TEMPERATURE, Code.MOTOR_TEMPERATURE, Code.ENCODER_MEMORY):
        diagnosis.raise_(code)
    assert diagnosis.class_1 == 0b0010_0111
    diagnosis.raise_(Code.FOLLOWING_ERROR)
    diagnosis.raise_(Code.RING)
    diagnosis.raise_(Code.STOP_TIME_LIMIT)
    assert diagnosis.class_1 == 0b1001_1000_0010_0111
    assert diagnosis.manufacturer_class_1 == MANUFACTURER_BITS[Code.STOP_TIME_LIMIT]


@pytest.mark.manual("PD-097")
def test_class_1_diagnostics_follow_the_class_that_was_given(reactions: list[Reaction]) -> None:
    """They are errors that shut the drive down: neither a notice, nor an error without its bit."""
    diagnosis = Diagnosis(reactions.append, {7134: 2, 3117: 6, 2106: 7})
    diagnosis.raise_(Code.MOTOR_TEMPERATURE)
    diagnosis.raise_(Code.DC_BUS_CONTROLLER)
    assert (diagnosis.has_error, diagnosis.class_1, diagnosis.manufacturer_class_1) == (False, 0, 0)
    diagnosis.raise_(Code.SUPPLY_24V)
    assert (diagnosis.has_error, diagnosis.class_1) == (True, 1 << 4), "control voltage error"


def test_table_is_whole() -> None:
    assert set(MESSAGES) == set(Code)
    assert all(message.de and message.en for message in MESSAGES.values())
    assert REACTIONS == {1: Reaction.A, 2: Reaction.B, 3: Reaction.B}
    assert len(set(MANUFACTURER_BITS.values())) == len(MANUFACTURER_BITS)
