"""The values that a failed test of a PAM application or a card has read, with those before them."""

from pathlib import Path

import pytest

from fieldrig import MS, RigError, S, UnmetError, program

PROGRAMS = Path("configs/programs")


def test_values_that_were_read_are_shown_with_those_before() -> None:
    plc = program(PROGRAMS / "labeller.pam")
    plc.start()
    assert plc["IWV_Products"] == 0
    plc["IWV_Products"] = 2
    plc.advance(1 * S)
    assert plc["IWV_Products"] == 2
    assert "IWV_Products = 2 at 1000 ms; before 0 at 0 ms" in plc.told()


def test_a_condition_that_does_not_come_shows_what_it_has_read() -> None:
    plc = program(PROGRAMS / "labeller.pam")
    with pytest.raises(UnmetError, match="IWV_Products = 0 at 0 ms"):
        plc.until(lambda: plc["IWV_Products"] > 3, within=20 * MS)


def test_values_before_a_reset_are_gone() -> None:
    plc = program(PROGRAMS / "labeller.pam")
    plc["IWV_Products"] = 2
    plc.advance(1 * S)
    assert plc["IWV_Products"] == 2
    plc.reset()
    assert plc["IWV_Products"] == 0
    assert "before" not in plc.told()


def test_a_card_that_waits_for_other_nodes_says_so() -> None:
    with pytest.raises(RigError, match="the card is starting\n  a program that waits for other nodes"):
        program(PROGRAMS / "line.I01").start()
