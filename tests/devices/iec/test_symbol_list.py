"""The symbol list in XML, compared with the form of a file that CODESYS V3.5 wrote."""

from xml.etree import ElementTree as ET

from fieldrig.clock import VirtualClock
from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.iec.symbol_list import symbol_list
from fieldrig_devices.languages.source_file import SourceFile

# The program of a documented example of CODESYS V3.5 SP12, in a shorter form.
PROGRAM = """
TYPE Spot : STRUCT X : INT; (* to the right *) Y : REAL; Name : STRING; END_STRUCT END_TYPE
TYPE Colour : (red, green := 5); END_TYPE
FUNCTION_BLOCK Belt VAR_INPUT run : BOOL; END_VAR VAR_OUTPUT speed : REAL; END_VAR END_FUNCTION_BLOCK
VAR_GLOBAL CONSTANT highest : INT := 3; END_VAR
PROGRAM PLC_PRG
VAR d1arr : ARRAY[0..10] OF INT; d2arr : ARRAY[0..10, 0..20] OF DWORD; ok : BOOL; (* all is well *)
    points : ARRAY[0..5] OF Spot; colour : Colour; belt : Belt; small : INT(0..10); since : TOD; END_VAR
ok := TRUE;
END_PROGRAM
"""
NS = {"s": "http://www.3s-software.com/schemas/Symbolconfiguration.xsd"}


def listed() -> ET.Element:
    compiled = compile_project([SourceFile("plc.st", PROGRAM)], StandaloneHost(VirtualClock()))
    data = symbol_list(compiled.symbols, "test", "Device")
    assert data.startswith(b'<?xml version="1.0" encoding="utf-8"?>\n<Symbolconfiguration xmlns=')
    return ET.fromstring(data)


def types(root: ET.Element) -> dict[str, ET.Element]:
    found = root.find("s:TypeList", NS)
    assert found is not None
    return {element.get("name", ""): element for element in found}


def test_the_nodes_are_the_variables_below_their_programs() -> None:
    root = listed()
    own = root.findall("s:NodeList/s:Node[@name='Application']/s:Node[@name='PLC_PRG']/s:Node", NS)
    assert {node.get("name"): node.get("type") for node in own} == {
        "belt": "T_Belt",
        "colour": "T_Colour",
        "d1arr": "T_ARRAY__0__10__OF_INT",
        "d2arr": "T_ARRAY__0__10__0__20__OF_DWORD",
        "ok": "T_BOOL",
        "points": "T_ARRAY__0__5__OF_Spot",
        "since": "T_TIME_OF_DAY",
        "small": "T_INT__0__10",
    }
    assert {node.get("access") for node in own} == {"ReadWrite"}
    highest = root.find("s:NodeList/s:Node/s:Node[@name='highest']", NS)
    assert highest is not None
    assert highest.attrib == {"name": "highest", "type": "T_INT", "access": "Read"}


def test_the_types_are_those_of_codesys() -> None:
    found = types(listed())
    assert found["T_BOOL"].attrib == {
        "name": "T_BOOL", "size": "1", "swapsize": "0", "typeclass": "Bool", "iecname": "BOOL",
    }  # fmt: skip
    assert found["T_DWORD"].get("swapsize") == "4"
    assert found["T_STRING"].attrib == {
        "name": "T_STRING", "size": "81", "swapsize": "0", "typeclass": "String", "iecname": "STRING",
    }  # fmt: skip
    grid = found["T_ARRAY__0__10__0__20__OF_DWORD"]
    assert grid.attrib == {
        "name": "T_ARRAY__0__10__0__20__OF_DWORD", "size": "924", "nativesize": "924", "typeclass": "Array",
        "iecname": "ARRAY [0..10, 0..20] OF DWORD", "basetype": "T_DWORD",
    }  # fmt: skip
    assert [element.attrib for element in grid] == [
        {"minrange": "0", "maxrange": "10"}, {"minrange": "0", "maxrange": "20"},
    ]  # fmt: skip


def test_structures_enumerations_and_blocks_are_user_defined() -> None:
    found = types(listed())
    point = found["T_Spot"]
    assert (point.get("typeclass"), point.get("pouclass"), point.get("size")) == ("Userdef", "STRUCTURE", "87")
    assert [(element.get("iecname"), element.get("type"), element.get("byteoffset")) for element in point] == [
        ("X", "T_INT", "0"), ("Y", "T_REAL", "2"), ("Name", "T_STRING", "6"),
    ]  # fmt: skip
    assert [(element.get("iecname"), element.get("enumvalue")) for element in found["T_Colour"]] == [
        ("red", "0"),
        ("green", "5"),
    ]
    belt = found["T_Belt"]
    assert belt.get("pouclass") == "FUNCTION_BLOCK"
    assert [(element.get("iecname"), element.get("vartype")) for element in belt] == [
        ("run", "VAR_INPUT"),
        ("speed", "VAR_OUTPUT"),
    ]
    small = found["T_INT__0__10"]
    assert (small.get("basetype"), small.get("lowerborder"), small.get("upperborder")) == ("T_INT", "0", "10")


def test_every_type_is_listed_before_it_is_used() -> None:
    root = listed()
    known: set[str | None] = set()
    for element in types(root).values():
        used = {element.get("basetype"), *(part.get("type") for part in element)} - {None}
        assert used <= known
        known.add(element.get("name"))
    assert {node.get("type") for node in root.iterfind(".//s:Node", NS)} - {None} <= known


def test_comments_come_along() -> None:
    root = listed()
    ok = root.find(".//s:Node[@name='ok']/s:Comment", NS)
    right = root.find(".//s:UserDefElement[@iecname='X']/s:Comment", NS)
    assert ok is not None
    assert right is not None
    assert (ok.text, right.text) == ("all is well", "to the right")
