"""Words over TCP: a small protocol of ours for programs that need nothing but the memory.

All numbers are 16 bits, big endian.  A request is an operation (one byte), the number of the first word and a count;
W has the new words behind it, and C the expected and the new value of one word.  An answer is a status (one byte) and,
if that is 0, the words that R has read, or the value that C has found.  C writes only if it finds the expected value.
Requests are carried out in their order, and one that is malformed ends the connection.
"""

import struct
from typing import Final

from fieldrig_devices.connections.connection import UNREAD, Connection, Serve
from fieldrig_devices.pam.ports.memory import WORDS, Memory

READ, WRITE, COMPARE = b"R"[0], b"W"[0], b"C"[0]
OK: Final = 0
NO_SUCH_WORD: Final = 1
HEAD: Final = struct.Struct(">BHH")
PAIR: Final = struct.Struct(">HH")
MOST_UNSENT: Final = 1 << 20
"""Bytes of answers that a client may leave untaken."""


def serving_words(memory: Memory) -> Serve:
    return lambda connection: WordSession(memory, connection)


class WordSession:
    """One connection."""

    def __init__(self, memory: Memory, connection: Connection) -> None:
        self._memory, self._connection = memory, connection
        self._received = bytearray()

    def received(self, data: bytes) -> None:
        self._received += data
        answers = bytearray()
        while (size := self._size()) is not None and len(self._received) >= size:
            answers += self._answer(bytes(self._received[:size]))
            del self._received[:size]
        if answers:
            self._connection.write(bytes(answers))
        if self._connection.unsent > MOST_UNSENT:
            self._connection.cut(UNREAD)
        elif self._is_malformed:
            self._connection.close()

    def drained(self) -> None:
        """Do nothing: answers are written at once."""

    def ended(self) -> None:
        self._connection.close()

    def lost(self) -> None:
        self._received.clear()

    @property
    def _is_malformed(self) -> bool:
        """True if what was received cannot begin a request."""
        if self._received and self._received[0] not in (READ, WRITE, COMPARE):
            return True
        return len(self._received) >= HEAD.size and HEAD.unpack_from(self._received)[2] > WORDS

    def _size(self) -> int | None:
        """Return the length of the request that comes next; None if it is not known."""
        if len(self._received) < HEAD.size or self._is_malformed:
            return None
        operation, _, count = HEAD.unpack_from(self._received)
        sizes = {READ: 0, WRITE: 2 * int(count), COMPARE: PAIR.size}
        return HEAD.size + sizes[operation]

    def _answer(self, request: bytes) -> bytes:
        operation, word, count = HEAD.unpack_from(request)
        body = request[HEAD.size :]
        try:
            if operation == READ:
                return bytes((OK,)) + struct.pack(f">{count}H", *self._memory.read(word, count))
            if operation == WRITE:
                self._memory.write(word, struct.unpack(f">{count}H", body))
                return bytes((OK,))
            return bytes((OK,)) + self._compare(word, *PAIR.unpack(body)).to_bytes(2, "big")
        except IndexError:
            return bytes((NO_SUCH_WORD,))

    def _compare(self, word: int, expected: int, value: int) -> int:
        (present,) = self._memory.read(word, 1)
        if present == expected:
            self._memory.write(word, (value,))
        return present
