"""Data exchange between ARP cards: the PDOs that carry variables and flag words, and where received words go.

Source: manual line 91 says that cards exchange information over CAN, and gives no instruction for it (digest I-38).  So
it is configuration: PDO parameters of the card's dictionary, which a foreign tool can read and change.  Channel k of a
card, 1 to 4, is its TPDO 4 + k; receptions are its RPDOs 5 to 8, in the order of the settings.
"""

import logging
import re
from collections.abc import Iterator
from typing import Annotated, Final, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from fieldrig.settings import Settings
from fieldrig_devices.arp.can import objects

log = logging.getLogger(__name__)

CHANNELS: Final = 4
FIRST_PDO: Final = 4
"""PDO 5, counted from 0."""
CHANNEL_IDS: Final = (0x240, 0x340, 0x440, 0x540)
"""CAN-ID of each channel for node-ID 0: those of the RPDOs of nodes from 64 on in the pre-defined connection set.

The CAN-IDs of their TPDOs would work too, but tools that scan for nodes take them for nodes.
"""
LAST_NODE: Final = 63
NOT_USED: Final = 1 << 31
MADE_HERE: Final = 1 << 30
SYNC_ID: Final = 0x80
AT_SYNC, AT_CHANGE = 1, 255
WORD_BITS: Final = 32
WORDS_IN_PDO: Final = 2

Objects = dict[str, bool | int | float | str]
"""Power-on values by index and sub-index, in the form that `CanopenSettings` accepts."""

SENT: Final = "V1 to V1000, FLAG1 to 10, OUT1 to 3, INP1 to 3, POS1, POS2, VEL1 or VEL2"
RECEIVED: Final = "V1 to V1000, FLAG1 to 10 or OUT1 to 3"
NAME: Final = re.compile(r"(?P<what>V|FLAG|OUT|INP|POS|VEL)(?P<number>[1-9]\d{0,3})")


def locate(word: str) -> tuple[int, int]:
    """Index and sub-index of the object for a word of the card: `V12`, `FLAG3`, `POS1`.

    Raises ValueError for other words.
    """
    match = NAME.fullmatch(word.upper())
    if match is None or not 1 <= int(match["number"]) <= objects.WORDS[match["what"]]:
        raise ValueError(f"{word!r} is not a word of the card; expected {SENT}")
    return objects.place(match["what"], int(match["number"]))


def _sent(word: str) -> str:
    locate(word)
    return word


def _received(word: str) -> str:
    locate(word)
    if word.upper().startswith(("INP", "POS", "VEL")):
        raise ValueError(f"{word!r} cannot be written; expected {RECEIVED}")
    return word


class Sent(Settings):
    """One channel that this card sends."""

    channel: Annotated[int, Field(ge=1, le=CHANNELS, description="1 to 4, each one PDO")]
    words: Annotated[
        list[Annotated[str, AfterValidator(_sent)]],
        Field(min_length=1, max_length=WORDS_IN_PDO, description=f"what it carries: {SENT}"),
    ]
    at: Annotated[Literal["change", "sync"], Field(description="sent when a word has changed, or with each SYNC")] = (
        "change"
    )
    every_ms: Annotated[
        int, Field(ge=0, le=0xFFFF, description="maximum time between two messages without a change; 0 disables it")
    ] = 0
    inhibit_ms: Annotated[int, Field(ge=0, le=6_553, description="minimum time between two messages")] = 0


class Received(Settings):
    """One channel of another card, which this card receives."""

    node: Annotated[int, Field(ge=1, le=LAST_NODE, description="node-ID, @Par[5], of the card that sends")]
    channel: Annotated[int, Field(ge=1, le=CHANNELS, description="its channel")]
    words: Annotated[
        list[Annotated[str, AfterValidator(_received)]],
        Field(min_length=1, max_length=WORDS_IN_PDO, description=f"destination of its words: {RECEIVED}"),
    ]
    timeout_ms: Annotated[
        int, Field(ge=0, le=0xFFFF, description="silence after which EMCY 8250h is sent; 0 disables it")
    ] = 0


class ExchangeSettings(Settings):
    """Settings under `exchange:` of a card."""

    send: list[Sent] = Field(default_factory=list, max_length=CHANNELS, description="channels of this card")
    receive: list[Received] = Field(default_factory=list, max_length=CHANNELS, description="channels of other cards")
    sync_ms: Annotated[
        int,
        Field(ge=0, le=1_000, description="period of the SYNC that this card produces; 0 if another node produces it"),
    ] = 0

    starts_itself: Annotated[
        bool, Field(description="whether a card that exchanges data enters 'operational' without a master (1F80h)")
    ] = True

    @model_validator(mode="after")
    def _channels_are_used_once(self) -> Self:
        channels = [sent.channel for sent in self.send]
        if len(set(channels)) != len(channels):
            raise ValueError(f"send: the channels are {channels}; expected each channel at most once")
        return self

    def check(self, node_id: int) -> None:
        """Raises ValueError for settings that are impossible for a card with this node-ID."""
        if self.send and node_id > LAST_NODE:
            raise ValueError(
                f"exchange.send: @Par[5] is {node_id}; expected a node-ID up to {LAST_NODE} for a card that sends"
            )
        if any(received.node == node_id for received in self.receive):
            raise ValueError(f"exchange.receive: node {node_id} is this card; expected the node-ID of another card")

    def objects(self, node_id: int) -> Objects:
        """Power-on values that configure a card with `node_id` for this exchange."""
        values: Objects = {}
        if self.send and node_id > LAST_NODE:
            log.warning("node-ID %d: only cards with node-IDs up to %d can send exchange channels", node_id, LAST_NODE)
        for sent in self.send if node_id <= LAST_NODE else ():
            values.update(_sending(sent, node_id))
        for index, received in enumerate(self.receive):
            values.update(_receiving(received, index))
        if self.starts_itself and (self.send or self.receive):
            values["1F80:00"] = 0
        if self.sync_ms:
            values |= {"1005:00": MADE_HERE | SYNC_ID, "1006:00": self.sync_ms * 1000}
        return values


def _sending(sent: Sent, node_id: int) -> Objects:
    pdo = FIRST_PDO + sent.channel - 1
    communication = f"{0x1800 + pdo:04X}"
    return {
        f"{communication}:01": CHANNEL_IDS[sent.channel - 1] + node_id,
        f"{communication}:02": AT_SYNC if sent.at == "sync" else AT_CHANGE,
        f"{communication}:03": sent.inhibit_ms * 10,
        f"{communication}:05": sent.every_ms,
        **dict(_mapping(0x1A00 + pdo, sent.words)),
    }


def _receiving(received: Received, index: int) -> Objects:
    pdo = FIRST_PDO + index
    communication = f"{0x1400 + pdo:04X}"
    return {
        f"{communication}:01": CHANNEL_IDS[received.channel - 1] + received.node,
        f"{communication}:02": AT_CHANGE,
        f"{communication}:05": received.timeout_ms,
        **dict(_mapping(0x1600 + pdo, received.words)),
    }


def _mapping(index: int, words: list[str]) -> Iterator[tuple[str, int]]:
    yield f"{index:04X}:00", len(words)
    for entry, word in enumerate(words, start=1):
        at, sub = locate(word)
        yield f"{index:04X}:{entry:02X}", at << 16 | sub << 8 | WORD_BITS
