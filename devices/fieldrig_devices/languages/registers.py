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
FEWEST: Final = 3
"""Reads for which it pays to load a cell in front of a block that is no loop."""


def is_register(text: str) -> bool:
    return _CELL.fullmatch(text) is not None


def kept(texts: Sequence[str], registers: Collection[str], *, is_loop: bool) -> tuple[list[str], list[str]]:
    """Return lines that load cells in front of a block, and the lines of the block with local variables for them."""
    if any(map(_COMPUTED.search, texts)):
        return [], list(texts)
    names = {text: f"r{number}" for number, text in enumerate(_worthwhile(texts, registers, is_loop))}
    if not names:
        return [], list(texts)
    loads = [f"{name} = {text}" for text, name in names.items() if is_loop or not _is_written_first(texts, text)]
    return loads, [_replaced(text, names) for text in texts]


def _worthwhile(texts: Sequence[str], registers: Collection[str], is_loop: bool) -> Iterator[str]:
    reads: dict[str, int] = {}
    for text in texts:
        write = _WRITE.match(text)
        for cell in _CELL.findall(text, write.end() if write else 0):
            if cell in registers:
                reads[cell] = reads.get(cell, 0) + 1
    for cell, count in reads.items():
        if is_loop or count >= FEWEST or _is_written_first(texts, cell):
            yield cell


def _is_written_first(texts: Sequence[str], cell: str) -> bool:
    """True if a block writes the cell, in every case, before it reads it."""
    first = next(text for text in texts if cell in text)
    write = _WRITE.match(first)
    is_always = _depth(first) == min(map(_depth, texts))
    return write is not None and write[1] == cell and is_always and cell not in first[write.end() :]


def _depth(text: str) -> int:
    return len(text) - len(text.lstrip())


def _replaced(text: str, names: dict[str, str]) -> str:
    write = _WRITE.match(text)
    start = write.end() if write else 0
    rest = _CELL.sub(lambda match: names.get(match[0], match[0]), text[start:])
    if write is None or write[1] not in names:
        return text[:start] + rest
    return f"{text[:start]}{names[write[1]]} = {rest}"
