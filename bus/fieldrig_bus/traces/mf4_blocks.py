"""The blocks of an MF4 file, checked before asammdf reads it, which allocates and repeats what they claim.

Source: ASAM MDF 4.1, as the tables of asammdf (`blocks/v4_constants`) have it.  A file is a tree of blocks that lead to
each other by their place.  Damaged ones made asammdf take 1.4 GB, or read without an end.
"""

import struct
import zlib
from collections.abc import Callable, Iterator, Mapping
from typing import BinaryIO, Final, NamedTuple

HEAD: Final = struct.Struct("<4s4xQQ")
"""Kind, length, number of links."""
FIRST: Final = 64
"""The place of the header block, behind the identification of the file."""
MOST_BLOCKS: Final = 1_000_000
MOST_LINKS: Final = 1 << 20
LARGEST_PACKED: Final = 1 << 26
"""Bytes in a block of compressed data, at most; the standard recommends 4 MB."""
DEEPEST_RATIO: Final = 1032
"""Bytes that one byte of Deflate stands for, at most."""
UNFINISHED: Final = b"UnFinMF "
_PACKED: Final = struct.Struct("<2sBxLQQ")
"""Kind of the original block, kind of compression, parameter, length of the original, length here."""
_GROUP: Final = struct.Struct("<QQHHxxxxLL")
"""Number, records, flags, separator, bytes of a record, bytes of it for invalidation."""
_CHANNEL: Final = struct.Struct("<BBBBLL")
"""Kind, synchronisation, type of data, first bit, first byte, bits."""
_VARIABLE: Final = 1
"""The flag of a group whose records have a length each."""
_LENGTH_SIZE: Final = 4
_LENGTHS: Final = {b"##HD": {(104, 6)}, b"##DG": {(64, 4)}, b"##CG": {(104, 6), (112, 7)}}
"""Length and number of links, where they say how the rest of a block is laid out."""
_DATA: Final = frozenset({b"##DT", b"##DV", b"##DI", b"##SD", b"##RD", b"##DZ"})
_OWNED: Final[Mapping[bytes, Callable[[list[int]], list[int]]]] = {
    b"##HD": lambda links: links[:1],
    b"##DG": lambda links: links[:3],
    b"##CG": lambda links: links[:2],
    b"##CN": lambda links: links[:2],
    b"##HL": lambda links: links[:1],
    b"##DL": lambda links: links,
}
"""The links to a block that is a part of no other one."""


class Block(NamedTuple):
    at: int
    kind: bytes
    length: int
    links: list[int]
    body: bytes
    """The bytes after the links, of a block that has no data."""

    def __str__(self) -> str:
        return f"the block {self.kind.decode('latin-1')!r} at byte {self.at}"


def check(file: BinaryIO) -> None:
    """Read the lengths of all blocks.  ValueError, with the place, for one that is not true."""
    size, is_unfinished = file.seek(0, 2), False
    file.seek(0)
    is_unfinished = file.read(8) == UNFINISHED
    blocks = dict[int, Block]()
    for block in _reached(file, size, is_unfinished):
        blocks[block.at] = block
        if block.kind == b"##DZ":
            _check_packed(file, block)
    for block in blocks.values():
        if block.kind == b"##DG":
            _check_records(block, blocks)


def _reached(file: BinaryIO, size: int, is_unfinished: bool) -> Iterator[Block]:
    """Yield each block that a link leads to, once."""
    waiting, known, owned = [FIRST], {FIRST}, {FIRST}
    while waiting:
        block = _block(file, waiting.pop(), size, is_unfinished)
        yield block
        of_kind = _OWNED.get(block.kind)
        for target in of_kind(block.links) if of_kind is not None else ():
            if target and target in owned:
                raise ValueError(f"{block} leads to byte {target}, which is a part of another one")
            owned.add(target)
        new = {target for target in block.links if target} - known
        known |= new
        waiting += new
        if len(known) > MOST_BLOCKS:
            raise ValueError(f"there are more than {MOST_BLOCKS:,} blocks")


def _block(file: BinaryIO, at: int, size: int, is_unfinished: bool) -> Block:
    if at > size - HEAD.size:
        raise ValueError(f"a block is said to be at byte {at}, and the file has {size} bytes")
    file.seek(at)
    kind, length, links = HEAD.unpack(file.read(HEAD.size))
    block = Block(at, kind, length, [], b"")
    is_data = kind in _DATA
    if kind[:2] != b"##":
        raise ValueError(f"there is no block at byte {at}")
    if length < HEAD.size + 8 * links or (length > size - at and not (is_data and is_unfinished)):
        raise ValueError(f"{block} claims to have {length} bytes and {links} links")
    if (known := _LENGTHS.get(kind)) is not None and (length, links) not in known:
        raise ValueError(f"{block} claims to have {length} bytes and {links} links, which it never has")
    if links > MOST_LINKS:
        raise ValueError(f"{block} claims to have {links} links")
    targets = list(struct.unpack(f"<{links}Q", file.read(8 * links)))
    return block._replace(links=targets, body=b"" if is_data else file.read(min(length - HEAD.size - 8 * links, 64)))


def _check_packed(file: BinaryIO, block: Block) -> None:
    file.seek(block.at + HEAD.size)
    data = file.read(_PACKED.size)
    if len(data) < _PACKED.size:
        raise ValueError(f"{block} is cut off")
    *_, original, packed = _PACKED.unpack(data)
    if original > LARGEST_PACKED or packed > block.length - HEAD.size - _PACKED.size:
        raise ValueError(f"{block} claims to have {packed} bytes for {original}")
    if packed * DEEPEST_RATIO <= LARGEST_PACKED:
        return
    inflate, rest, count = zlib.decompressobj(), file.read(packed), 0
    try:
        while rest and not inflate.eof and count <= original:
            count += len(inflate.decompress(rest, 1 << 20))
            rest = inflate.unconsumed_tail
    except zlib.error as wrong:
        raise ValueError(f"{block}: {wrong}") from wrong
    if count > original:
        raise ValueError(f"{block} has more than the {original} bytes that it claims")


def _check_records(group: Block, blocks: Mapping[int, Block]) -> None:
    """Check the records and channels of the groups that share the data of one block."""
    if len(group.links) < 3 or not group.body:
        raise ValueError(f"{group} is too short")
    present, needed, at = _data_bytes(blocks, group.links[2]), 0, group.links[1]
    while (records := blocks.get(at)) is not None:
        if len(records.body) < _GROUP.size or len(records.links) < 2:
            raise ValueError(f"{records} is too short")
        _, count, flags, _, size, more = _GROUP.unpack_from(records.body)
        is_variable = bool(flags & _VARIABLE)
        shortest = _LENGTH_SIZE if is_variable else size + more
        if is_variable and records.links[1]:
            raise ValueError(f"{records} has records with a length each, and channels, which it never has")
        needed += count * (shortest + group.body[0])
        _check_channels(records.links[1], shortest, blocks)
        if needed > present and present >= 0:
            raise ValueError(f"{records} claims to have {count} records of {shortest} bytes, and there are {present}")
        at = records.links[0]


def _check_channels(first: int, record: int, blocks: Mapping[int, Block]) -> None:
    waiting = [first]
    while waiting:
        channel = blocks.get(waiting.pop())
        if channel is None or channel.kind != b"##CN":
            continue
        if len(channel.body) < _CHANNEL.size or len(channel.links) < 2:
            raise ValueError(f"{channel} is too short")
        *_, first_bit, first_byte, bits = _CHANNEL.unpack_from(channel.body)
        if first_byte + (first_bit + bits + 7) // 8 > record:
            raise ValueError(
                f"{channel} claims to have {bits} bits at byte {first_byte}, and a record has {record} bytes"
            )
        waiting += channel.links[:2]


def _data_bytes(blocks: Mapping[int, Block], at: int) -> int:
    """Return the bytes of the data that a block stands for; -1 if they cannot be known."""
    total, waiting = 0, [at]
    while waiting:
        block = blocks.get(waiting.pop())
        if block is None:
            continue
        if block.kind in (b"##DL", b"##HL"):
            waiting += block.links
        elif block.kind == b"##DZ":
            total += LARGEST_PACKED
        elif block.kind in _DATA:
            total += block.length - HEAD.size
        else:
            return -1
    return total
