"""Dialogues: messages of a log that belong together, such as a request and its answer."""

from dataclasses import dataclass
from typing import Protocol


class Dialogue(Protocol):
    """Messages that belong together.  `SdoTransfer`, `ModbusExchange` and `Stray` are dialogues."""

    @property
    def begin_ns(self) -> int:
        """The instant of the first message."""

    @property
    def end_ns(self) -> int | None:
        """The instant of the message that completed it, or that gave it up; None if the log shows no such message."""

    @property
    def bus(self) -> str:
        """The bus of its messages, as the log names it."""

    @property
    def entries(self) -> tuple[int, ...]:
        """The numbers of its messages in the log, from 0."""


@dataclass(frozen=True, slots=True)
class Stray:
    """A message that belongs to no dialogue of the log: one that began before the log, or one that broke the rules."""

    begin_ns: int
    end_ns: int | None
    bus: str
    entries: tuple[int, ...]
    why: str
    """The reason in words."""
