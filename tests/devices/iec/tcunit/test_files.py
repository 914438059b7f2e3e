"""Files of TwinCAT in memory: the blocks work from a rising edge on, and are busy until they are called again."""

import pytest
from tcunit_bench import SuiteBench, suite

from fieldrig_devices.iec.tcunit.files.disk import APPEND, MOST_OPEN, NO_MEMORY, Disk

_STEPS = """IF step = 0 THEN TEST('t'); END_IF;
{body}
IF NOT ({busy}) THEN step := step + 1; END_IF;
IF step = {last} THEN
{end}
TEST_FINISHED();
END_IF;"""


def _passes(blocks: dict[str, str], calls: list[str], end: str, declarations: str = "") -> None:
    """Run calls one after the other, each until its block is no longer busy, then the asserts."""
    body = "\n".join(f"{call[:-2]}, bExecute := step = {number});" for number, call in enumerate(calls))
    busy = " OR ".join(f"{name}.bBusy" for name in blocks)
    declared = "".join(f"{name} : {kind};\n" for name, kind in blocks.items())
    text = _STEPS.format(body=body, busy=busy, last=len(calls), end=end)
    bench = SuiteBench.ran(suite(text, f"step : INT;\n{declared}{declarations}"), longest_ns=10**9)
    test = bench.test("t")
    assert test.is_finished, bench.suites[0].fault
    assert not test.failures, bench.lines


_OPEN = "w(sPathName := 'C:\\a.txt', nMode := {mode});"
_READ = "r(sPathName := 'c:/A.TXT', nMode := FOPEN_MODEREAD{mode});"


@pytest.mark.parametrize(
    ("written", "read", "line"),
    [(" OR FOPEN_MODETEXT", "", "abc$R$N"), (" OR FOPEN_MODETEXT", " OR FOPEN_MODETEXT", "abc$N"), ("", "", "abc$N")],
)
def test_a_line_ends_with_two_characters_in_a_text(written: str, read: str, line: str) -> None:
    _passes(
        {
            "w": "FB_FileOpen",
            "p": "FB_FilePuts",
            "c": "FB_FileClose",
            "r": "Tc2_System.FB_FileOpen",
            "g": "FB_FileGets",
        },
        [
            _OPEN.format(mode=f"FOPEN_MODEWRITE{written}"),
            "p(hFile := w.hFile, sLine := 'abc$N');",
            "c(hFile := w.hFile);",
            _READ.format(mode=read),
            "g(hFile := r.hFile);",
        ],
        f"AssertEquals('{line}', g.sLine, 'line'); AssertFalse(g.bError, 'error');",
    )


def test_bytes_are_written_read_and_sought() -> None:
    _passes(
        {
            "w": "FB_FileOpen",
            "p": "FB_FileWrite",
            "s": "FB_FileSeek",
            "t": "FB_FileTell",
            "g": "FB_FileRead",
            "e": "FB_EOF",
        },
        [
            _OPEN.format(mode="FOPEN_MODEWRITE OR FOPEN_MODEPLUS OR FOPEN_MODEBINARY"),
            "p(hFile := w.hFile, pWriteBuff := ADR(given), cbWriteLen := SIZEOF(given));",
            "s(hFile := w.hFile, nSeekPos := -2, eOrigin := SEEK_END);",
            "t(hFile := w.hFile);",
            "g(hFile := w.hFile, pReadBuff := ADR(got), cbReadLen := SIZEOF(got));",
            "e(hFile := w.hFile);",
        ],
        """AssertEquals(UDINT#4, p.cbWrite, 'written');
AssertEquals(DINT#2, t.nSeekPos, 'place');
AssertEquals(UDINT#2, g.cbRead, 'read');
AssertEquals(BYTE#3, got[0], 'third');
AssertEquals(BYTE#4, got[1], 'fourth');
AssertTrue(e.bEOF, 'end');""",
        "given : ARRAY[0..3] OF BYTE := [1, 2, 3, 4]; got : ARRAY[0..3] OF BYTE;",
    )


def test_a_file_that_is_not_there_and_a_handle_that_is_none_are_errors() -> None:
    _passes(
        {"r": "FB_FileOpen", "g": "FB_FileGets", "d": "FB_FileDelete"},
        [_READ.format(mode=""), "g(hFile := 7);", "d(sPathName := 'C:\\a.txt');"],
        """AssertTrue(r.bError, 'open'); AssertEquals(UDINT#16#70C, r.nErrId, 'open');
AssertTrue(g.bError, 'gets'); AssertEquals(UDINT#16#703, g.nErrId, 'gets');
AssertTrue(d.bError, 'delete'); AssertEquals(UDINT#16#70C, d.nErrId, 'delete');""",
    )


def test_files_and_folders_are_found_by_a_pattern() -> None:
    _passes(
        {
            "w": "FB_FileOpen",
            "f": "FB_CreateDir",
            "n": "FB_FileRename",
            "e": "FB_EnumFindFileEntry",
            "l": "Tc2_Utilities.FB_EnumFindFileList",
        },
        [
            _OPEN.format(mode="FOPEN_MODEAPPEND"),
            "f(sPathName := 'C:\\b.dir');",
            "n(sOldName := 'C:\\a.txt', sNewName := 'C:\\New.txt');",
            "e(sPathName := 'C:\\*.TXT', eCmd := eEnumCmd_First);",
            "l(sPathName := 'C:\\*', pFindList := ADR(list), cbFindList := SIZEOF(list));",
        ],
        """AssertEquals('New.txt', e.stFindFile.sFileName, 'entry');
AssertFalse(e.bEOE, 'more');
AssertEquals(UDINT#2, l.nFindFiles, 'number');
AssertTrue(l.bEOE, 'no more');
AssertEquals('b.dir', list[1].sFileName, 'folder');
AssertTrue(list[1].fileAttributes.bDirectory, 'folder');
AssertFalse(list[2].fileAttributes.bDirectory, 'file');""",
        "list : ARRAY[1..3] OF ST_FindFileEntry;",
    )


def test_fields_of_csv_are_written_and_read_in_memory() -> None:
    body = """TEST('t');
w(eCmd := eEnumCmd_First, putValue := 'a', pBuffer := ADR(buffer), cbBuffer := SIZEOF(buffer));
w(eCmd := eEnumCmd_Next, putValue := 'b;"c"', bCRLF := TRUE);
w(eCmd := eEnumCmd_Next, putValue := 'd', bCRLF := FALSE);
AssertEquals('a;$22b;$22$22c$22$22$22$R$Nd', buffer, 'written');
r(eCmd := eEnumCmd_First, pBuffer := ADR(buffer), cbBuffer := w.cbSize);
AssertEquals('a', r.getValue, 'first'); AssertFalse(r.bCRLF, 'first');
r(eCmd := eEnumCmd_Next);
AssertEquals('b;"c"', r.getValue, 'second'); AssertTrue(r.bCRLF, 'second');
r(eCmd := eEnumCmd_Next);
AssertFalse(r.bOk, 'the third has no end');
TEST_FINISHED();"""
    bench = SuiteBench.ran(
        suite(body, "w : FB_CSVMemBufferWriter; r : FB_CSVMemBufferReader; buffer : STRING(80);"), longest_ns=10**9
    )
    assert not bench.test("t").failures, bench.lines


def test_texts_go_through_a_ring_as_long_as_there_is_room() -> None:
    body = """TEST('t');
ring.pBuffer := ADR(buffer); ring.cbBuffer := SIZEOF(buffer);
ring.A_AddTail(putValue := 'one'); ring.A_AddTail(putValue := 'two');
AssertTrue(ring.bOk, 'two'); AssertEquals(UDINT#2, ring.nCount, 'two');
ring.A_AddTail(putValue := 'three');
AssertFalse(ring.bOk, 'no room'); AssertEquals(UDINT#2, ring.nCount, 'no room');
ring.A_RemoveHead(getValue => got);
AssertEquals('one', got, 'head');
ring.A_Reset();
AssertEquals(UDINT#0, ring.nCount, 'empty');
ring.A_GetHead();
AssertFalse(ring.bOk, 'empty');
TEST_FINISHED();"""
    bench = SuiteBench.ran(
        suite(body, "ring : FB_StringRingBuffer; buffer : ARRAY[0..19] OF BYTE; got : T_MaxString;"), longest_ns=10**9
    )
    assert not bench.test("t").failures, bench.lines


def test_files_that_are_never_closed_come_to_an_end() -> None:
    disk = Disk()
    handles = [disk.opened("log.txt", APPEND, 1) for _ in range(MOST_OPEN)]
    assert handles[0] == (0, 1)
    assert handles[-1] == (0, MOST_OPEN)
    assert disk.opened("log.txt", APPEND, 1) == (NO_MEMORY,)
    assert disk.closed(7) == (0,)
    assert disk.opened("log.txt", APPEND, 1) == (0, 7)
