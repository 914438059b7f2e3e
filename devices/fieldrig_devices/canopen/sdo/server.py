"""SDO server: initiates transfers, completes expedited ones, supervises the others, and aborts after errors.

Source: CiA 301 7.2.4.3, 7.5.2.33 (1200h).  Frames that are not 8 bytes long are ignored.
A transfer is aborted when its client has been silent for the time-out; if the end of a block is lost, the segments
received so far are confirmed after half of that time.
"""

from functools import partial
from struct import Struct

from fieldrig.clock import Alarm, Clock
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.cob_id import INVALID, can_key, guard, is_valid
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.port import Port
from fieldrig_devices.canopen.sdo import block as sdo_block
from fieldrig_devices.canopen.sdo.block import BlockDownload, BlockUpload
from fieldrig_devices.canopen.sdo.segmented import SegmentedDownload, SegmentedUpload, Transfer
from fieldrig_devices.canopen.service import Object, Reset, Service, State
from fieldrig_devices.canopen.variable import Variable

FIRST_SERVER = 0x1200
LAST_SERVER = 0x127F
REQUEST_ID, RESPONSE_ID = 0x600, 0x580

# Client command specifiers.
DOWNLOAD_SEGMENT, INITIATE_DOWNLOAD, INITIATE_UPLOAD, UPLOAD_SEGMENT, ABORT, BLOCK_UPLOAD, BLOCK_DOWNLOAD = range(7)
ABORTS = 0x80

EXPEDITED, SIZE_INDICATED = 0x02, 0x01
DOWNLOADED = b"\x60"
UPLOAD_IN_SEGMENTS = b"\x41"
# First byte and padding of an expedited upload by number of data bytes.
UPLOADED = {1: (b"\x4f", bytes(3)), 2: (b"\x4b", bytes(2)), 3: (b"\x47", bytes(1)), 4: (b"\x43", b"")}

INITIATE = Struct("<BHBL")
ABORTED = Struct("<B3sL")
NO_MULTIPLEXER = bytes(3)


class SdoServer(Service):
    """One server channel; `index` is its parameter object, 1200h for the default channel of every node."""

    def __init__(
        self, clock: Clock, port: Port, dictionary: Dictionary, index: int, timeout_ns: int, block_size: int
    ) -> None:
        self._clock, self._port, self._dictionary = clock, port, dictionary
        self._half_timeout_ns, self._block_size = timeout_ns // 2, block_size
        self._is_prompted = False
        self._timeout = Alarm(clock)
        self._transfer: Transfer | None = None
        self._multiplexer = NO_MULTIPLEXER
        self._cob_ids = [dictionary.get(index, 1), dictionary.get(index, 2)]
        self._is_first = index == FIRST_SERVER
        self._response_key = 0
        for variable in self._cob_ids:
            if variable is not None:
                guard(variable)
                variable.watchers.append(self._configure)

    def reset(self, scope: Reset) -> None:
        self._end()
        self._configure()

    def enter(self, state: State) -> None:
        if state in (State.STOPPED, State.INITIALISING):
            self._end()

    def _configure(self) -> None:
        request_id, response_id = (
            (variable.number if variable is not None else 0) or default
            for variable, default in zip(self._cob_ids, self._defaults(), strict=True)
        )
        self._response_key = can_key(response_id)
        key = can_key(request_id) if is_valid(request_id) and is_valid(response_id) else None
        self._port.listen(self, Object.SDO, key, self._on_frame)

    def _defaults(self) -> tuple[int, int]:
        """Return the default COB-IDs: only the first server is in the pre-defined connection set (7.5.2.33)."""
        node_id = self._port.node_id
        return (REQUEST_ID + node_id, RESPONSE_ID + node_id) if self._is_first else (INVALID, INVALID)

    def _on_frame(self, frame: CanFrame) -> None:
        request = frame.data
        if len(request) != 8:
            return
        try:
            transfer = self._transfer
            response = self._initiate(request) if transfer is None else self._go_on(transfer, request)
        except Abort as abort:
            response = ABORTED.pack(0x80, self._multiplexer, abort.code)
            self._end()
        if response is not None:
            self._port.send(self._response_key, response)

    def _initiate(self, request: bytes) -> bytes | None:
        command, index, subindex, number = INITIATE.unpack(request)
        specifier = command >> 5
        self._multiplexer = request[1:4]
        if specifier == INITIATE_UPLOAD:
            return self._upload(self._dictionary.find(index, subindex).read())
        if specifier == INITIATE_DOWNLOAD:
            return self._download(command, self._dictionary.find(index, subindex), number, request)
        if specifier == ABORT:
            return None
        if command & sdo_block.UPLOAD_COMMAND == sdo_block.UPLOAD:
            return self._block_upload(request, self._dictionary.find(index, subindex))
        if command & sdo_block.DOWNLOAD_COMMAND == sdo_block.DOWNLOAD:
            return self._block_download(command, self._dictionary.find(index, subindex), number)
        if specifier in (DOWNLOAD_SEGMENT, UPLOAD_SEGMENT, BLOCK_UPLOAD, BLOCK_DOWNLOAD):
            self._multiplexer = NO_MULTIPLEXER  # bytes 1 to 3 are data here
        raise Abort(Code.UNKNOWN_COMMAND_SPECIFIER)

    def _upload(self, data: bytes) -> bytes:
        size = len(data)
        if 0 < size <= 4:
            first, padding = UPLOADED[size]
            return first + self._multiplexer + data + padding
        self._begin(SegmentedUpload(data))
        return UPLOAD_IN_SEGMENTS + self._multiplexer + size.to_bytes(4, "little")

    def _download(self, command: int, variable: Variable, number: int, request: bytes) -> bytes:
        if command & EXPEDITED:
            if command & SIZE_INDICATED:
                variable.write(request[4 : 8 - (command >> 2 & 3)])
            else:  # the data type of the object gives the size
                variable.write(request[4 : 4 + min(4, variable.type.size or 4)])
        else:
            size = number if command & SIZE_INDICATED else None
            variable.check_writable(size)
            self._begin(SegmentedDownload(size, variable.check_room, variable.write))
        return DOWNLOADED + self._multiplexer + bytes(4)

    def _block_upload(self, request: bytes, variable: Variable) -> bytes:
        command, block_size, threshold = request[0], request[4], request[5]
        sdo_block.check_block_size(block_size)
        data = variable.read()
        if len(data) <= threshold != 0:  # 7.2.4.3.13: short enough for the client to prefer another protocol
            return self._upload(data)
        send = partial(self._port.send, self._response_key)
        self._begin(BlockUpload(data, block_size, bool(command & sdo_block.CRC), send))
        first = sdo_block.UPLOAD_INITIATED | command & sdo_block.CRC | sdo_block.SIZE_INDICATED
        return bytes((first,)) + self._multiplexer + len(data).to_bytes(4, "little")

    def _block_download(self, command: int, variable: Variable, number: int) -> bytes:
        size = number if command & sdo_block.SIZE_INDICATED else None
        variable.check_writable(size)
        is_checked = bool(command & sdo_block.CRC)
        self._begin(BlockDownload(self._block_size, size, is_checked, variable.check_room, variable.write))
        first = sdo_block.DOWNLOAD_INITIATED | command & sdo_block.CRC
        return bytes((first,)) + self._multiplexer + bytes((self._block_size, 0, 0, 0))

    def _begin(self, transfer: Transfer) -> None:
        self._transfer = transfer
        self._wait()

    def _wait(self) -> None:
        self._is_prompted = False
        self._timeout.after(self._half_timeout_ns, self._on_timeout)

    def _go_on(self, transfer: Transfer, request: bytes) -> bytes | None:
        if request[0] & transfer.abort_mask == ABORTS:
            self._end()
            return None
        response = transfer.on_request(request)
        if transfer.is_finished:
            self._end()
        else:
            self._wait()
        return response

    def _end(self) -> None:
        if self._transfer is not None:
            self._transfer = None
            self._timeout.stop()

    def _on_timeout(self) -> None:
        if self._transfer is not None and not self._is_prompted:
            self._is_prompted = True
            self._timeout.after(self._half_timeout_ns, self._on_timeout)
            reminder = self._transfer.prompt()
            if reminder is not None:
                self._port.send(self._response_key, reminder)
            return
        self._end()
        self._port.send(self._response_key, ABORTED.pack(0x80, self._multiplexer, Code.PROTOCOL_TIMED_OUT))
