"""The blocks that search a folder; which files and folders there are, the disk says."""

from typing import Final

from fieldrig_devices.iec.tcunit.files.declared import TIMEOUT

TEXT: Final = """
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
    sNetId : T_AmsNetId; ePath : E_OpenPath := E_OpenPath.PATH_GENERIC; sPathName : T_MaxString; eCmd : E_EnumCmdType;
    bExecute : BOOL; {timeout}
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
    sNetId : T_AmsNetId; ePath : E_OpenPath := E_OpenPath.PATH_GENERIC; sPathName : T_MaxString; eCmd : E_EnumCmdType;
    pFindList : POINTER TO ST_FindFileEntry;
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
""".replace("{timeout}", TIMEOUT)
