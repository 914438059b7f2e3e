"""The steps of an SDO transfer, as an observer of both sides sees them.

Source: CiA 301 version 4.2, 7.2.4.3.  Only what both sides have agreed on counts: a segment of a block belongs to the
content when the other side has confirmed it.  A message that fits to no step is a stray, and changes nothing, because
both sides drop it as well.
"""

from abc import ABC, abstractmethod
from binascii import crc_hqx
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Final

from fieldrig_devices.canopen.sdo import block as sdo_block
from fieldrig_devices.canopen.sdo.client import EXPEDITED, SIZE_INDICATED
from fieldrig_devices.canopen.sdo.segmented import LAST, TOGGLE
from fieldrig_devices.canopen.sdo.server import (
    BLOCK_DOWNLOAD,
    BLOCK_UPLOAD,
    DOWNLOAD_SEGMENT,
    INITIATE_DOWNLOAD,
    INITIATE_UPLOAD,
    UPLOAD_SEGMENT,
)
from fieldrig_devices.canopen.sdo_names import VALUE, WRITTEN, expedited
from fieldrig_devices.dialogues.sdo_transfer import Form

SEGMENT_VALUE, SEGMENT_WRITTEN = 0, 1
"""Command specifiers of the server for segments."""
COMMAND: Final = 0xE0
"""Mask of the command specifier, which says whether a message is an abort (80h)."""
WHOLE: Final = 0xFF
"""The same within a block, where the other bits are a part of sequence numbers."""
TOGGLED: Final = "the toggle bit did not alternate"


class Verdict(Enum):
    """The meaning of a message for a transfer."""

    STRAY = auto()
    TAKEN = auto()
    ENDED = auto()


STRAY, TAKEN, ENDED = Verdict


@dataclass(slots=True)
class Content:
    """The facts that are known of a transfer that goes on."""

    is_download: bool
    form: Form
    data: bytearray = field(default_factory=bytearray)
    size: int | None = None
    wrong: str = ""
    is_spoiled: bool = False
    """True if a part of the data is not known."""

    def note(self, wrong: str) -> None:
        """Note what is wrong; only the first thing is kept, as others follow from it."""
        self.wrong = self.wrong or wrong

    def spoil(self, wrong: str) -> None:
        self.note(wrong)
        self.is_spoiled = True


class Steps(ABC):
    """The messages that may come next in a transfer."""

    client_abort = server_abort = COMMAND
    """Masks of the first byte that identify an abort (80h)."""

    @abstractmethod
    def client(self, message: bytes) -> Verdict:
        """Take a message of the client that is not an abort."""

    @abstractmethod
    def server(self, message: bytes) -> "Verdict | Steps":
        """Take a message of the server that is not an abort; the steps that follow if they are others."""


class SegmentedDownload(Steps):
    def __init__(self, content: Content) -> None:
        self._content = content
        self._toggle = 0
        self._open = b""
        """The segment that is not confirmed yet."""

    def client(self, message: bytes) -> Verdict:
        if message[0] >> 5 != DOWNLOAD_SEGMENT:
            return STRAY
        if message == self._open:
            return TAKEN  # sent again, as its confirmation was late
        if self._open:
            self._content.note("a confirmation is missing in the log")
            self._toggle ^= TOGGLE
        if message[0] & TOGGLE != self._toggle:
            self._content.spoil(TOGGLED)
        self._content.data += message[1 : 8 - (message[0] >> 1 & 7)]
        self._open = message
        return TAKEN

    def server(self, message: bytes) -> Verdict:
        if message[0] >> 5 != SEGMENT_WRITTEN or not self._open:
            return STRAY
        if message[0] & TOGGLE != self._toggle:
            self._content.spoil(TOGGLED)
        is_last = self._open[0] & LAST
        self._open, self._toggle = b"", self._toggle ^ TOGGLE
        return _last(self._content) if is_last else TAKEN


class SegmentedUpload(Steps):
    def __init__(self, content: Content) -> None:
        self._content = content
        self._toggle = 0

    def client(self, message: bytes) -> Verdict:
        if message[0] >> 5 != UPLOAD_SEGMENT:
            return STRAY
        if message[0] & TOGGLE != self._toggle:
            self._content.spoil(TOGGLED)
        return TAKEN

    def server(self, message: bytes) -> Verdict:
        if message[0] >> 5 != SEGMENT_VALUE:
            return STRAY
        if message[0] & TOGGLE != self._toggle:
            self._content.spoil(TOGGLED)
        self._content.data += message[1 : 8 - (message[0] >> 1 & 7)]
        self._toggle ^= TOGGLE
        return _last(self._content) if message[0] & LAST else TAKEN


def _last(content: Content) -> Verdict:
    """Return what the last segment is: no end after a wrong toggle bit, as an abort has to follow."""
    return TAKEN if content.is_spoiled else ENDED


class Block:
    """The segments of a block that are not confirmed yet."""

    def __init__(self, content: Content) -> None:
        self._content = content
        self._segments: dict[int, bytes] = {}
        self._last = 0
        """The number of the segment that ends the content; 0 before it came."""

    def take(self, message: bytes) -> Verdict:
        number = message[0] & sdo_block.MORE_MASK
        if number == 0:
            return STRAY
        self._segments[number] = message[1:]
        if message[0] & sdo_block.LAST:
            self._last = number
        return TAKEN

    def confirm(self, count: int) -> bool:
        """Add the first segments to the content; True if the last one is among them."""
        for number in range(1, count + 1):
            segment = self._segments.get(number)
            if segment is None:
                self._content.spoil(f"segment {number} of a block is missing in the log")
            else:
                self._content.data += segment
        is_last = 0 < self._last <= count
        self._segments.clear()
        self._last = 0
        return is_last

    def end(self, message: bytes, is_checked: bool) -> Verdict:
        """Take the message that says how much of the last segment is used, and the checksum."""
        command, check = sdo_block.END.unpack(message)
        content = self._content
        del content.data[max(0, len(content.data) - (command >> 2 & 7)) :]
        if is_checked and not content.is_spoiled and crc_hqx(bytes(content.data), 0) != check:
            content.note("the checksum does not fit the data")
        return TAKEN


class BlockDownload(Steps):
    client_abort = WHOLE

    def __init__(self, content: Content, is_checked: bool) -> None:
        self._block, self._is_checked = Block(content), is_checked
        self._is_last = self._is_ended = False

    def client(self, message: bytes) -> Verdict:
        if not self._is_last:
            return self._block.take(message)
        if message[0] & sdo_block.DOWNLOAD_COMMAND != sdo_block.DOWNLOAD_END or self._is_ended:
            return STRAY
        self._is_ended = True
        return self._block.end(message, self._is_checked)

    def server(self, message: bytes) -> Verdict:
        command = message[0] & sdo_block.UPLOAD_COMMAND
        if self._is_ended and command == sdo_block.DOWNLOAD_ENDED:
            return ENDED
        if self._is_last or command != sdo_block.DOWNLOAD_CONFIRM:
            return STRAY
        if self._block.confirm(message[1] & sdo_block.MORE_MASK):
            self._is_last, self.client_abort = True, COMMAND
        return TAKEN


class BlockUpload(Steps):
    def __init__(self, content: Content, is_checked: bool) -> None:
        self._block, self._is_checked = Block(content), is_checked
        self._is_started = self._is_last = self._is_ended = False

    def client(self, message: bytes) -> Verdict:
        command = message[0] & sdo_block.UPLOAD_COMMAND
        if command == sdo_block.UPLOAD_START and not self._is_started:
            self._is_started, self.server_abort = True, WHOLE
            return TAKEN
        if command == sdo_block.UPLOAD_CONFIRM and self._is_started and not self._is_last:
            if self._block.confirm(message[1] & sdo_block.MORE_MASK):
                self._is_last, self.server_abort = True, COMMAND
            return TAKEN
        return ENDED if command == sdo_block.UPLOAD_END and self._is_ended else STRAY

    def server(self, message: bytes) -> Verdict:
        if self._is_last:
            if message[0] & sdo_block.DOWNLOAD_COMMAND != sdo_block.UPLOAD_DATA_END or self._is_ended:
                return STRAY
            self._is_ended = True
            return self._block.end(message, self._is_checked)
        return self._block.take(message) if self._is_started else STRAY


class Asked(Steps):
    """A transfer that has been requested and not answered."""

    def __init__(self, request: bytes, content: Content) -> None:
        self._request, self.content = request, content

    def client(self, message: bytes) -> Verdict:
        return STRAY

    def server(self, message: bytes) -> Verdict | Steps:
        if message[1:4] != self._request[1:4]:
            return STRAY
        if self._request[0] >> 5 in (INITIATE_DOWNLOAD, BLOCK_DOWNLOAD):
            return self._download(message)
        return self._upload(message)

    def _download(self, message: bytes) -> Verdict | Steps:
        content = self.content
        if content.form == "block":
            if message[0] & sdo_block.UPLOAD_COMMAND != sdo_block.DOWNLOAD_INITIATED:
                return STRAY
            return BlockDownload(content, self._is_checked(message))
        if message[0] >> 5 != WRITTEN:
            return STRAY
        return ENDED if content.form == "expedited" else SegmentedDownload(content)

    def _upload(self, message: bytes) -> Verdict | Steps:
        content = self.content
        if content.form == "block" and message[0] & sdo_block.DOWNLOAD_COMMAND == sdo_block.UPLOAD_INITIATED:
            content.size = _number(message) if message[0] & sdo_block.SIZE_INDICATED else None
            return BlockUpload(content, self._is_checked(message))
        if message[0] >> 5 != VALUE:  # also the answer to a block upload of little data (7.2.4.3.13)
            return STRAY
        data = expedited(message)
        if data is not None:
            content.form = "expedited"
            content.data += data
            return ENDED
        content.form = "segmented"
        content.size = _number(message) if message[0] & SIZE_INDICATED else None
        return SegmentedUpload(content)

    def _is_checked(self, answer: bytes) -> bool:
        return bool(self._request[0] & answer[0] & sdo_block.CRC)


def asked(request: bytes) -> Asked | None:
    """Return the steps that a request of a client begins; None if it begins none."""
    command, specifier = request[0], request[0] >> 5
    if specifier == INITIATE_UPLOAD:
        return Asked(request, Content(False, "expedited"))
    if specifier == BLOCK_UPLOAD and command & sdo_block.UPLOAD_COMMAND == sdo_block.UPLOAD:
        return Asked(request, Content(False, "block"))
    if specifier == INITIATE_DOWNLOAD:
        data = expedited(request)
        if data is not None:
            return Asked(request, Content(True, "expedited", bytearray(data), len(data)))
        return Asked(request, Content(True, "segmented", size=_number(request) if command & SIZE_INDICATED else None))
    if specifier == BLOCK_DOWNLOAD and command & sdo_block.DOWNLOAD_COMMAND == sdo_block.DOWNLOAD:
        size = _number(request) if command & sdo_block.SIZE_INDICATED else None
        return Asked(request, Content(True, "block", size=size))
    return None


def _number(message: bytes) -> int:
    return int.from_bytes(message[4:], "little")


def needed(message: bytes, is_request: bool) -> int:
    """Return how many bytes of a message outside a block mean something."""
    command, specifier = message[0], message[0] >> 5
    if specifier == (INITIATE_DOWNLOAD if is_request else VALUE):
        if command & EXPEDITED:
            return 8 - (command >> 2 & 3 if command & SIZE_INDICATED else 0)
        return 8 if command & SIZE_INDICATED else 4
    if specifier == (DOWNLOAD_SEGMENT if is_request else SEGMENT_VALUE):
        return 8 - (command >> 1 & 7)
    if specifier == (UPLOAD_SEGMENT if is_request else SEGMENT_WRITTEN):
        return 1
    return 4 if specifier == (INITIATE_UPLOAD if is_request else WRITTEN) else 8
