"""Cells of memory that a block keeps in local variables while it runs, so that reading them costs next to nothing.

Every write still goes to the memory as well, so what a fault or the end of a slice leaves there is complete.  Nothing
else runs during a block, so a cell only changes by the block's own writes: `registers` are the texts of cells that a
routine reaches by no other text, and a block that writes through a computed address keeps nothing.
"""

import re
from collections.abc import Collection, Iterator, Sequence
from typing import Final

_CELL: Final = re.compile(r"M\[(?:\d+|(?:frame|base)(?: \+ \d+)?)\]")
_WRITE: Final = re.compile(r" *(M\[(?:\d+|(?:frame|base)(?: \+ \d+)?)\]) = ")
_COMPUTED: Final = re.compile(
    r"^ *M\[M\[|^ *M\[[^\]]*:|\b(?:poke\w*|native_\d+|begin_\w+|set_parameter|put|on_output|finish|taken|routine_\d+)\("
)
"""Writes to somewhere else, and calls during which anything may happen."""
_CHECK: Final = re.compile(r" *if not -?\d+ <= (r\d+) <= -?\d+:$")
_SET: Final = re.compile(r"\b(r\d+) = ")
FEWEST: Final = 3
"""Reads for which it pays to load a cell in front of a block that is no loop."""


def is_register(text: str) -> bool:
    return _CELL.fullmatch(text) is not None


def kept(texts: Sequence[str], registers: Collection[str], *, is_loop: bool) -> tuple[list[str], list[str | None]]:
    """Return lines that load cells in front of a block, and the lines of the block with local variables for them.

    None stands for a line that is not needed.
    """
    if any(map(_COMPUTED.search, texts)):
        return [], list(texts)
    names = {text: f"r{number}" for number, text in enumerate(_worthwhile(texts, registers, is_loop))}
    if not names:
        return [], list(texts)
    loads = [f"{name} = {text}" for text, name in names.items() if is_loop or not _is_written_first(texts, text)]
    return loads, _checked_once([_replaced(text, names) if "M[" in text else text for text in texts])


def _checked_once(texts: list[str]) -> list[str | None]:
    """Leave out what has been checked before in every case, since its variable has not changed."""
    once: list[str | None] = list(texts)
    checked: dict[str, tuple[str, int]] = {}
    """The variable of each check, and how deeply it is indented: it holds until its arm ends."""
    for number, text in enumerate(texts):
        depth = len(text) - len(text.lstrip())
        checked = {line: (name, level) for line, (name, level) in checked.items() if level <= depth}
        check = _CHECK.match(text)
        if check is not None and number + 1 < len(texts) and "outside_" in texts[number + 1]:
            if text.strip() in checked:
                once[number] = once[number + 1] = None
            else:
                checked[text.strip()] = check[1], depth
        elif (write := _SET.search(text)) is not None:
            checked = {line: operand for line, operand in checked.items() if operand[0] != write[1]}
    return once


def _worthwhile(texts: Sequence[str], registers: Collection[str], is_loop: bool) -> Iterator[str]:
    reads: dict[str, int] = {}
    for text in texts:
        if "M[" in text:
            write = _WRITE.match(text)
            for cell in _CELL.findall(text, write.end() if write else 0):
                if cell in registers:
                    reads[cell] = reads.get(cell, 0) + 1
    for cell, count in reads.items():
        if is_loop or count >= FEWEST or (count > 1 and _is_written_first(texts, cell)):
            yield cell


def _is_written_first(texts: Sequence[str], cell: str) -> bool:
    """True if a block writes the cell, in every case, before it reads it."""
    first = next(text for text in texts if cell in text)
    write = _WRITE.match(first)
    return write is not None and write[1] == cell and first[0] != " " and cell not in first[write.end() :]


def _replaced(text: str, names: dict[str, str]) -> str:
    write = _WRITE.match(text)
    start = write.end() if write else 0
    rest = _CELL.sub(lambda match: names.get(match[0], match[0]), text[start:])
    if write is None or write[1] not in names:
        return text[:start] + rest
    return f"{text[:start]}{names[write[1]]} = {rest}"
