"""The telegrams of a HIPERFACE line in words: commands, answers, positions and status messages.

The line has one talker at a time, so a telegram that was cut short ends when the other end speaks.
"""

from collections.abc import Sequence
from typing import Final

from fieldrig_devices.hiperface.telegram import ERROR_BIT, Command, about, answer_length, checksum, request_length
from fieldrig_devices.line_names.described import Part

LONGEST: Final = 300
"""Bytes of a telegram that are kept until its end comes."""
COMMANDS: Final = {int(command): command.name.replace("_", " ") for command in Command}


class HiperfaceReader:
    """Reads the bytes of a line to an encoder."""

    def __init__(self, encoder: str) -> None:
        """`encoder` is its name in the rig."""
        self._encoder = encoder
        self._open = bytearray()
        self._talker = ""

    def __call__(self, sender: str, data: bytes) -> Sequence[Part]:
        if sender != self._talker:
            self._talker = sender
            self._open.clear()
        self._open += data
        found: list[Part] = []
        while (part := self._next(is_answer=sender == self._encoder)) is not None:
            found.append(part)
        return found

    def _next(self, *, is_answer: bool) -> Part | None:
        head = self._open
        length = (answer_length if is_answer else request_length)(head)
        is_known = len(head) < 2 or (head[1] & ~ERROR_BIT if is_answer else head[1]) in COMMANDS
        if not is_known or len(head) > LONGEST:
            text = bytes(head).hex(" ").upper()
            head.clear()
            return "no telegram", text
        if length is None or len(head) < length:
            return None
        telegram = bytes(head[:length])
        del head[:length]
        return _words(telegram, is_answer=is_answer)


def _words(telegram: bytes, *, is_answer: bool) -> Part:
    address, command, data = telegram[0], telegram[1], telegram[2:-1]
    if checksum(telegram) != 0:
        return "wrong checksum", telegram.hex(" ").upper()
    has_status = is_answer and bool(command & ERROR_BIT)
    code = command & ~ERROR_BIT if is_answer else command
    texts = [f"encoder {address:02X}h", _data(code, data, is_answer=is_answer)]
    texts += ["status messages wait"] if has_status else []
    return COMMANDS[code] + (" answer" if is_answer else ""), ", ".join(filter(None, texts))


def _data(command: int, data: bytes, *, is_answer: bool) -> str:
    if is_answer and command == Command.READ_POSITION:
        return f"position {int.from_bytes(data, 'big')}"
    if is_answer and command == Command.READ_STATUS:
        return f"{data[0]:02X}h {about(data[0])}"
    return data.hex(" ").upper()
