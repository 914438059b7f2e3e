"""The retain data of a program in buffered RAM, where a killed process leaves all values of a cycle together.

A commit writes the data to a journal first, then a word that says that the journal is complete, then the data
themselves, and then it clears the word.  If the word is still set at the next start, the journal is written again.
Beside the data is a mark that says which program they belong to.
"""

import struct
import zlib
from typing import Final, NamedTuple

MARK_BYTES: Final = 8
_HEAD: Final = struct.Struct(f"<{MARK_BYTES}sII")  # mark, length, check sum of mark, length and data
_WORD: Final = struct.Struct("<I")
_COMPLETE: Final = 0x454E4F44
_NOTHING: Final = bytes(_HEAD.size)
_WORD_AT, _HEAD_AT, _JOURNAL_AT = 0, 4, 4 + _HEAD.size


def extra_bytes(size: int) -> int:
    """Memory that is needed beside `size` bytes of retain data, in whole words."""
    return (_JOURNAL_AT + _HEAD.size + size + 3) // 4 * 4


class Values(NamedTuple):
    """The retain data of a program, and the mark of that program."""

    mark: bytes
    data: bytes


class Retained:
    """The retain data in `memory`; `beside` has `extra_bytes(len(memory))` bytes."""

    def __init__(self, memory: memoryview, beside: memoryview) -> None:
        self._memory, self._beside = memory, beside

    def commit(self, values: Values) -> None:
        """Write values that fit into the memory, so that they are there as a whole or not at all."""
        head = _HEAD.pack(values.mark, len(values.data), _sum(values))
        at = _JOURNAL_AT
        self._beside[at : at + len(head) + len(values.data)] = head + values.data
        _WORD.pack_into(self._beside, _WORD_AT, _COMPLETE)
        self._write(head, values.data)
        _WORD.pack_into(self._beside, _WORD_AT, 0)

    def recover(self) -> None:
        """Finish a commit that a kill has interrupted."""
        (word,) = _WORD.unpack_from(self._beside, _WORD_AT)
        if word == _COMPLETE:
            head = bytes(self._beside[_JOURNAL_AT : _JOURNAL_AT + _HEAD.size])
            data = bytes(self._beside[_JOURNAL_AT + _HEAD.size :])
            values = _values(head, data)
            if values is not None and len(values.data) <= len(self._memory):
                self._write(head, values.data)
        _WORD.pack_into(self._beside, _WORD_AT, 0)

    @property
    def values(self) -> Values | None:
        """The values; None if there are none, or if they have been changed by something else."""
        return _values(bytes(self._beside[_HEAD_AT:_JOURNAL_AT]), bytes(self._memory))

    def clear(self) -> None:
        self.paste(b"")

    def copy(self) -> bytes:
        """Everything, for another memory."""
        return bytes(self._memory) + bytes(self._beside[_HEAD_AT:_JOURNAL_AT])

    def paste(self, copy: bytes) -> bool:
        """Take over a copy; empty to clear.  Return false, and change nothing, if it does not have the right size."""
        size = len(self._memory)
        if len(copy) not in (0, size, size + _HEAD.size):  # without a head before there were programs
            return False
        self._memory[:] = copy[:size].ljust(size, b"\0")
        self._beside[_HEAD_AT:_JOURNAL_AT] = copy[size:].ljust(_HEAD.size, b"\0")
        _WORD.pack_into(self._beside, _WORD_AT, 0)
        return True

    def _write(self, head: bytes, data: bytes) -> None:
        self._memory[: len(data)] = data
        self._beside[_HEAD_AT:_JOURNAL_AT] = head


def _sum(values: Values) -> int:
    return zlib.crc32(values.data, zlib.crc32(values.mark + len(values.data).to_bytes(4, "little")))


def _values(head: bytes, memory: bytes) -> Values | None:
    if head == _NOTHING:
        return None
    mark, length, check = _HEAD.unpack(head)
    values = Values(mark, memory[:length])
    return values if length <= len(memory) and _sum(values) == check else None
