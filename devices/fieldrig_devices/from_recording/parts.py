"""A part of the rig of a recording: one bus with its devices, their files, and what a test reads of them."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from textwrap import wrap
from typing import NamedTuple

WIDTH = 116


class ReadBack(NamedTuple):
    """A request of a master whose answer the recording has, in hex."""

    bus: str
    node: int
    request: str
    answer: str


@dataclass
class RigPart:
    """A bus."""

    name: str
    is_can: bool
    booted_s: int = 1
    """Seconds after which its devices answer."""
    described: frozenset[Path] = frozenset()
    """The files of `--with` that describe a node here."""
    nodes: list[int] = field(default_factory=list)
    """Node-IDs or unit ids of its devices."""
    buses: list[str] = field(default_factory=list)
    """Lines of the rig file below `buses`."""
    devices: list[str] = field(default_factory=list)
    """Lines below `devices`."""
    files: dict[PurePosixPath, bytes] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)
    """Facts that the user should know at once."""
    read_backs: list[ReadBack] = field(default_factory=list)


def unknown_lines(sentences: Iterable[str]) -> Iterator[str]:
    """Yield the comment of a device with what is not known; nothing if all is known."""
    listed = list(sentences)
    if listed:
        yield from comment("Not known:", 2)
    for sentence in listed:
        yield from comment(f"- {sentence}", 2)


def comment(sentence: str, indent: int) -> Iterator[str]:
    """Yield the lines of a comment."""
    text = "".join(character if character.isprintable() else "?" for character in sentence)
    head = f"{' ' * indent}# "
    yield from wrap(text, WIDTH, initial_indent=head, subsequent_indent=f"{head}  ", break_on_hyphens=False)
