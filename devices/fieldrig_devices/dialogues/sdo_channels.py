"""The SDO channels of a bus: which identifiers carry the requests of a client, and which the answers of a server.

Source: CiA 301 version 4.2, 7.3.5 (the default channel of each node), 7.5.2.33 (1200h to 127Fh, the servers of a node)
and 7.5.2.34 (1280h to 12FFh, its clients).  Others than the default channels are known when the log shows that both
identifiers were read or written, or when the EDS file of a node has them.
"""

from typing import Final, NamedTuple

from fieldrig_devices.canopen.cob_id import can_key, is_valid
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.sdo.server import REQUEST_ID, RESPONSE_ID
from fieldrig_devices.dialogues.sdo_transfer import SdoTransfer

NODES: Final = range(1, 128)
SERVERS, CLIENTS = range(0x1200, 0x1280), range(0x1280, 0x1300)
DESCRIBED: Final = range(0x1201, 0x1300)
"""Objects with the channels of an EDS file; the default channel of a node depends on its node-ID alone."""
CLIENT_TO_SERVER, SERVER_TO_CLIENT, SERVER = 1, 2, 3
"""Sub-indices; the last one is the node-ID of a client's server."""


class End(NamedTuple):
    """One end of a channel, which sends with an identifier."""

    node_id: int
    """Node-ID of the server."""
    request_key: int
    """The identifier of the requests of this channel; bit 31 marks one of 29 bits."""
    is_client: bool
    """True if the client sends messages with this identifier."""


DEFAULT: Final = {
    **{REQUEST_ID + node_id: End(node_id, REQUEST_ID + node_id, True) for node_id in NODES},
    **{RESPONSE_ID + node_id: End(node_id, REQUEST_ID + node_id, False) for node_id in NODES},
}


class SdoChannels:
    """The channels of one bus, by identifier."""

    def __init__(self) -> None:
        self._numbers: dict[tuple[int, int, int], int] = {}
        """Parameters that are known, by node-ID, index and sub-index."""
        self.ends: dict[int, End] = DEFAULT

    def put(self, node_id: int, index: int, subindex: int, number: int) -> None:
        """Take into account that a parameter of a node has this number."""
        if index in SERVERS or index in CLIENTS:
            self._numbers[node_id, index, subindex] = number
            self._find()

    def describe(self, node_id: int, dictionary: Dictionary) -> None:
        """Take the channels that the EDS file of a node gives it."""
        for variable in dictionary:
            if variable.index in DESCRIBED and variable.subindex in (CLIENT_TO_SERVER, SERVER_TO_CLIENT, SERVER):
                self._numbers[node_id, variable.index, variable.subindex] = variable.number
        self._find()

    def take(self, transfer: SdoTransfer) -> None:
        """Learn from a transfer that has been completed."""
        if transfer.data is not None and transfer.subindex in (CLIENT_TO_SERVER, SERVER_TO_CLIENT, SERVER):
            self.put(transfer.node_id, transfer.index, transfer.subindex, int.from_bytes(transfer.data[:4], "little"))

    def _find(self) -> None:
        self.ends = dict(DEFAULT)
        for node_id, index, subindex in self._numbers:
            if subindex != CLIENT_TO_SERVER:
                continue
            request, response = (self._numbers.get((node_id, index, sub)) for sub in (subindex, SERVER_TO_CLIENT))
            server = node_id if index in SERVERS else self._numbers.get((node_id, index, SERVER))
            if request is not None and response is not None and server is not None:
                self._add(server & 0x7F, request, response)

    def _add(self, node_id: int, request: int, response: int) -> None:
        if is_valid(request) and is_valid(response) and can_key(request) != can_key(response):
            self.ends[can_key(request)] = End(node_id, can_key(request), True)
            self.ends[can_key(response)] = End(node_id, can_key(request), False)
