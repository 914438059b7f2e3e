"""Sources and objects as they are on old disks: with the end of a text of DOS, and in its code page."""

from pathlib import Path

import arp_listings
import pytest

from fieldrig.errors import ConfigError
from fieldrig.text import source_text
from fieldrig_devices.arp import debug_sources
from fieldrig_devices.arp.language.program_file import read_program
from fieldrig_devices.arp.user_port import listing

PLAIN = f"{arp_listings.EXEMPLE1}; Höhe über Null\n"
OLD = [
    PLAIN.encode(),
    PLAIN.replace("\n", "\r\n").encode() + b"\x1a",
    PLAIN.replace("\n", "\r\n").encode("cp850") + b"\x1a\x1a\x1a\0",
    PLAIN.encode("cp1252"),
]


@pytest.mark.parametrize("data", OLD, ids=["today", "DOS", "850", "1252"])
def test_an_old_source_gives_the_same_object_and_the_same_text(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "EXEMPLE1.I07"
    path.write_bytes(data)
    found = read_program(path, 7)
    path.write_text(PLAIN)
    assert found == read_program(path, 7)
    path.write_bytes(data)
    source = debug_sources.of_file(path)
    assert source is not None
    assert source.text == PLAIN
    assert list(listing.of_source(path).lines.values()) == PLAIN.splitlines()


def test_an_object_has_the_end_of_a_text_of_dos_behind_it(tmp_path: Path) -> None:
    path = tmp_path / "EXEMPLE1.I07"
    path.write_text(PLAIN)
    data = read_program(path, 7)
    path = tmp_path / "EXEMPLE1.D07"
    path.write_bytes(data + b"\x1a\x1a")
    assert read_program(path, 7) == data


def test_a_source_that_is_too_long_is_refused_with_its_length(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(source_text, "LONGEST", 10)
    path = tmp_path / "EXEMPLE1.I07"
    path.write_text(PLAIN)
    with pytest.raises(ConfigError, match="too long for a source file"):
        read_program(path, 7)
