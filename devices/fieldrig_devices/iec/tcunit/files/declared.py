"""The declarations of the blocks for files, and the types and constants that programs give them."""

from typing import Final, NamedTuple

from fieldrig_devices.iec.types import Value

TIMEOUT: Final = "tTimeout : TIME := DEFAULT_ADS_TIMEOUT;"
_PATH: Final = "sNetId : T_AmsNetId; sPathName : T_MaxString; ePath : E_OpenPath := E_OpenPath.PATH_GENERIC;"
_HANDLE: Final = "sNetId : T_AmsNetId; hFile : UINT;"


class Form(NamedTuple):
    """One of the blocks: its inputs, where among them bExecute is, and its outputs besides those of all."""

    inputs: str
    execute: int
    outputs: str = ""
    initial: tuple[Value, ...] = ()


FORMS: Final = {
    "FB_FileOpen": Form(
        "sNetId : T_AmsNetId; sPathName : T_MaxString; nMode : DWORD; "
        "ePath : E_OpenPath := E_OpenPath.PATH_GENERIC; bExecute : BOOL;",
        4,
        "hFile : UINT;",
        (0,),
    ),
    "FB_FileClose": Form(f"{_HANDLE} bExecute : BOOL;", 2),
    "FB_FileRead": Form(
        f"{_HANDLE} pReadBuff : PVOID; cbReadLen : UDINT; bExecute : BOOL;",
        4,
        "cbRead : UDINT; bEOF : BOOL;",
        (0, False),
    ),
    "FB_FileWrite": Form(
        f"{_HANDLE} pWriteBuff : PVOID; cbWriteLen : UDINT; bExecute : BOOL;", 4, "cbWrite : UDINT;", (0,)
    ),
    "FB_FileSeek": Form(f"{_HANDLE} nSeekPos : DINT; eOrigin : E_SeekOrigin; bExecute : BOOL;", 4),
    "FB_FileTell": Form(f"{_HANDLE} bExecute : BOOL;", 2, "nSeekPos : DINT;", (0,)),
    "FB_EOF": Form(f"{_HANDLE} bExecute : BOOL;", 2, "bEOF : BOOL;", (False,)),
    "FB_FileGets": Form(f"{_HANDLE} bExecute : BOOL;", 2, "sLine : T_MaxString; bEOF : BOOL;", ("", False)),
    "FB_FilePuts": Form(f"{_HANDLE} sLine : T_MaxString; bExecute : BOOL;", 3),
    "FB_FileDelete": Form(f"{_PATH} bExecute : BOOL;", 3),
    "FB_FileRename": Form(
        "sNetId : T_AmsNetId; sOldName : T_MaxString; sNewName : T_MaxString; "
        "ePath : E_OpenPath := E_OpenPath.PATH_GENERIC; bExecute : BOOL;",
        4,
    ),
    "FB_CreateDir": Form(f"{_PATH} bExecute : BOOL;", 3),
    "FB_RemoveDir": Form(f"{_PATH} bExecute : BOOL;", 3),
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


def text() -> str:
    """Return the source text of the types, the constants and the blocks."""
    blocks = [
        f"FUNCTION_BLOCK {name}\nVAR_INPUT {form.inputs} {TIMEOUT} END_VAR\n"
        f"VAR_OUTPUT bBusy, bError : BOOL; nErrId : UDINT; {form.outputs} END_VAR\n{{native}} END_FUNCTION_BLOCK\n"
        for name, form in FORMS.items()
    ]
    return f"{_TYPES}{''.join(blocks)}"
