"""The blocks of Tc3_JsonXml as programs see them: each method hands its arguments to a native function.

Source: the public description of Tc3_JsonXml.  Texts are VAR_IN_OUT CONSTANT, so that they may have any length.
Not there are files, the SAX reader, XML, and what asks other devices by ADS.
"""

import re
from typing import Final

FILE: Final = "Tc3_JsonXml"
PREFIX: Final = "FIELDRIG_JSON_"

_DOM: Final = """
NewDocument : SJsonValue
ParseDocument : SJsonValue (sJson : TEXT)
GetDocumentRoot : SJsonValue
GetDocument : STRING(255)
GetDocumentLength : UDINT
CopyDocument : UDINT (pDoc : TEXT, nDoc : UDINT)
ExceptionRaised : BOOL
GetMaxDecimalPlaces : DINT
SetMaxDecimalPlaces (dp : DINT)
AddArrayMember : SJsonValue (v : SJsonValue, member : TEXT, reserve : UDINT)
AddBase64Member : SJsonValue (v : SJsonValue, member : TEXT, p : PVOID, n : UDINT)
AddBoolMember : SJsonValue (v : SJsonValue, member : TEXT, value : BOOL)
AddDateTimeMember : SJsonValue (v : SJsonValue, member : TEXT, value : DATE_AND_TIME)
AddDcTimeMember : SJsonValue (v : SJsonValue, member : TEXT, value : DCTIME)
AddDoubleMember : SJsonValue (v : SJsonValue, member : TEXT, value : LREAL)
AddFileTimeMember : SJsonValue (v : SJsonValue, member : TEXT, value : FILETIME)
AddHexBinaryMember : SJsonValue (v : SJsonValue, member : TEXT, p : PVOID, n : UDINT)
AddInt64Member : SJsonValue (v : SJsonValue, member : TEXT, value : LINT)
AddIntMember : SJsonValue (v : SJsonValue, member : TEXT, value : DINT)
AddJsonMember : SJsonValue (v : SJsonValue, member : TEXT, rawJson : TEXT)
AddNullMember : SJsonValue (v : SJsonValue, member : TEXT)
AddObjectMember : SJsonValue (v : SJsonValue, member : TEXT)
AddStringMember : SJsonValue (v : SJsonValue, member : TEXT, value : TEXT)
AddUint64Member : SJsonValue (v : SJsonValue, member : TEXT, value : ULINT)
AddUintMember : SJsonValue (v : SJsonValue, member : TEXT, value : UDINT)
PushbackBase64Value : SJsonValue (v : SJsonValue, p : PVOID, n : UDINT)
PushbackBoolValue : SJsonValue (v : SJsonValue, value : BOOL)
PushbackDateTimeValue : SJsonValue (v : SJsonValue, value : DATE_AND_TIME)
PushbackDcTimeValue : SJsonValue (v : SJsonValue, value : DCTIME)
PushbackDoubleValue : SJsonValue (v : SJsonValue, value : LREAL)
PushbackFileTimeValue : SJsonValue (v : SJsonValue, value : FILETIME)
PushbackHexBinaryValue : SJsonValue (v : SJsonValue, p : PVOID, n : UDINT)
PushbackInt64Value : SJsonValue (v : SJsonValue, value : LINT)
PushbackIntValue : SJsonValue (v : SJsonValue, value : DINT)
PushbackJsonValue : SJsonValue (v : SJsonValue, rawJson : TEXT)
PushbackNullValue : SJsonValue (v : SJsonValue)
PushbackStringValue : SJsonValue (v : SJsonValue, value : TEXT)
PushbackUint64Value : SJsonValue (v : SJsonValue, value : ULINT)
PushbackUintValue : SJsonValue (v : SJsonValue, value : UDINT)
SetArray : SJsonValue (v : SJsonValue, reserve : UDINT)
SetBase64 : SJsonValue (v : SJsonValue, p : PVOID, n : UDINT)
SetBool : SJsonValue (v : SJsonValue, value : BOOL)
SetDateTime : SJsonValue (v : SJsonValue, value : DATE_AND_TIME)
SetDcTime : SJsonValue (v : SJsonValue, value : DCTIME)
SetDouble : SJsonValue (v : SJsonValue, value : LREAL)
SetFileTime : SJsonValue (v : SJsonValue, value : FILETIME)
SetHexBinary : SJsonValue (v : SJsonValue, p : PVOID, n : UDINT)
SetInt : SJsonValue (v : SJsonValue, value : DINT)
SetInt64 : SJsonValue (v : SJsonValue, value : LINT)
SetJson : SJsonValue (v : SJsonValue, rawJson : TEXT)
SetNull : SJsonValue (v : SJsonValue)
SetObject : SJsonValue (v : SJsonValue)
SetString : SJsonValue (v : SJsonValue, value : TEXT)
SetUint : SJsonValue (v : SJsonValue, value : UDINT)
SetUint64 : SJsonValue (v : SJsonValue, value : ULINT)
FindMember : SJsonValue (v : SJsonValue, member : TEXT)
FindMemberPath : SJsonValue (v : SJsonValue, member : TEXT)
HasMember : BOOL (v : SJsonValue, member : TEXT)
GetArraySize : UDINT (v : SJsonValue)
GetArrayValue : SJsonValue (i : SJsonAIterator)
GetArrayValueByIdx : SJsonValue (v : SJsonValue, idx : UDINT)
ArrayBegin : SJsonAIterator (v : SJsonValue)
ArrayEnd : SJsonAIterator (v : SJsonValue)
NextArray : SJsonAIterator (i : SJsonAIterator)
ClearArray : BOOL (v : SJsonValue, i : SJsonAIterator)
RemoveArray : BOOL (v : SJsonValue, i : SJsonAIterator)
MemberBegin : SJsonIterator (v : SJsonValue)
MemberEnd : SJsonIterator (v : SJsonValue)
NextMember : SJsonIterator (i : SJsonIterator)
GetMemberName : STRING(255) (i : SJsonIterator)
GetMemberValue : SJsonValue (i : SJsonIterator)
RemoveMember : BOOL (v : SJsonValue, i : SJsonIterator, keepOrder : BOOL)
RemoveMemberByName : BOOL (v : SJsonValue, member : TEXT, keepOrder : BOOL)
RemoveAllMembers : BOOL (v : SJsonValue)
Swap (a : SJsonValue, b : SJsonValue)
GetBase64 : DINT (v : SJsonValue, p : PVOID, n : DINT)
GetBool : BOOL (v : SJsonValue)
GetDateTime : DATE_AND_TIME (v : SJsonValue)
GetDcTime : DCTIME (v : SJsonValue)
GetDouble : LREAL (v : SJsonValue)
GetFileTime : FILETIME (v : SJsonValue)
GetHexBinary : DINT (v : SJsonValue, p : PVOID, n : DINT)
GetInt : DINT (v : SJsonValue)
GetInt64 : LINT (v : SJsonValue)
GetJson : STRING(255) (v : SJsonValue)
GetJsonLength : UDINT (v : SJsonValue)
CopyJson : UDINT (v : SJsonValue, pDoc : TEXT, nDoc : UDINT)
GetString : STRING(255) (v : SJsonValue)
GetStringLength : UDINT (v : SJsonValue)
CopyString : UDINT (v : SJsonValue, pStr : TEXT, nStr : UDINT)
GetType : EJsonType (v : SJsonValue)
GetUint : UDINT (v : SJsonValue)
GetUint64 : ULINT (v : SJsonValue)
IsArray : BOOL (v : SJsonValue)
IsBase64 : BOOL (v : SJsonValue)
IsBool : BOOL (v : SJsonValue)
IsDouble : BOOL (v : SJsonValue)
IsFalse : BOOL (v : SJsonValue)
IsHexBinary : BOOL (v : SJsonValue)
IsISO8601TimeFormat : BOOL (v : SJsonValue)
IsInt : BOOL (v : SJsonValue)
IsInt64 : BOOL (v : SJsonValue)
IsNull : BOOL (v : SJsonValue)
IsNumber : BOOL (v : SJsonValue)
IsObject : BOOL (v : SJsonValue)
IsString : BOOL (v : SJsonValue)
IsTrue : BOOL (v : SJsonValue)
IsUint : BOOL (v : SJsonValue)
IsUint64 : BOOL (v : SJsonValue)
"""

_SAX: Final = """
AddBase64 (pBytes : PVOID, nBytes : DINT)
AddBool (value : BOOL)
AddDateTime (value : DATE_AND_TIME)
AddDcTime (value : DCTIME)
AddDint (value : DINT)
AddFileTime (value : FILETIME)
AddHexBinary (pBytes : PVOID, nBytes : DINT)
AddKey (key : TEXT)
AddKeyBool (key : TEXT, value : BOOL)
AddKeyDateTime (key : TEXT, value : DATE_AND_TIME)
AddKeyDcTime (key : TEXT, value : DCTIME)
AddKeyFileTime (key : TEXT, value : FILETIME)
AddKeyLreal (key : TEXT, value : LREAL)
AddKeyNull (key : TEXT)
AddKeyNumber (key : TEXT, value : DINT)
AddKeyString (key : TEXT, value : TEXT)
AddLint (value : LINT)
AddLreal (value : LREAL)
AddNull
AddRawArray (rawJson : TEXT)
AddRawObject (rawJson : TEXT)
AddReal (value : REAL)
AddString (value : TEXT)
AddUdint (value : UDINT)
AddUlint (value : ULINT)
StartArray
EndArray
StartObject
EndObject
ResetDocument
GetDocument : STRING(255)
GetDocumentLength : UDINT
CopyDocument : UDINT (pDoc : TEXT, nDoc : UDINT)
GetMaxDecimalPlaces : DINT
SetMaxDecimalPlaces (dp : DINT)
"""

_DATATYPE: Final = """
AddJsonValueFromSymbol : BOOL (fbWriter : WRITER, sDatatype : TEXT, nData : UDINT, pData : PVOID)
AddJsonKeyValueFromSymbol : BOOL (fbWriter : WRITER, sKey : TEXT, sDatatype : TEXT, nData : UDINT, pData : PVOID)
GetJsonStringFromSymbol : STRING(255) (sDatatype : TEXT, nData : UDINT, pData : PVOID)
GetSizeJsonStringFromSymbol : UDINT (sDatatype : TEXT, nData : UDINT, pData : PVOID)
CopyJsonStringFromSymbol : UDINT (sDatatype : TEXT, nData : UDINT, pData : PVOID, pDoc : TEXT, nDoc : UDINT)
SetSymbolFromJson : BOOL (sJson : TEXT, sDatatype : TEXT, nData : UDINT, pData : PVOID)
GetDatatypeNameByAddress : STRING(255) (nData : UDINT, pData : PVOID)
GetSymbolNameByAddress : STRING(255) (nData : UDINT, pData : PVOID)
"""

_TYPES: Final = """
TYPE SJsonValue : PVOID; END_TYPE
TYPE SJsonIterator : PVOID; END_TYPE
TYPE SJsonAIterator : PVOID; END_TYPE
TYPE DCTIME : ULINT; END_TYPE
TYPE FILETIME : ULINT; END_TYPE
TYPE EJsonType :
(
    eNullType := 0, eFalseType, eTrueType, eObjectType, eArrayType, eStringType, eNumberType
) DINT;
END_TYPE
"""

_BLOCK: Final = """
FUNCTION_BLOCK {name}
VAR_OUTPUT initStatus : HRESULT; END_VAR
VAR fieldrigHandle : DWORD; END_VAR
METHOD FieldrigJson : DWORD
IF fieldrigHandle = 0 THEN
    fieldrigHandle := {prefix}NEW();
END_IF;
FieldrigJson := fieldrigHandle;
END_METHOD
{methods}END_FUNCTION_BLOCK
"""
_DERIVED: Final = "FUNCTION_BLOCK {name} EXTENDS {base}\nEND_FUNCTION_BLOCK\n"
_LINE: Final = re.compile(r"(\w+)(?: : ([\w()]+))?(?: \((.*)\))?")
_TEXT: Final = "TEXT"
_WRITER: Final = "WRITER"
WRITER: Final = "FB_JsonSaxWriter"
PARSER: Final = "FB_JsonDomParser"
DATATYPE: Final = "FB_JsonReadWriteDatatype"
BLOCKS: Final = {PARSER: ("DOM", _DOM), WRITER: ("SAX", _SAX), DATATYPE: ("TYPE", _DATATYPE)}
_SUCCEEDS: Final = "IF NOT {name} THEN hrErrorCode := E_INVALIDARG; END_IF\n"
_NEW: Final = f"FUNCTION {PREFIX}NEW : DWORD {{native}} END_FUNCTION\n"


def native_name(kind: str, method: str) -> str:
    """Return the name of the native function behind a method, in small letters."""
    return f"{PREFIX}{kind}_{method}".lower()


def methods(kind: str) -> list[str]:
    """Return the names of the methods of DOM, SAX or TYPE, for which there are native functions."""
    lines = next(lines for known, lines in BLOCKS.values() if known == kind)
    return [line.split()[0] for line in lines.strip().splitlines()]


def _inputs(declared: str) -> list[tuple[str, str]]:
    return [(name, kind) for name, _, kind in (one.partition(" : ") for one in declared.split(", ") if one)]


_SECTIONS: Final = {_TEXT: ("VAR_IN_OUT CONSTANT", "STRING"), _WRITER: ("VAR_IN_OUT", WRITER)}
"""The sections and types of inputs that are handed over by reference."""


def _blocks(inputs: list[tuple[str, str]]) -> str:
    made = []
    for name, kind in inputs:
        section, spec = _SECTIONS.get(kind, ("VAR_INPUT", kind))
        made.append(f"{section} {name} : {spec}; END_VAR\n")
    return "".join(made)


def _method(kind: str, line: str) -> tuple[str, str]:
    """Return a method and the native function behind it."""
    found = _LINE.fullmatch(line)
    assert found is not None, line
    name, result, declared = found.groups(default="")
    inputs = _inputs(declared)
    returned, native = f" : {result}" if result else "", native_name(kind, name).upper()
    begin = f"{name} := " if result else ""
    handles = (f"{one}.FieldrigJson()" if sort == _WRITER else one for one, sort in inputs)
    given = ", ".join(("FieldrigJson()", *handles))
    outputs = "VAR_OUTPUT hrErrorCode : HRESULT; END_VAR\n" if kind != "DOM" else ""
    end = _SUCCEEDS.format(name=name) if kind == "TYPE" and result == "BOOL" else ""
    method = f"METHOD {name}{returned}\n{_blocks(inputs)}{outputs}{begin}{native}({given});\n{end}END_METHOD\n"
    natives = [(one, "DWORD" if sort == _WRITER else sort) for one, sort in inputs]
    blocks = _blocks([("document", "DWORD"), *natives])
    return method, f"FUNCTION {native}{returned}\n{blocks}{{native}} END_FUNCTION\n"


def text() -> str:
    """Return the source text of the library."""
    made = [_TYPES, _NEW]
    for name, (kind, lines) in BLOCKS.items():
        pairs = [_method(kind, line) for line in lines.strip().splitlines()]
        made += [native for _, native in pairs]
        made.append(_BLOCK.format(name=name, prefix=PREFIX, methods="".join(method for method, _ in pairs)))
    made.append(_DERIVED.format(name="FB_JsonDynDomParser", base=PARSER))
    return "".join(made)
