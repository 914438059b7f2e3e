"""Sources of IEC programs as they are on old disks: with the end of a text of DOS, and in its code page."""

from pathlib import Path

import pytest
from exchange_documents import pou, tc6
from iec_program import IecBench, program, refused

from fieldrig.clock import VirtualClock
from fieldrig_devices.iec.commands.sources import read_sources
from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.dialect import CODESYS, EPAS_4
from fieldrig_devices.iec.standalone import StandaloneHost

BODY = "s := 'Höhe über Null';"
TEXT = program("s : STRING;", BODY)
EXPORT = f"(* @NESTEDCOMMENTS := 'No' *)\n{TEXT}\n"
LD = program("x : INT;", "LD 1\nST x")


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("a.st", TEXT.replace("\n", "\r\n").encode("cp850") + b"\x1a"),
        ("a.ST", TEXT.replace("\n", "\r\n").encode("cp1252") + b"\x1a\x1a\0\0"),
        ("a.EXP", EXPORT.replace("\n", "\r\n").encode("cp850") + b"\r\n\x1a"),
        ("a.il", LD.replace("\n", "\r\n").encode() + b"\x1a"),
        ("a.xml", tc6(pou("<ST><p>;</p></ST>")).encode() + b"\x1a\x1a"),
    ],
)
def test_an_old_file_compiles(tmp_path: Path, name: str, data: bytes) -> None:
    (tmp_path / name).write_bytes(data)
    files = read_sources([tmp_path])
    compiled = compile_project(files, StandaloneHost(VirtualClock()))
    assert [found.name for found in compiled.files] == [str(tmp_path / name)]
    if not name.endswith((".il", ".xml")):
        assert BODY in files[0].text


def test_the_word_functionblock_of_an_export_of_v23_is_one_word() -> None:
    text = "FUNCTIONBLOCK Twice VAR_INPUT n : INT; END_VAR VAR_OUTPUT q : INT; END_VAR q := 2 * n; END_FUNCTION_BLOCK\n"
    bench = IecBench(text + program("t : Twice;", "t(n := 4);"), CODESYS)
    bench.cycle()
    assert bench["t.q"] == 8
    assert any("got FUNCTIONBLOCK" in message for message in refused(text + program("t : Twice;", ""), EPAS_4))
