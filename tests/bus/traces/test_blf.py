"""BLF files that are damaged: cut, with lengths that lie, with containers that unpack to gigabytes.

They are made from a file of python-can.
"""

import struct
import tracemalloc
import zlib
from pathlib import Path

import can
import can.io.blf
import pytest
from can.io.blf import BLFWriter

from fieldrig.errors import UsageError
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace_files import read
from fieldrig_bus.can.codec import decode
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.traces import blf_objects


@pytest.mark.parametrize("name", [name for name in vars(blf_objects) if name in vars(can.io.blf) and name.isupper()])
def test_the_layouts_are_those_of_python_can(name: str) -> None:
    ours, theirs = getattr(blf_objects, name), getattr(can.io.blf, name)
    assert getattr(ours, "format", ours) == getattr(theirs, "format", theirs)


def blf_file(path: Path) -> bytes:
    """Two containers of python-can, in which an object begins in one and ends in the other."""
    with BLFWriter(path, max_container_size=200) as writer:
        for number in range(8):
            writer.on_message_received(can.Message(1_700_000_000 + number, 0x100 + number, False, data=[number]))
    return path.read_bytes()


@pytest.mark.long
def test_a_cut_blf_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    path = tmp_path / "x.blf"
    data = blf_file(path)
    for size in range(len(data)):
        path.write_bytes(data[:size])
        odd = Oddities()
        try:
            found = [decode(one.data) for one in read(path, odd=odd)]
        except UsageError:
            assert size < data.index(b"LOBJ", 150)  # the end of the first container
            continue
        assert found == [CanFrame(0x100 + number, bytes([number])) for number in range(len(found))]
        assert len(odd) or len(found) in (0, 4, 8)


LYING = [0, 1, 15, 16, 17, 0x7FFF_FFFF, 0xFFFF_FFFF]


@pytest.mark.parametrize("size", LYING)
def test_an_object_with_a_lying_length_loses_only_itself(size: int, tmp_path: Path) -> None:
    path = tmp_path / "x.blf"
    data = bytearray(blf_file(path))
    first = data.index(b"LOBJ")
    struct.pack_into("<L", data, first + 8, size)
    path.write_bytes(data)
    odd = Oddities()
    found = list(read(path, odd=odd))
    assert 3 <= len(found) < 8
    assert len(odd)


@pytest.mark.long
def test_a_container_that_unpacks_to_gigabytes_takes_no_memory(tmp_path: Path) -> None:
    path = tmp_path / "x.blf"
    squeeze = zlib.compressobj(9)
    packed = b"".join(squeeze.compress(bytes(1 << 20)) for _ in range(40)) + squeeze.flush()
    head = struct.pack("<4sHHLLH6xL4x", b"LOBJ", 16, 1, 32 + len(packed), 10, 2, 40 << 20)
    path.write_bytes(blf_file(path)[:144] + head + packed)
    tracemalloc.start()
    with pytest.raises(UsageError, match="bytes that are no objects are skipped"):
        list(read(path))
    assert tracemalloc.get_traced_memory()[1] < 20 << 20
    tracemalloc.stop()
