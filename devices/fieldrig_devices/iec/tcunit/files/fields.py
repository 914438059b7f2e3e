"""The blocks for CSV in the memory of a program, and the functions that read and write a field there."""

from typing import Final

from fieldrig_devices.iec import characters
from fieldrig_devices.iec.host import Results
from fieldrig_devices.iec.memory import Memory
from fieldrig_devices.iec.tcunit.files.disk import LONGEST_LINE

QUOTE: Final = '"'

TEXT: Final = """
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


def field_at(memory: Memory, address: int, size: int, separator: int) -> Results:
    """Return the field at an address, its size with what ends it, 0 if nothing does, and if that is CR and LF."""
    data = memory.bytes_at(address, size).decode("latin-1")
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


def put(
    memory: Memory, address: int, room: int, separator: int, value: str, is_first: bool, ends_record: bool
) -> Results:
    """Write a field with what separates it from its neighbours, and return their size; 0 if there is no room."""
    if set(value) & {chr(separator), QUOTE, "\r", "\n"}:
        value = f"{QUOTE}{value.replace(QUOTE, QUOTE * 2)}{QUOTE}"
    whole = ("" if is_first else chr(separator)) + value + ("\r\n" if ends_record else "")
    if len(whole) > room:
        return (0,)
    if whole:
        memory.put_bytes_at(address, characters.encoded(whole, is_wide=False))
    return (len(whole),)
