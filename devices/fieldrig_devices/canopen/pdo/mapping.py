"""PDO mapping: the mapping parameter, the procedure to change it, and the packing of variables into bytes.

Source: CiA 301 7.5.2.36 (1600h) and 7.5.2.38 (1A00h).
"""

import logging
from collections.abc import Callable, Sequence
from enum import Enum, auto
from typing import NamedTuple

from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.variable import Variable

log = logging.getLogger(__name__)

MAX_BITS = 64
MAX_ENTRIES = 64


class Direction(Enum):
    RECEIVE = "RPDO"
    TRANSMIT = "TPDO"


class Mode(Enum):
    """Meaning of sub-index 0 of a mapping parameter."""

    MAPPED = auto()
    SOURCE = 254
    """Multiplexed PDO in source address mode (254) or destination address mode (255)."""
    DESTINATION = 255


class Part(NamedTuple):
    """A mapped variable, or None for a dummy, and its length in bits."""

    variable: Variable | None
    bits: int


Pack = Callable[[], bytes]
Unpack = Callable[[bytes], None]


class Mapping:
    """The mapping parameter at `index`.

    The network changes it only by the procedure: make the PDO invalid (`is_valid`), set sub-index 0 to 0, write the
    entries, then sub-index 0.  An access out of this order is refused with 0601 0000h, as the object doesn't support it
    at present: 0604 0041h would blame the mapped object, and 0800 0000h says nothing.  CiA's tool accepts these three,
    but not 0800 0022h.  Some nodes let the PDO stay valid meanwhile (`Features.maps_while_valid`).  `parts` is the
    present mapping.
    """

    def __init__(self, dictionary: Dictionary, index: int, direction: Direction, is_valid: Callable[[], bool]) -> None:
        self._dictionary, self._direction, self._is_valid = dictionary, direction, is_valid
        self._count, self._entries = dictionary.get(index), dictionary.members(index)
        self.name = f"{direction.value} mapping {index:04X}h"
        self.parts: list[Part] = []
        self.mode = Mode.MAPPED
        self.on_change: Callable[[], None] = lambda: None
        """Called when a valid PDO has another mapping."""
        self._most = min(MAX_ENTRIES, len(self._entries))
        if self._count is not None:
            self._most = min(self._most, int(self._count.high or MAX_ENTRIES))
            self._count.low = self._count.high = None  # this class refuses it as too long for the PDO, not as too high
            self._count.writer = self._on_count_written
        for entry in self._entries:
            entry.writer = self._entry_writer(entry)

    @property
    def size(self) -> int:
        """Length of the PDO in bytes."""
        return (sum(part.bits for part in self.parts) + 7) // 8

    @property
    def has_command(self) -> bool:
        return any(part.variable is not None and part.variable.is_command for part in self.parts)

    def reset(self) -> None:
        """Take the mapping from the dictionary; an impossible mapping of the EDS leaves the PDO empty."""
        count = 0 if self._count is None else self._count.number
        self.mode = self._mode(count)
        try:
            self.parts = self._resolve_all(count)
        except Abort as abort:
            self.parts, self.mode = [], Mode.MAPPED
            log.warning("the EDS has an impossible %s (%s); the PDO stays empty", self.name, abort)

    def packer(self) -> Pack:
        return make_packer(self.parts)

    def unpacker(self) -> Unpack:
        return make_unpacker(self.parts)

    def _entry_writer(self, entry: Variable) -> Callable[[bytes], None]:
        def write(data: bytes) -> None:
            if self._is_locked() or (self._count is not None and self._count.number != 0):
                raise Abort(Code.UNSUPPORTED_ACCESS)
            number = int.from_bytes(data, "little")
            if number != 0:
                self._resolve(number)
            entry.set(data)

        return write

    def _on_count_written(self, data: bytes) -> None:
        assert self._count is not None
        if self._is_locked() and data != self._count.data:
            raise Abort(Code.UNSUPPORTED_ACCESS)
        self.parts, self.mode = self._resolve_all(data[0]), self._mode(data[0])
        self._count.set(data)
        if self._is_valid() and self._dictionary.features.maps_while_valid:
            self.on_change()

    def _is_locked(self) -> bool:
        return self._is_valid() and not self._dictionary.features.maps_while_valid

    def _mode(self, count: int) -> Mode:
        is_multiplexed = self._dictionary.features.has_mpdo and count in (Mode.SOURCE.value, Mode.DESTINATION.value)
        return Mode(count) if is_multiplexed else Mode.MAPPED

    def _resolve_all(self, count: int) -> list[Part]:
        mode = self._mode(count)
        if mode is not Mode.MAPPED:  # only a destination-addressed TPDO has a mapped variable
            has_variable = mode is Mode.DESTINATION and self._direction is Direction.TRANSMIT
            return [self._resolve(entry.number) for entry in self._entries[:1]] if has_variable else []
        if count > self._most:
            raise Abort(Code.PDO_LENGTH_EXCEEDED)
        parts = [self._resolve(entry.number) for entry in self._entries[:count]]
        if sum(part.bits for part in parts) > MAX_BITS:
            raise Abort(Code.PDO_LENGTH_EXCEEDED)
        return parts

    def _resolve(self, number: int) -> Part:
        """Return the part for an entry: index, sub-index and length.  Raises Abort if it cannot be mapped."""
        index, subindex, bits = number >> 16, number >> 8 & 0xFF, number & 0xFF
        if index in self._dictionary.dummies and subindex == 0:
            if self._direction is Direction.RECEIVE and bits == self._dictionary.dummies[index]:
                return Part(None, bits)
            raise Abort(Code.NOT_MAPPABLE)
        if index not in self._dictionary:
            raise Abort(Code.NO_OBJECT)
        variable = self._dictionary.get(index, subindex)
        if variable is None or not self._may_carry(variable) or not _has_length(variable, bits):
            raise Abort(Code.NOT_MAPPABLE)
        return Part(variable, bits)

    def _may_carry(self, variable: Variable) -> bool:
        access = variable.access
        is_allowed = access.is_received if self._direction is Direction.RECEIVE else access.is_transmitted
        return variable.is_mappable and is_allowed


def _has_length(variable: Variable, bits: int) -> bool:
    """True if `bits` is a valid length: a BOOLEAN may also take a byte, as in many EDS files; a string any bytes."""
    if variable.type.bits is None:
        return 0 < bits <= MAX_BITS and bits % 8 == 0
    return bits in (variable.type.bits, (variable.type.size or 0) * 8)


def make_packer(parts: Sequence[Part]) -> Pack:
    """Return a function that returns the bytes of a TPDO."""
    variables = [part.variable for part in parts if part.variable is not None]
    if not all(_is_whole(part) for part in parts):
        return lambda: _pack_bits(parts)
    if len(variables) == 1:
        only = variables[0]
        return lambda: only.data
    return lambda: b"".join([variable.data for variable in variables])


def make_unpacker(parts: Sequence[Part]) -> Unpack:
    """Return a function that writes the bytes of an RPDO into the variables; the bytes must suffice."""
    if not all(part.bits % 8 == 0 for part in parts):
        return lambda data: _unpack_bits(parts, data)
    slices: list[tuple[Unpack, int, int]] = []
    commands: list[tuple[Unpack, int, int]] = []
    first = 0
    for variable, bits in parts:
        if variable is not None:
            (commands if variable.is_command else slices).append((_setter(variable), first, first + bits // 8))
        first += bits // 8
    slices += commands

    def unpack(data: bytes) -> None:
        for put, first, end in slices:
            put(data[first:end])

    return unpack


def _is_whole(part: Part) -> bool:
    """True if the PDO contains exactly the bytes of the variable."""
    return (
        part.variable is not None and part.variable.type.size is not None and part.bits == part.variable.type.size * 8
    )


def _pack_bits(parts: Sequence[Part]) -> bytes:
    number = position = 0
    for variable, bits in parts:
        if variable is not None:
            number |= (int.from_bytes(variable.data, "little") & (1 << bits) - 1) << position
        position += bits
    return number.to_bytes((position + 7) // 8, "little")


def _unpack_bits(parts: Sequence[Part], data: bytes) -> None:
    number = int.from_bytes(data, "little")
    written: list[tuple[Variable, bytes]] = []
    for variable, bits in parts:
        if variable is not None:
            value = number & (1 << bits) - 1
            written.append((variable, value.to_bytes(variable.type.size or bits // 8, "little")))
        number >>= bits
    for variable, part in sorted(written, key=lambda pair: pair[0].is_command):
        _setter(variable)(part)


def _setter(variable: Variable) -> Callable[[bytes], None]:
    """Return the function by which an RPDO writes the variable; a value that it refuses is dropped."""
    if variable.is_plain:
        return variable.set

    def put(data: bytes) -> None:
        try:
            variable.write(data)
        except Abort as abort:
            log.debug("%s refuses %s from an RPDO: %s", variable.key, data.hex(" "), abort)

    return put
