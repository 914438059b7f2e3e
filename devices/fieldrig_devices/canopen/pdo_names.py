"""PDOs by name: which PDO of which node a frame is, and the values of the objects that are mapped into it.

Source: CiA 301 version 4.2, 7.5.2.35 to 7.5.2.38 (communication and mapping parameters).
"""

from collections.abc import Iterator, Mapping
from typing import Any, Final, NamedTuple

from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.cob_id import EXTENDED, is_valid
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.sdo_names import value_words

RPDO, TPDO = 0x1400, 0x1800
TO_MAPPING: Final = 0x200
"""Distance of the index of the mapping parameter from that of the communication parameter."""
MOST: Final = 512
MOST_MAPPED: Final = 64
MOST_TEXTS: Final = 1_024
PARAMETERS: Final = range(0x1400, 0x1C00)


class _Pdo(NamedTuple):
    node_id: int
    kind: str
    mapping: int
    """The index of the mapping parameter."""


class PdoNames:
    """Names the PDOs of a bus."""

    def __init__(self, dictionaries: Mapping[int, Dictionary]) -> None:
        self._dictionaries = dictionaries
        self._written: dict[tuple[int, int, int], int] = {}
        """Numbers that were written into parameters, by node-ID, index and sub-index."""
        self._by_identifier = self._found()
        self._texts: dict[tuple[int, bytes], str] = {}
        """Contents that were named before, as most PDOs repeat theirs, by identifier and data."""

    def note(self, node_id: int, index: int, subindex: int, number: int) -> None:
        """Take into account that a parameter of a node has another number now."""
        if index in PARAMETERS and node_id in self._dictionaries:
            self._written[node_id, index, subindex] = number
            self._by_identifier = self._found()
            self._texts.clear()

    def parameters(self) -> dict[int, list[str]]:
        """Return the keys of all parameters of PDOs, by node-ID."""
        return {
            node_id: [variable.key for variable in dictionary if variable.index in PARAMETERS]
            for node_id, dictionary in self._dictionaries.items()
        }

    def learn(self, node_id: int, values: Mapping[str, Any]) -> None:
        """Take the present numbers of parameters, by key."""
        for key, number in values.items():
            index, _, subindex = key.partition(":")
            if isinstance(number, int):
                self._written.setdefault((node_id, int(index, 16), int(subindex, 16)), number)
        self._by_identifier = self._found()
        self._texts.clear()

    def named(self, frame: CanFrame) -> tuple[int, str, str] | None:
        """Return node-ID, name and content of a PDO; None for any other frame."""
        pdo = self._by_identifier.get(frame.identifier)
        if pdo is None:
            return None
        if frame.is_remote:
            return pdo.node_id, f"{pdo.kind} request", ""
        key = (frame.identifier, frame.data)
        text = self._texts.get(key)
        if text is None:
            if len(self._texts) >= MOST_TEXTS:
                self._texts.clear()
            text = self._texts[key] = self._content(pdo, frame.data)
        return pdo.node_id, pdo.kind, text

    def values(self, frame: CanFrame) -> tuple[int, str, list[tuple[int, int, bytes]]] | None:
        """Return node-ID, name, and the mapped objects with their data; None for a frame that is no PDO."""
        pdo = self._by_identifier.get(frame.identifier)
        if pdo is None or frame.is_remote:
            return None
        bits, at, found = int.from_bytes(frame.data, "little"), 0, []
        for index, subindex, length in self._mapped(pdo):
            if at + length > 8 * len(frame.data):
                break
            found.append((index, subindex, (bits >> at & (1 << length) - 1).to_bytes((length + 7) // 8, "little")))
            at += length
        return pdo.node_id, pdo.kind, found

    def producer_of(self, identifier: int) -> int | None:
        """Return the node-ID of the node that sends this TPDO; None if it is none of a known node."""
        pdo = self._by_identifier.get(identifier)
        return pdo.node_id if pdo is not None and pdo.kind.startswith("TPDO") else None

    def _found(self) -> dict[int, _Pdo]:
        """Return the PDOs by their identifiers; where a producer and a consumer share one, the producer."""
        found: dict[int, _Pdo] = {}
        for first, word in ((TPDO, "TPDO"), (RPDO, "RPDO")):
            for node_id, dictionary in self._dictionaries.items():
                for index in dictionary.indices(first, first + MOST - 1):
                    cob_id = self._number(node_id, index, 1)
                    if is_valid(cob_id) and not cob_id & EXTENDED and cob_id & 0x7FF:
                        pdo = _Pdo(node_id, f"{word} {index - first + 1}", index + TO_MAPPING)
                        found.setdefault(cob_id & 0x7FF, pdo)
        return found

    def _number(self, node_id: int, index: int, subindex: int) -> int:
        written = self._written.get((node_id, index, subindex))
        return self._dictionaries[node_id].number(index, subindex) if written is None else written

    def _content(self, pdo: _Pdo, data: bytes) -> str:
        bits, at, words = int.from_bytes(data, "little"), 0, []
        dictionary = self._dictionaries[pdo.node_id]
        for index, subindex, length in self._mapped(pdo):
            if at + length > 8 * len(data):
                words.append("too short for its mapping")
                break
            part = (bits >> at & (1 << length) - 1).to_bytes((length + 7) // 8, "little")
            at += length
            variable = dictionary.get(index, subindex)
            if variable is not None:  # the others are dummies, which nothing means
                words.append(f"{variable.name} {value_words(dictionary, index, subindex, part)}")
        return ", ".join(words) if words else data.hex(" ").upper()

    def _mapped(self, pdo: _Pdo) -> Iterator[tuple[int, int, int]]:
        """Yield index, sub-index and length in bits of what is mapped."""
        count = self._number(pdo.node_id, pdo.mapping, 0)
        for subindex in range(1, count + 1 if count <= MOST_MAPPED else 1):  # above are multiplexed PDOs
            entry = self._number(pdo.node_id, pdo.mapping, subindex)
            yield entry >> 16, entry >> 8 & 0xFF, entry & 0xFF
