"""Requests that transfer an object file: download, which takes effect when it is complete, and upload.

Source: manual 5.2 (download in program STOP condition only).  The blocks of a download are kept aside; the present
program is kept until the last request has found everything complete and the card has accepted it.  The card compiles
the new program meanwhile, and answers that request when it is done.
"""

import zlib
from collections.abc import Callable

from fieldrig.loop.background import Job
from fieldrig_devices.arp.card_access import CardAccess, CardState, RefusedError
from fieldrig_devices.arp.language import files
from fieldrig_devices.arp.language.files import ObjectError
from fieldrig_devices.arp.user_port.handlers import Handlers, bare
from fieldrig_devices.arp.user_port.messages import (
    BLOCK,
    LARGEST_BLOCK,
    WHOLE,
    Command,
    RequestError,
    Status,
)


class TransferRequests:
    def __init__(self, card: CardAccess, on_outcome: Callable[[RequestError | None], None]) -> None:
        """`on_outcome` is called with the outcome of a COMMIT that was not answered at once."""
        self._card, self._on_outcome = card, on_outcome
        self._job: Job | None = None
        self._announced = (0, 0)  # length and CRC
        self._coming: bytearray | None = None
        self._going = b""
        self.handlers: Handlers = {
            Command.DOWNLOAD_BEGIN: self._begin,
            Command.DOWNLOAD_BLOCK: self._block,
            Command.DOWNLOAD_COMMIT: bare(self._commit),
            Command.DOWNLOAD_ABORT: bare(self._abort),
            Command.UPLOAD_BEGIN: bare(self._upload_begin),
            Command.UPLOAD_BLOCK: self._upload_block,
        }

    def drop(self) -> None:
        """Discard a partial transfer, or one that the card has not accepted yet."""
        self._coming, self._going = None, b""
        if self._job is not None:
            self._job.cancel()
            self._job = None

    def _begin(self, data: bytes) -> bytes:
        length, crc = WHOLE.unpack(data)
        if not 1 <= length <= files.LARGEST_OBJECT:
            raise RequestError(Status.RANGE, f"expected an object of 1 to {files.LARGEST_OBJECT} bytes")
        self._refuse_while_running()
        self.drop()
        self._announced, self._coming = (length, crc), bytearray()
        return LARGEST_BLOCK.to_bytes(2, "little")

    def _block(self, data: bytes) -> bytes:
        (offset,) = BLOCK.unpack_from(data)
        block = data[BLOCK.size :]
        if self._coming is None or offset != len(self._coming):
            raise RequestError(Status.ORDER, self._expected())
        if not 1 <= len(block) <= LARGEST_BLOCK or offset + len(block) > self._announced[0]:
            raise RequestError(Status.LENGTH, f"expected 1 to {LARGEST_BLOCK} bytes, and no more than announced")
        self._coming += block
        return b""

    def _commit(self) -> bytes | None:
        if self._job is not None:
            return None  # sent again, before it was answered
        if self._coming is None:
            raise RequestError(Status.ORDER, self._expected())
        whole, self._coming = bytes(self._coming), None
        if (len(whole), zlib.crc32(whole)) != self._announced:
            raise RequestError(
                Status.DAMAGED, "the data do not match the announced length and CRC; start the transfer again"
            )
        self._refuse_while_running()
        self._job = self._card.load(whole, self._on_loaded)
        return None

    def _on_loaded(self, reason: RefusedError | ObjectError | None) -> None:
        self._job = None
        status = Status.REFUSED if isinstance(reason, RefusedError) else Status.OBJECT
        self._on_outcome(None if reason is None else RequestError(status, str(reason)))

    def _abort(self) -> bytes:
        self.drop()
        return b""

    def _expected(self) -> str:
        if self._coming is None:
            return "no download has begun"
        return f"the next block begins at {len(self._coming)}"

    def _refuse_while_running(self) -> None:
        if self._card.state in (CardState.INIT, CardState.RUN):
            raise RequestError(Status.REFUSED, "the program is running: stop it or open Enable first")

    def _upload_begin(self) -> bytes:
        if self._card.program is None:
            raise RequestError(Status.NO_PROGRAM)
        self._going = self._card.program_object
        return WHOLE.pack(len(self._going), zlib.crc32(self._going))

    def _upload_block(self, data: bytes) -> bytes:
        (offset,) = BLOCK.unpack(data)
        if not self._going:
            raise RequestError(Status.ORDER, "no upload has begun")
        if offset >= len(self._going):
            raise RequestError(Status.RANGE, f"the object has only {len(self._going)} bytes")
        return self._going[offset : offset + LARGEST_BLOCK]
