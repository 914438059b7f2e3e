"""Marks of coverage divide no block: a program with marks gives way where it gives way without them."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import accumulate

from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.languages.blocks import LONGEST, blocks
from fieldrig_devices.languages.instructions import Branch, Call, Do, End, Instruction, Jump, Pause

MARK = Do(0, ("hit[0] = 1",), 0)
LONG = 3 * LONGEST


def instructions_of(choices: Sequence[tuple[str, int]]) -> list[Instruction]:
    """Return instructions whose jumps lead to others of them."""
    made: list[Instruction] = []
    for pc, (kind, distance) in enumerate(choices):
        target = (pc + distance) % (len(choices) + 1)
        match kind:
            case "branch":
                made.append(Branch(1, (), "x", target))
            case "jump":
                made.append(Jump(1, target))
            case "call":
                made.append(Call(1, "other"))
            case "pause":
                made.append(Pause(1, (), "x"))
            case _:
                made.append(Do(1, ("x = 1",)))
    return [*made, End(1)]


KINDS = st.sampled_from(["do"] * 30 + ["branch", "branch", "jump", "call", "pause"])
CHOICES = st.lists(st.tuples(KINDS, st.integers(1, LONGEST + 8)), min_size=LONGEST + 4, max_size=LONG)


@settings(max_examples=60, deadline=None)
@given(CHOICES, st.lists(st.booleans(), min_size=LONG + 1, max_size=LONG + 1))
def test_blocks_begin_at_the_same_instructions(choices: list[tuple[str, int]], marked: list[bool]) -> None:
    plain = instructions_of(choices)
    places = list(accumulate((1 + has_mark for has_mark in marked), initial=0))
    """The number of each instruction, or of the mark in front of it, among those with marks."""
    with_marks: list[Instruction] = []
    for one, has_mark in zip(plain, marked, strict=False):
        moved = replace(one, target=places[one.target]) if isinstance(one, Branch | Jump) else one
        with_marks += [MARK, moved] if has_mark else [moved]
    # A mark at the end of a block may be in it, or begin the next one.
    begun = {sum(one is not MARK for one in with_marks[: block.first]) for block in blocks(with_marks)}
    assert begun == {block.first for block in blocks(plain)}
