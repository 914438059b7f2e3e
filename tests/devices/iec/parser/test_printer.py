"""A tree that is printed and parsed again is the same tree, and printing it again gives the same text."""

import re

from hypothesis import given
from iec_trees import UNITS

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import EDITION_3
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.printer import print_unit


@given(UNITS)
def test_a_printed_tree_is_parsed_to_the_same_tree(unit: tree.Unit) -> None:
    text = print_unit(unit)
    again, mistakes = parse(text, unit.file, EDITION_3)
    assert mistakes == []
    assert again == unit


@given(UNITS)
def test_printing_is_idempotent_and_keeps_every_comment(unit: tree.Unit) -> None:
    once = print_unit(unit)
    again, _ = parse(once, unit.file, EDITION_3)
    assert print_unit(again) == once
    assert sorted(re.findall(r"\(\*.*?\*\)", print_unit(again), re.DOTALL)) == sorted(
        re.findall(r"\(\*.*?\*\)", once, re.DOTALL)
    )
