"""EDS and DCF files that a node returns, compared with those from which it was made."""

from pathlib import Path
from typing import Any

import canopen
import pytest
from canopen_bench import IO32, LEVEL_SENSOR, CanopenBench
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.canopen.datatypes import DATA_TYPES, DOMAIN, Text
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.eds.check import Severity, check_eds
from fieldrig_devices.canopen.eds.reader import load
from fieldrig_devices.canopen.eds.source import EdsSource
from fieldrig_devices.canopen.eds.writer import write_dcf

OURS = [IO32, LEVEL_SENSOR]


def meaning(path: Path) -> dict[str, dict[str, str]]:
    """Return the values of a file by section and key, without what a DCF adds to the EDS.

    Order, the case of names, and `;` comments have no meaning (CiA 306-1 4.3).
    """
    sections = {
        name: {key: entry.value for key, entry in section.entries.items() if key not in ("parametervalue", "lasteds")}
        for name, section in EdsSource(path).sections.items()
    }
    sections.pop("devicecomissioning", None)
    return sections


def without_values(path: Path) -> str:
    """Return the DCF of a device that has no value to store."""
    return write_dcf(EdsSource(path), Dictionary([]), 5, "io")


def by_sdo(bench: CanopenBench, request: str) -> bytes:
    """Return all data of a segmented upload."""
    answer = bytes.fromhex(bench.sdo(request))
    size, data, toggle = int.from_bytes(answer[4:], "little"), b"", 0x60
    while len(data) < size:
        answer = bytes.fromhex(bench.sdo(f"{toggle:02x} 00 00 00 00 00 00 00"))
        data += answer[1 : 8 - (answer[0] >> 1 & 7)]
        toggle ^= 0x10
    return data


def test_eds_that_the_node_keeps_is_the_one_that_went_in(tmp_path: Path, bench: CanopenBench) -> None:
    """Object 1021h contains the file byte for byte, including comments."""
    data = by_sdo(bench, "40 21 10 00 00 00 00 00")
    assert data == IO32.read_bytes()
    assert bench.sdo("40 22 10 00 00 00 00 00") == "4f 22 10 00 00 00 00 00"


@pytest.mark.parametrize("path", OURS, ids=lambda path: path.name)
def test_file_that_is_written_means_the_same(path: Path, tmp_path: Path) -> None:
    """All sections, keys and values are equal, and canopen's reader finds the same objects in both files."""
    out = tmp_path / path.name
    out.write_text(without_values(path))
    assert meaning(out) == meaning(path)
    assert described(out) == described(path)


def described(path: Path) -> list[Any]:
    found = canopen.import_od(str(path), 5)
    return [
        (
            variable.index,
            variable.subindex,
            variable.name,
            variable.data_type,
            variable.access_type,
            variable.default,
            variable.min,
            variable.max,
        )
        for top in found.values()
        for variable in ([top] if isinstance(top, canopen.objectdictionary.ODVariable) else top.values())
    ]


def test_comments_order_and_case_carry_no_meaning(tmp_path: Path) -> None:
    first, other = tmp_path / "one.eds", tmp_path / "other.eds"
    first.write_text("[1000]\nDataType=7\nAccessType=ro\n[2000]\nDataType=5\n")
    other.write_text("; made by hand\n[2000]\ndatatype = 5 ; a byte\n\n[1000]\nACCESSTYPE=ro\nDataType=7\n")
    assert meaning(first) == meaning(other)
    other.write_text("[1000]\nDataType=7\nAccessType=ro\n[2000]\nDataType=6\n")
    assert meaning(first) != meaning(other)


@pytest.mark.long
def test_dcf_has_the_present_values_and_makes_the_same_node(tmp_path: Path, bench: CanopenBench) -> None:
    bench.write(
        "2b 17 10 00 64 00 00 00", "2f 02 62 01 ff 00 00 00", "2b 02 20 00 f6 ff 00 00", "23 00 18 01 90 01 00 c0"
    )
    bench.set("2000:00", "hall 7")
    path = tmp_path / "io.dcf"
    path.write_text(bench.node.dcf())
    assert "[DeviceComissioning]\nNodeID=0x5\nNodeName=io\n" in path.read_text()
    again = load(path, 5)
    for variable in bench.node.dictionary:
        if variable.access.is_writable and variable.index != 0x1003:
            assert again.find(variable.index, variable.subindex).start == variable.data, variable.key
    heartbeat = canopen.import_od(str(path), 5).get_variable(0x1017)
    assert heartbeat is not None
    assert heartbeat.value == 100
    assert [finding for finding in check_eds(path) if finding.severity is Severity.ERROR] == []


def test_dcf_without_its_values_means_the_eds(tmp_path: Path, bench: CanopenBench) -> None:
    path = tmp_path / "io.dcf"
    path.write_text(bench.node.dcf())
    assert meaning(path) == meaning(IO32)


TYPES = [number for number, data_type in DATA_TYPES.items() if data_type is not DOMAIN]


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(TYPES), st.binary(min_size=8, max_size=8)), min_size=1, max_size=8))
def test_values_that_are_written_are_read_as_the_same_bytes(
    tmp_path_factory: pytest.TempPathFactory, held: list[tuple[int, bytes]]
) -> None:
    """This holds for all data types; a text that doesn't fit on a line is omitted and reads as the default."""
    folder = tmp_path_factory.mktemp("eds")
    lines = "".join(
        f"[20{number:02X}]\nDataType={data_type:#x}\nAccessType=rw\n" for number, (data_type, _) in enumerate(held)
    )
    (folder / "in.eds").write_text(f"[1000]\nDataType=7\nAccessType=ro\n{lines}")
    node = CanopenBench(eds=folder / "in.eds").node
    for number, (data_type, data) in enumerate(held):
        size = DATA_TYPES[data_type].size
        node.dictionary.find(0x2000 + number, 0).set(b"\x01" if size == 1 and data_type == 1 else data[: size or 8])
    (folder / "out.dcf").write_text(node.dcf(), encoding="utf-8")
    again = load(folder / "out.dcf", 5)
    for number, (data_type, _) in enumerate(held):
        variable = node.dictionary.find(0x2000 + number, 0)
        is_text = isinstance(DATA_TYPES[data_type], Text)
        found = again.find(variable.index, 0).start
        assert found == variable.data or (is_text and found == b""), variable.key


@given(st.binary(max_size=12))
def test_visible_string_keeps_every_sequence_of_bytes(data: bytes) -> None:
    visible = DATA_TYPES[0x09]
    assert visible.encode(visible.decode(data)) == data


texts = st.text(
    st.characters(exclude_categories=["C"], exclude_characters="=;[]\x85\u2028\u2029"), min_size=1, max_size=12
)


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(st.dictionaries(texts.map(str.strip).filter(bool), st.dictionaries(texts.map(str.strip).filter(bool), texts)))
def test_whatever_was_read_is_written_alike(tmp_path_factory: pytest.TempPathFactory, content: Any) -> None:
    path = tmp_path_factory.mktemp("eds") / "any.eds"
    lines = [
        f"[{name}]\n" + "".join(f"{key}={value}\n" for key, value in section.items())
        for name, section in content.items()
    ]
    path.write_text("".join(lines), encoding="utf-8")
    first = meaning(path)
    path.write_text(without_values(path), encoding="utf-8")
    assert meaning(path) == first
