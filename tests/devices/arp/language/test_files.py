"""The files of a program, and `fieldrig arp compile` (manual 5.2)."""

import json
import zlib
from pathlib import Path

import pytest
from arp_card import ArpBench, RecordedCard
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from fieldrig.errors import UsageError
from fieldrig_devices.arp.commands import app
from fieldrig_devices.arp.language import files
from fieldrig_devices.arp.language.compiler import compile_text
from fieldrig_devices.arp.language.files import ObjectError
from fieldrig_devices.arp.runtime.program import ArpProgram
from fieldrig_devices.languages.writer import Build

SOURCE = """\
; a counter
COUNT EQU V100
STEP  EQU 2
    beg Main
LOOP:
    count += step        ; in steps
    if count > 10, full
    goto LOOP
FULL:
    call Report
    end
BEG REPORT
    MSG 1, "FULL: ####.#"
    @PAR2[11] == (COUNT + 1) * -HFF / (V1 - (V2 - V3))
END
BEGA IRQ
ENDA
"""
GOOD = compile_text(SOURCE)
OBJECT = files.encode(GOOD, "counter", 7)


def with_crc(body: bytes) -> bytes:
    return body + f"CRC {zlib.crc32(body):08X}\n".encode()


def test_the_object_is_the_program_without_names_and_comments() -> None:
    expected = b"""\
ARP OBJECT 1 SYSTEM 07 NAME counter
4 BEG MAIN
5 LOOP:
6 V100 += 2
7 IF V100 > 10, FULL
8 GOTO LOOP
9 FULL:
10 CALL REPORT
11 END
12 BEG REPORT
13 MSG 1, "FULL: ####.#"
14 @PAR2[11] == (V100 + 1) * -H000000FF / (V1 - (V2 - V3))
15 END
16 BEGA IRQ
17 ENDA
"""
    assert with_crc(expected) == OBJECT


def test_an_object_is_loaded_as_the_same_program() -> None:
    loaded = files.decode(OBJECT)
    assert (loaded.name, loaded.system, loaded.compiled.program) == ("counter", 7, GOOD.program)
    ours, theirs = (
        ArpProgram(compiled, RecordedCard()).code.source(Build.FAST) for compiled in (GOOD, loaded.compiled)
    )
    assert ours == theirs


def test_a_loaded_program_breaks_at_the_lines_of_the_source() -> None:
    bench = ArpBench("BEG M\nEND")
    bench.program = ArpProgram(files.decode(OBJECT).compiled, bench.card)
    assert bench.program.break_at({10}) == {10}
    bench.run(5)
    assert (bench.program.place.line, bench.card.V[100]) == (10, 12_000)


def test_the_binary_object_is_the_ascii_one_compressed() -> None:
    data = files.binary(OBJECT, 7)
    assert data[:6].hex(" ") == "41 52 50 4f 01 07"  # "ARPO", version 1, system 7
    assert zlib.decompress(data[files.BINARY.size :]) == OBJECT


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (b"", "CRC"),
        (OBJECT[:-2], "CRC"),
        (OBJECT.replace(b"10", b"11", 1), "CRC"),
        (with_crc(b""), "no object of version 1"),
        (with_crc(b"ARP OBJECT 2 SYSTEM 07 NAME x\n1 BEG M\n2 END\n"), "no object of version 1"),
        (with_crc(b"ARP OBJECT 1 SYSTEM 07 NAME x\nBEG M\n2 END\n"), "no number"),
        (with_crc(b"ARP OBJECT 1 SYSTEM 07 NAME x\n1 BEG M\n2 V1 == __import__\n3 END\n"), "no program"),
        (with_crc(b"ARP OBJECT 1 SYSTEM 07 NAME x\n1 BEG M\n2 V1 == " + b"(" * 900 + b"\n3 END\n"), "no program"),
        (with_crc(b"\xff\xfe\n"), "no text"),
        (bytes(files.LARGEST_OBJECT + 1), "more than"),
    ],
)
def test_what_is_no_object_is_refused(data: bytes, what: str) -> None:
    with pytest.raises(ObjectError, match=what):
        files.decode(data)


@settings(max_examples=100, deadline=None)
@given(data=st.one_of(st.binary(), st.binary().map(with_crc)))
def test_any_bytes_are_an_object_or_refused(data: bytes) -> None:
    with pytest.raises(ObjectError):
        files.decode(data)


@settings(max_examples=100, deadline=None)
@given(place=st.integers(0, len(OBJECT) - 2), byte=st.integers(0, 255))
def test_a_damaged_object_is_refused(place: int, byte: int) -> None:
    damaged = OBJECT[:place] + bytes([byte]) + OBJECT[place + 1 :]
    if damaged != OBJECT:
        with pytest.raises(ObjectError):
            files.decode(damaged)


def test_map_and_symbols() -> None:
    assert files.map_text(GOOD).splitlines() == [
        "    4    11  main        MAIN",
        "    5        label       LOOP",
        "    9        label       FULL",
        "   12    15  subprogram  REPORT",
        "   16    17  interrupt   IRQ",
    ]
    assert files.symbols_text(GOOD).split() == [
        "COUNT", "V100", "FULL", "label", "of", "MAIN", "IRQ", "routine", "LOOP", "label", "of", "MAIN",
        "MAIN", "routine", "REPORT", "routine", "STEP", "2",
    ]  # fmt: skip


# ---- the command


def compile_file(path: Path, *options: str) -> tuple[int, str]:
    done = CliRunner().invoke(app, ["compile", str(path), *options])
    return done.exit_code, done.output


def written(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.manual("ARP-118")
def test_a_program_is_compiled_to_the_files_of_its_system(tmp_path: Path) -> None:
    source = tmp_path / "counter.I07"
    source.write_text(SOURCE)
    code, output = compile_file(source)
    assert (code, written(tmp_path)) == (0, [f"counter.{letter}07" for letter in "DEIMOS"])
    assert (tmp_path / "counter.D07").read_bytes() == OBJECT
    assert (tmp_path / "counter.E07").read_text() == "0 mistakes\n"
    assert f"written to {tmp_path}: counter.D07, counter.E07, counter.M07, counter.O07, counter.S07" in output


@pytest.mark.manual("ARP-118")
def test_mistakes_stand_in_their_file_and_take_old_objects_away(tmp_path: Path) -> None:
    source = tmp_path / "counter.I07"
    source.write_text(SOURCE)
    compile_file(source)
    source.write_text("BEG MAIN\nV1 = 5\nGOTO X\nEND\n")
    code, output = compile_file(source)
    assert (code, written(tmp_path)) == (2, ["counter.E07", "counter.I07"])
    expected = "2:4: values are assigned by ==, and = compares; expected =="
    assert (tmp_path / "counter.E07").read_text().splitlines()[0] == expected
    assert (tmp_path / "counter.E07").read_text().splitlines()[-1] == "2 mistakes"
    assert f"{source}:{expected}" in output


def test_a_source_of_another_name_needs_the_system_and_gets_its_copy(tmp_path: Path) -> None:
    source = tmp_path / "counter.txt"
    source.write_text(SOURCE)
    code, output = compile_file(source)
    assert code == 2
    assert "--system 0 to 99" in output
    out = tmp_path / "build"
    out.mkdir()
    assert compile_file(source, "--system", "12", "--out", str(out))[0] == 0
    assert written(out) == [f"counter.{letter}12" for letter in "DEIMOS"]


@pytest.mark.manual("ARP-118")
def test_a_program_for_one_system_is_not_compiled_for_another(tmp_path: Path) -> None:
    source = tmp_path / "counter.I07"
    source.write_text(SOURCE)
    code, output = compile_file(source, "--system", "8")
    assert code == 2
    assert "for system 07" in output


def test_a_file_that_is_not_there_is_said(tmp_path: Path) -> None:
    refused = CliRunner().invoke(app, ["compile", str(tmp_path / "none.I01")]).exception
    assert isinstance(refused, UsageError)
    assert "cannot be read" in str(refused)


def test_bytes_that_are_no_text_are_mistakes(tmp_path: Path) -> None:
    source = tmp_path / "bad.I01"
    source.write_bytes(b"BEG M\n\xff\x00 == 1\nEND\n")
    assert compile_file(source)[0] == 2


def test_check_lists_mistakes_with_their_places_and_writes_nothing(tmp_path: Path) -> None:
    right, wrong = tmp_path / "a.I01", tmp_path / "b.I01"
    right.write_text(SOURCE)
    wrong.write_text("BEG MAIN\nV1 = 2\nV2000 == 1\nEND\n")
    done = CliRunner().invoke(app, ["check", str(right)])
    assert (done.exit_code, done.stdout) == (0, f"{right} is right.\n")
    done = CliRunner().invoke(app, ["check", str(wrong)])
    assert done.exit_code == 2
    assert [line.partition(": ")[0] for line in done.stderr.splitlines()] == [f"{wrong}:2:4", f"{wrong}:3:1"]
    found = json.loads(CliRunner().invoke(app, ["check", str(wrong), "--json"]).stdout)
    assert [(one["file"], one["line"], one["column"], one["is_note"]) for one in found] == [
        (str(wrong), 2, 4, False),
        (str(wrong), 3, 1, False),
    ]
    assert sorted(tmp_path.iterdir()) == [right, wrong]
