"""MF4 files of other tools: frames as a structure or as single channels, with fewer fields than ours.

The files are written by asammdf; field names and their meaning are those of ASAM's standard for bus logging.
"""

from pathlib import Path
from typing import Any

import can  # noqa: F401  before asammdf, or its reader of MF4 does not work
import numpy
import pytest
from asammdf import MDF, Signal

from fieldrig.traces.trace_files import read
from fieldrig_bus.can.codec import decode
from fieldrig_bus.can.frame import CanFrame

pytestmark = pytest.mark.long

FRAMES = [
    CanFrame(0x181, b"\x01\x02\x00"),
    CanFrame(0x1234_5678, b"12345678", is_extended=True),
    CanFrame(0x7FF, b""),
    CanFrame(0x601, bytes(12), is_fd=True),
]
ALL = ("BusChannel", "ID", "IDE", "DLC", "DataLength", "DataBytes", "EDL")
CODES = {12: 9}


def columns(name: str, fields: tuple[str, ...], width: int = 12) -> dict[str, Any]:
    """The values of these fields as arrays."""
    data = [list(frame.data.ljust(width, b"\0")) for frame in FRAMES]
    values: dict[str, Any] = {
        "BusChannel": numpy.ones(len(FRAMES), "u1"),
        "ID": numpy.array([frame.identifier for frame in FRAMES], "<u4"),
        "IDE": numpy.array([frame.is_extended for frame in FRAMES], "u1"),
        "DLC": numpy.array([CODES.get(len(frame.data), len(frame.data)) for frame in FRAMES], "u1"),
        "DataLength": numpy.array([len(frame.data) for frame in FRAMES], "u1"),
        "DataBytes": numpy.array(data, "u1"),
        "EDL": numpy.array([frame.is_fd for frame in FRAMES], "u1"),
    }
    return {f"{name}.{field}": values[field] for field in fields}


def structure(path: Path, fields: tuple[str, ...], name: str = "CAN_DataFrame") -> Path:
    parts = columns(name, fields)
    table = numpy.zeros(len(FRAMES), [(key, part.dtype, part.shape[1:]) for key, part in parts.items()])
    for key, part in parts.items():
        table[key] = part
    with MDF(version="4.10") as mdf:
        mdf.append(Signal(samples=table, timestamps=numpy.arange(len(FRAMES)) / 10, name=name))
        mdf.save(path)
    return path


def single(path: Path, fields: tuple[str, ...]) -> Path:
    times = numpy.arange(len(FRAMES)) / 10
    with MDF(version="4.10") as mdf:
        mdf.append([Signal(part, times, name=key) for key, part in columns("CAN_DataFrame", fields).items()])
        mdf.save(path)
    return path


def frames(path: Path) -> list[Any]:
    return [decode(entry.data) for entry in read(path)]


@pytest.mark.parametrize("left_out", [(), ("DataLength",), ("DLC",), ("IDE",), ("IDE", "DataLength"), ("EDL",)])
@pytest.mark.parametrize("layout", [structure, single])
def test_fields_that_are_left_out_follow_from_others(layout: Any, left_out: tuple[str, ...], tmp_path: Path) -> None:
    fields = tuple(field for field in ALL if field not in left_out)
    assert frames(layout(tmp_path / "x.mf4", fields)) == FRAMES


@pytest.mark.parametrize("layout", [structure, single])
def test_the_channel_names_the_bus(layout: Any, tmp_path: Path) -> None:
    assert {entry.bus for entry in read(layout(tmp_path / "x.mf4", ALL))} == {"can1"}
    assert {entry.bus for entry in read(layout(tmp_path / "y.mf4", ALL[1:]))} == {"can0"}


def test_data_of_any_length_is_read_as_it_is(tmp_path: Path) -> None:
    times = numpy.arange(len(FRAMES)) / 10
    parts = columns("CAN_DataFrame", ("ID", "DLC"))
    texts = numpy.array([frame.data for frame in FRAMES], "S12")
    with MDF(version="4.10") as mdf:
        signals = [Signal(part, times, name=key) for key, part in parts.items()]
        mdf.append([*signals, Signal(texts, times, name="CAN_DataFrame.DataBytes", encoding="latin-1")])
        mdf.save(tmp_path / "x.mf4")
    assert frames(tmp_path / "x.mf4") == FRAMES


def test_a_remote_frame_has_the_length_that_it_asks_for(tmp_path: Path) -> None:
    asked = [
        frame.remote_length for frame in frames(structure(tmp_path / "x.mf4", ("ID", "DataLength"), "CAN_RemoteFrame"))
    ]
    assert asked[:3] == [3, 8, 0]
