"""Files of TwinCAT for suites: the blocks of Tc2_System and Tc2_Utilities, with files that are in memory only.

As on a controller, a block works from the rising edge of bExecute on, and is busy until it is called again.  All
folders exist.  No file of the host is read or written.

Source: the public descriptions of Tc2_System and Tc2_Utilities.
"""

import fnmatch
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from fieldrig_devices.iec import characters
from fieldrig_devices.iec.host import Library, NativeBlock, NativeFunction, Results
from fieldrig_devices.iec.memory import Memory
from fieldrig_devices.iec.types import Value

FILE: Final = "TwinCAT files"
COST_NS: Final = 5_000
LONGEST_LINE: Final = 255
READ, WRITE, APPEND, PLUS, TEXT = 0x01, 0x02, 0x04, 0x08, 0x20
SET, CURRENT, END = range(3)
NO_HANDLE: Final = 0x703
NO_ACCESS: Final = 0x704
NOT_FOUND: Final = 0x70C
SEPARATOR: Final = ";"
QUOTE: Final = '"'

_PATH: Final = "sNetId : T_AmsNetId; sPathName : T_MaxString; ePath : E_OpenPath := E_OpenPath.PATH_GENERIC;"
_HANDLE: Final = "sNetId : T_AmsNetId; hFile : UINT;"
_TIMEOUT: Final = "tTimeout : TIME := DEFAULT_ADS_TIMEOUT;"


class _Form(NamedTuple):
    """One of the blocks: its inputs, where among them bExecute is, and its outputs besides those of all."""

    inputs: str
    execute: int
    outputs: str = ""
    initial: tuple[Value, ...] = ()


FORMS: Final = {
    "FB_FileOpen": _Form(
        "sNetId : T_AmsNetId; sPathName : T_MaxString; nMode : DWORD; "
        "ePath : E_OpenPath := E_OpenPath.PATH_GENERIC; bExecute : BOOL;",
        4,
        "hFile : UINT;",
        (0,),
    ),
    "FB_FileClose": _Form(f"{_HANDLE} bExecute : BOOL;", 2),
    "FB_FileRead": _Form(
        f"{_HANDLE} pReadBuff : PVOID; cbReadLen : UDINT; bExecute : BOOL;",
        4,
        "cbRead : UDINT; bEOF : BOOL;",
        (0, False),
    ),
    "FB_FileWrite": _Form(
        f"{_HANDLE} pWriteBuff : PVOID; cbWriteLen : UDINT; bExecute : BOOL;", 4, "cbWrite : UDINT;", (0,)
    ),
    "FB_FileSeek": _Form(f"{_HANDLE} nSeekPos : DINT; eOrigin : E_SeekOrigin; bExecute : BOOL;", 4),
    "FB_FileTell": _Form(f"{_HANDLE} bExecute : BOOL;", 2, "nSeekPos : DINT;", (0,)),
    "FB_EOF": _Form(f"{_HANDLE} bExecute : BOOL;", 2, "bEOF : BOOL;", (False,)),
    "FB_FileGets": _Form(f"{_HANDLE} bExecute : BOOL;", 2, "sLine : T_MaxString; bEOF : BOOL;", ("", False)),
    "FB_FilePuts": _Form(f"{_HANDLE} sLine : T_MaxString; bExecute : BOOL;", 3),
    "FB_FileDelete": _Form(f"{_PATH} bExecute : BOOL;", 3),
    "FB_FileRename": _Form(
        "sNetId : T_AmsNetId; sOldName : T_MaxString; sNewName : T_MaxString; "
        "ePath : E_OpenPath := E_OpenPath.PATH_GENERIC; bExecute : BOOL;",
        4,
    ),
    "FB_CreateDir": _Form(f"{_PATH} bExecute : BOOL;", 3),
    "FB_RemoveDir": _Form(f"{_PATH} bExecute : BOOL;", 3),
}

_TYPES: Final = """
VAR_GLOBAL CONSTANT
    FOPEN_MODEREAD : DWORD := 16#0001;
    FOPEN_MODEWRITE : DWORD := 16#0002;
    FOPEN_MODEAPPEND : DWORD := 16#0004;
    FOPEN_MODEPLUS : DWORD := 16#0008;
    FOPEN_MODEBINARY : DWORD := 16#0010;
    FOPEN_MODETEXT : DWORD := 16#0020;
    DEFAULT_CSV_FIELD_DOUBLE_QUOTE : BYTE := 16#22;
    DEFAULT_CSV_RECORD_SEP_CR : BYTE := 16#0D;
    DEFAULT_CSV_RECORD_SEP_LF : BYTE := 16#0A;
END_VAR
VAR_GLOBAL
    DEFAULT_CSV_FIELD_SEP : BYTE := 16#3B;
END_VAR
TYPE E_OpenPath :
(
    PATH_GENERIC := 1, PATH_BOOTPRJ, PATH_BOOTDATA, PATH_BOOTPATH,
    PATH_USERPATH1 := 11, PATH_USERPATH2, PATH_USERPATH3, PATH_USERPATH4, PATH_USERPATH5, PATH_USERPATH6,
    PATH_USERPATH7, PATH_USERPATH8, PATH_USERPATH9
);
END_TYPE
TYPE E_SeekOrigin : (SEEK_SET := 0, SEEK_CUR, SEEK_END); END_TYPE
TYPE E_EnumCmdType : (eEnumCmd_First := 0, eEnumCmd_Next, eEnumCmd_Abort); END_TYPE
TYPE ST_FileAttributes :
    STRUCT
        bReadOnly, bHidden, bSystem, bDirectory, bArchive, bDevice, bNormal, bTemporary, bSparseFile, bReparsePoint,
        bCompressed, bOffline, bNotContentIndexed, bEncrypted : BOOL;
    END_STRUCT;
END_TYPE
TYPE ST_FindFileEntry :
    STRUCT
        sFileName : T_MaxString;
        sAlternateFileName : STRING(13);
        fileAttributes : ST_FileAttributes;
        fileSize : T_ULARGE_INTEGER;
        creationTime, lastAccessTime, lastWriteTime : T_FILETIME;
    END_STRUCT;
END_TYPE
"""

_FIND: Final = """
FUNCTION FIELDRIG_FILES_FIND : BOOL
(* The file after the first n that a path with * and ? names. *)
VAR_INPUT sPathName : T_MaxString; n : UDINT; END_VAR
VAR_OUTPUT sFileName : T_MaxString; size : UDINT; isDirectory : BOOL; END_VAR
{native} END_FUNCTION
FUNCTION FIELDRIG_FILES_ENTRY : ST_FindFileEntry
VAR_INPUT sFileName : T_MaxString; size : UDINT; isDirectory : BOOL; END_VAR
VAR written : T_FILETIME; END_VAR
written := FILETIME64_TO_FILETIME(F_GetSystemTime());
FIELDRIG_FILES_ENTRY.sFileName := sFileName;
FIELDRIG_FILES_ENTRY.fileSize.dwLowPart := size;
FIELDRIG_FILES_ENTRY.fileAttributes.bDirectory := isDirectory;
FIELDRIG_FILES_ENTRY.fileAttributes.bNormal := NOT isDirectory;
FIELDRIG_FILES_ENTRY.creationTime := written;
FIELDRIG_FILES_ENTRY.lastAccessTime := written;
FIELDRIG_FILES_ENTRY.lastWriteTime := written;
END_FUNCTION
FUNCTION_BLOCK FB_EnumFindFileEntry
VAR_INPUT
    sNetId : T_AmsNetId; sPathName : T_MaxString; eCmd : E_EnumCmdType; bExecute : BOOL; {timeout}
END_VAR
VAR_OUTPUT bBusy, bError : BOOL; nErrId : UDINT; bEOE : BOOL; stFindFile : ST_FindFileEntry; END_VAR
VAR wasExecuted : BOOL; n, size : UDINT; isDirectory : BOOL; name : T_MaxString; none : ST_FindFileEntry; END_VAR
bBusy := bExecute AND NOT wasExecuted;
wasExecuted := bExecute;
IF bBusy THEN
    IF eCmd <> E_EnumCmdType.eEnumCmd_Next THEN
        n := 0;
    END_IF;
    bEOE := eCmd = E_EnumCmdType.eEnumCmd_Abort;
    IF NOT bEOE THEN
        bEOE := NOT FIELDRIG_FILES_FIND(sPathName, n, sFileName => name, size => size, isDirectory => isDirectory);
    END_IF;
    IF bEOE THEN
        stFindFile := none;
    ELSE
        stFindFile := FIELDRIG_FILES_ENTRY(name, size, isDirectory);
        n := n + 1;
    END_IF;
END_IF;
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_EnumFindFileList
VAR_INPUT
    sNetId : T_AmsNetId; sPathName : T_MaxString; eCmd : E_EnumCmdType; pFindList : POINTER TO ST_FindFileEntry;
    cbFindList : UDINT; bExecute : BOOL; {timeout}
END_VAR
VAR_OUTPUT bBusy, bError : BOOL; nErrId : UDINT; bEOE : BOOL; nFindFiles : UDINT; END_VAR
VAR wasExecuted : BOOL; n, size, most : UDINT; isDirectory : BOOL; name : T_MaxString; END_VAR
bBusy := bExecute AND NOT wasExecuted;
wasExecuted := bExecute;
IF bBusy THEN
    IF eCmd <> E_EnumCmdType.eEnumCmd_Next THEN
        n := 0;
    END_IF;
    most := 0;
    IF eCmd <> E_EnumCmdType.eEnumCmd_Abort AND pFindList <> 0 THEN
        most := cbFindList / SIZEOF(ST_FindFileEntry);
    END_IF;
    nFindFiles := 0;
    bEOE := most = 0;
    WHILE nFindFiles < most AND NOT bEOE DO
        bEOE := NOT FIELDRIG_FILES_FIND(sPathName, n, sFileName => name, size => size, isDirectory => isDirectory);
        IF NOT bEOE THEN
            pFindList[nFindFiles] := FIELDRIG_FILES_ENTRY(name, size, isDirectory);
            n := n + 1;
            nFindFiles := nFindFiles + 1;
        END_IF;
    END_WHILE;
END_IF;
END_FUNCTION_BLOCK
"""

_CSV: Final = """
FUNCTION FIELDRIG_FILES_FIELD : T_MaxString
(* The field that begins at a place; `cb` is its size with what separates it from the next, 0 if it does not end. *)
VAR_INPUT pBuffer : PVOID; cbBuffer : UDINT; separator : BYTE; END_VAR
VAR_OUTPUT cb : UDINT; bCRLF : BOOL; END_VAR
{native} END_FUNCTION
FUNCTION FIELDRIG_FILES_PUT : UDINT
(* Writes a field, and returns its size; 0 if there is no room for it. *)
VAR_INPUT
    pBuffer : PVOID; cbBuffer : UDINT; separator : BYTE; value : T_MaxString; isFirst : BOOL; bCRLF : BOOL;
END_VAR
{native} END_FUNCTION
FUNCTION_BLOCK FB_CSVMemBufferReader
VAR_INPUT eCmd : E_EnumCmdType; pBuffer : PVOID; cbBuffer : UDINT; END_VAR
VAR_OUTPUT bOk : BOOL; getValue : T_MaxString; pValue : PVOID; cbValue : UDINT; bCRLF : BOOL; cbRead : UDINT; END_VAR
VAR position : UDINT; END_VAR
IF eCmd = E_EnumCmdType.eEnumCmd_First THEN
    position := 0;
END_IF;
bOk := FALSE;
bCRLF := FALSE;
cbRead := 0;
cbValue := 0;
pValue := 0;
getValue := '';
IF eCmd <> E_EnumCmdType.eEnumCmd_Abort AND pBuffer <> 0 AND position < cbBuffer THEN
    pValue := pBuffer + position;
    getValue := FIELDRIG_FILES_FIELD(
        pValue, cbBuffer - position, DEFAULT_CSV_FIELD_SEP, cb => cbRead, bCRLF => bCRLF);
    bOk := cbRead > 0;
    cbValue := INT_TO_UDINT(LEN(getValue));
    position := position + cbRead;
END_IF;
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_CSVMemBufferWriter
VAR_INPUT
    eCmd : E_EnumCmdType; putValue : T_MaxString; pValue : PVOID; cbValue : UDINT; bCRLF : BOOL; pBuffer : PVOID;
    cbBuffer : UDINT;
END_VAR
VAR_OUTPUT bOk : BOOL; cbSize, cbFree, nFields, nRecords, cbWrite : UDINT; END_VAR
VAR isInRecord : BOOL; END_VAR
IF eCmd = E_EnumCmdType.eEnumCmd_First THEN
    cbSize := nFields := nRecords := 0;
    isInRecord := FALSE;
END_IF;
bOk := FALSE;
cbWrite := 0;
IF eCmd <> E_EnumCmdType.eEnumCmd_Abort AND pBuffer <> 0 THEN
    cbWrite := FIELDRIG_FILES_PUT(
        pBuffer + cbSize, cbBuffer - cbSize, DEFAULT_CSV_FIELD_SEP, putValue, NOT isInRecord, bCRLF);
    bOk := cbWrite > 0 OR (putValue = '' AND NOT isInRecord AND NOT bCRLF);
    IF bOk THEN
        cbSize := cbSize + cbWrite;
        nFields := nFields + 1;
        nRecords := nRecords + BOOL_TO_UDINT(bCRLF);
        isInRecord := NOT bCRLF;
    END_IF;
    cbFree := cbBuffer - cbSize;
END_IF;
END_FUNCTION_BLOCK
"""

_RING: Final = """
FUNCTION_BLOCK FB_StringRingBuffer
(* Each string has its four bytes of length in front, and its zero behind it. *)
VAR_INPUT bOverwrite : BOOL; putValue : T_MaxString; pBuffer : PVOID; cbBuffer : UDINT; END_VAR
VAR_OUTPUT bOk : BOOL; getValue : T_MaxString; nCount, cbSize : UDINT; END_VAR
METHOD PRIVATE Ring : BOOL
VAR_INPUT command : INT; END_VAR
Ring := FIELDRIG_FILES_RING(
    ADR(THIS^), command, bOverwrite, putValue, cbBuffer, getValue => getValue, nCount => nCount, cbSize => cbSize);
Ring := Ring AND pBuffer <> 0;
bOk := Ring;
END_METHOD
METHOD A_Reset : BOOL
A_Reset := Ring(0);
END_METHOD
METHOD A_AddTail : BOOL
VAR_INPUT putValue : T_MaxString := '$01'; END_VAR
IF putValue <> '$01' THEN
    THIS^.putValue := putValue;
END_IF;
A_AddTail := Ring(1);
END_METHOD
METHOD A_GetHead : BOOL
VAR_OUTPUT getValue : T_MaxString; END_VAR
A_GetHead := Ring(2);
getValue := THIS^.getValue;
END_METHOD
METHOD A_RemoveHead : BOOL
VAR_OUTPUT getValue : T_MaxString; END_VAR
A_RemoveHead := Ring(3);
getValue := THIS^.getValue;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION FIELDRIG_FILES_RING : BOOL
VAR_INPUT block : PVOID; command : INT; bOverwrite : BOOL; putValue : T_MaxString; cbBuffer : UDINT; END_VAR
VAR_OUTPUT getValue : T_MaxString; nCount, cbSize : UDINT; END_VAR
{native} END_FUNCTION
"""
_OVERHEAD: Final = 5


def text() -> str:
    """Return the source text of the library."""
    blocks = [
        f"FUNCTION_BLOCK {name}\nVAR_INPUT {form.inputs} {_TIMEOUT} END_VAR\n"
        f"VAR_OUTPUT bBusy, bError : BOOL; nErrId : UDINT; {form.outputs} END_VAR\n{{native}} END_FUNCTION_BLOCK\n"
        for name, form in FORMS.items()
    ]
    return f"{_TYPES}{''.join(blocks)}{_FIND.replace('{timeout}', _TIMEOUT)}{_CSV}{_RING}"


@dataclass(slots=True)
class _Open:
    """An open file: what it has, and where in it the next access is."""

    path: str
    mode: int
    place: int = 0


@dataclass(slots=True)
class _Work:
    """The state of one block."""

    was_executed: bool = False
    outputs: tuple[Value, ...] = ()
    next: tuple[Value, ...] | None = None
    """The outputs after the next call."""


@dataclass(slots=True)
class Files:
    """The files of one run.  `memory` is that of the program, once it is loaded."""

    memory: Memory | None = None
    contents: dict[str, bytearray] = field(default_factory=dict)
    """The bytes of each file, by its path in small letters."""
    names: dict[str, str] = field(default_factory=dict)
    """The paths as they were given, by the same."""
    folders: dict[str, str] = field(default_factory=dict)
    _open: dict[int, _Open] = field(default_factory=dict)
    _works: dict[Hashable, _Work] = field(default_factory=dict)
    _rings: dict[int, list[str]] = field(default_factory=dict)

    def library(self) -> Library:
        """Return the library with its text and its functions."""
        actions: dict[str, Callable[..., Results]] = {
            "FB_FileOpen": self._opened,
            "FB_FileClose": self._closed,
            "FB_FileRead": self._read,
            "FB_FileWrite": self._write,
            "FB_FileSeek": self._seek,
            "FB_FileTell": self._tell,
            "FB_EOF": self._end,
            "FB_FileGets": self._gets,
            "FB_FilePuts": self._puts,
            "FB_FileDelete": self._delete,
            "FB_FileRename": self._rename,
            "FB_CreateDir": self._create_folder,
            "FB_RemoveDir": self._remove_folder,
        }
        blocks = {name.lower(): NativeBlock(self._block(name, action), COST_NS) for name, action in actions.items()}
        functions = {
            "fieldrig_files_find": NativeFunction(self._find, COST_NS),
            "fieldrig_files_field": NativeFunction(self._field, COST_NS),
            "fieldrig_files_put": NativeFunction(self._put, COST_NS),
            "fieldrig_files_ring": NativeFunction(self._ring, COST_NS),
        }
        return Library(FILE, text(), functions, blocks)

    def _block(self, name: str, action: Callable[..., Results]) -> Callable[..., Results]:
        """Return what one call of a block does.  The action gives the error, 0 if there is none, then the outputs."""
        form = FORMS[name]

        def run(address: int, *inputs: Value) -> Results:
            work = self._works.setdefault((name, address), _Work(outputs=(False, False, 0, *form.initial)))
            if work.next is not None:
                work.outputs, work.next = work.next, None
            is_executed = bool(inputs[form.execute])
            if is_executed and not work.was_executed:
                given = [value for number, value in enumerate(inputs[:-1]) if number not in (0, form.execute)]
                error, *outputs = action(*given)
                work.next = (False, bool(error), error, *(outputs or form.initial))
                work.outputs = (True, False, 0, *work.outputs[3:])
            work.was_executed = is_executed
            return work.outputs

        return run

    # ---- files

    def _opened(self, path: str, mode: int, base: int) -> Results:
        key = _key(path)
        if not path or (mode & READ and key not in self.contents):
            return (NOT_FOUND,)
        if mode & WRITE:
            self.contents[key] = bytearray()
        self.contents.setdefault(key, bytearray())
        self.names.setdefault(key, path)
        handle = next(number for number in range(1, 1 << 16) if number not in self._open)
        self._open[handle] = _Open(key, mode)
        return 0, handle

    def _closed(self, handle: int) -> Results:
        return (0 if self._open.pop(handle, None) else NO_HANDLE,)

    def _read(self, handle: int, address: int, size: int) -> Results:
        file = self._open.get(handle)
        if file is None:
            return (NO_HANDLE,)
        if not file.mode & (READ | PLUS):
            return (NO_ACCESS,)
        data = self._taken(file, size)
        if data:
            assert self.memory is not None
            self.memory.put_bytes_at(address, data)
        return 0, len(data), len(data) < size and not data

    def _taken(self, file: _Open, size: int) -> bytes:
        """Read on in a file; as text, an end of a line is one character."""
        content = self.contents.get(file.path, bytearray())
        if not file.mode & TEXT:
            data = bytes(content[file.place : file.place + size])
            file.place += len(data)
            return data
        read = bytearray()
        while len(read) < size and file.place < len(content):
            is_end = content[file.place : file.place + 2] == b"\r\n"
            read.append(0x0A if is_end else content[file.place])
            file.place += 2 if is_end else 1
        return bytes(read)

    def _write(self, handle: int, address: int, size: int) -> Results:
        assert self.memory is not None
        error = self._written(handle, self.memory.bytes_at(address, size) if size else b"")
        return error, 0 if error else size

    def _written(self, handle: int, data: bytes) -> int:
        file = self._open.get(handle)
        if file is None:
            return NO_HANDLE
        if not file.mode & (WRITE | APPEND | PLUS):
            return NO_ACCESS
        if file.mode & TEXT:
            data = data.replace(b"\n", b"\r\n")
        content = self.contents.setdefault(file.path, bytearray())
        if file.mode & APPEND:
            file.place = len(content)
        content.extend(bytes(max(0, file.place - len(content))))
        content[file.place : file.place + len(data)] = data
        file.place += len(data)
        return 0

    def _seek(self, handle: int, offset: int, origin: int) -> Results:
        file = self._open.get(handle)
        if file is None:
            return (NO_HANDLE,)
        base = {SET: 0, CURRENT: file.place, END: len(self.contents.get(file.path, b""))}.get(origin, 0)
        if base + offset < 0:
            return (NO_ACCESS,)
        file.place = base + offset
        return (0,)

    def _tell(self, handle: int) -> Results:
        file = self._open.get(handle)
        return (NO_HANDLE,) if file is None else (0, file.place)

    def _end(self, handle: int) -> Results:
        file = self._open.get(handle)
        return (NO_HANDLE,) if file is None else (0, file.place >= len(self.contents.get(file.path, b"")))

    def _gets(self, handle: int) -> Results:
        file = self._open.get(handle)
        if file is None:
            return (NO_HANDLE,)
        line = bytearray()
        while len(line) < LONGEST_LINE and not line.endswith(b"\n") and (data := self._taken(file, 1)):
            line += data
        return 0, characters.decoded(bytes(line), is_wide=False), not line

    def _puts(self, handle: int, line: str) -> Results:
        return (self._written(handle, characters.encoded(line, is_wide=False)),)

    def _delete(self, path: str, base: int) -> Results:
        self.names.pop(_key(path), None)
        return (NOT_FOUND if self.contents.pop(_key(path), None) is None else 0,)

    def _rename(self, old: str, new: str, base: int) -> Results:
        content = self.contents.pop(_key(old), None)
        if content is None:
            return (NOT_FOUND,)
        self.names.pop(_key(old), None)
        self.contents[_key(new)], self.names[_key(new)] = content, new
        return (0,)

    def _create_folder(self, path: str, base: int) -> Results:
        self.folders[_key(path).rstrip("\\")] = path.replace("/", "\\").rstrip("\\")
        return (0,)

    def _remove_folder(self, path: str, base: int) -> Results:
        return (NOT_FOUND if self.folders.pop(_key(path).rstrip("\\"), None) is None else 0,)

    def _find(self, pattern: str, number: int) -> Results:
        folder, _, wanted = _key(pattern).rpartition("\\")
        wanted = "*" if wanted == "*.*" else wanted.replace("[", "[[]")
        found = [(key, name, False) for key, name in self.names.items()]
        found += [(key, name, True) for key, name in self.folders.items()]
        matches = [
            (name.replace("/", "\\").rpartition("\\")[2], len(self.contents.get(key, b"")), is_folder)
            for key, name, is_folder in sorted(found)
            if key.rpartition("\\")[0] == folder and fnmatch.fnmatchcase(key.rpartition("\\")[2], wanted)
        ]
        return (True, *matches[number]) if number < len(matches) else (False, "", 0, False)

    # ---- texts in memory

    def _field(self, address: int, size: int, separator: int) -> Results:
        assert self.memory is not None
        data = self.memory.bytes_at(address, size).decode("latin-1")
        place, field_text, is_quoted = 0, "", data.startswith(QUOTE)
        if is_quoted:
            place = 1
            while place < len(data) and (data[place] != QUOTE or data[place + 1 : place + 2] == QUOTE):
                field_text += data[place]
                place += 2 if data[place] == QUOTE else 1
            place += 1
        else:
            while place < len(data) and data[place] not in (chr(separator), "\r", "\n"):
                place += 1
            field_text = data[:place]
        if place >= len(data):
            return "", 0, False
        if data[place] == chr(separator):
            return field_text[:LONGEST_LINE], place + 1, False
        if data[place] == "\r" and place + 1 >= len(data):
            return "", 0, False
        return field_text[:LONGEST_LINE], place + (2 if data[place : place + 2] == "\r\n" else 1), True

    def _put(self, address: int, room: int, separator: int, value: str, is_first: bool, ends_record: bool) -> Results:
        assert self.memory is not None
        if set(value) & {chr(separator), QUOTE, "\r", "\n"}:
            value = f"{QUOTE}{value.replace(QUOTE, QUOTE * 2)}{QUOTE}"
        whole = ("" if is_first else chr(separator)) + value + ("\r\n" if ends_record else "")
        if len(whole) > room:
            return (0,)
        if whole:
            self.memory.put_bytes_at(address, characters.encoded(whole, is_wide=False))
        return (len(whole),)

    def _ring(self, block: int, command: int, overwrites: bool, value: str, room: int) -> Results:
        ring = self._rings.setdefault(block, [])
        is_right, head = True, ""
        if command == 0:
            ring.clear()
        elif command == 1:
            size = len(value) + _OVERHEAD
            while overwrites and ring and _size(ring) + size > room:
                ring.pop(0)
            is_right = _size(ring) + size <= room
            if is_right:
                ring.append(value)
        elif is_right := bool(ring):
            head = ring.pop(0) if command == 3 else ring[0]
        return is_right, head, len(ring), _size(ring)


def _key(path: str) -> str:
    return path.replace("/", "\\").replace("\\\\", "\\").casefold()


def _size(ring: list[str]) -> int:
    return sum(len(value) + _OVERHEAD for value in ring)
