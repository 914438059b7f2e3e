"""The form of a source file follows from its content, and no document can do harm."""

import pytest
from exchange_documents import messages, pou, read, tc6, unit_of

from fieldrig_devices.iec.dialect import EPAS_4
from fieldrig_devices.iec.imports import read_source, xml


@pytest.mark.parametrize("name", ["belt.st", "belt.ST", "belt", "belt.exp", "belt.scl"])
def test_program_text_goes_to_the_parser_whatever_its_name(name: str) -> None:
    text = "\ufeffPROGRAM P VAR x : INT; END_VAR x := x + 1; END_PROGRAM"
    unit, mistakes = read_source(name, text, EPAS_4)
    assert mistakes == []
    assert unit.declarations == unit_of(text[1:]).declarations


def test_an_export_of_codesys_v23_is_program_text_with_comments() -> None:
    text = """
(* @NESTEDCOMMENTS := 'Yes' *)
(* @PATH := '' *)
(* @OBJECTFLAGS := '0, 8' *)
PROGRAM PLC_PRG
VAR
  n : INT;
END_VAR
(* @END_DECLARATION := '0' *)
n := n + 1;
END_PROGRAM
"""
    unit, mistakes = read_source("belt.exp", text, EPAS_4)
    assert mistakes == []
    assert unit.declarations == unit_of("PROGRAM PLC_PRG VAR n : INT; END_VAR n := n + 1; END_PROGRAM").declarations


def test_a_graphic_body_in_an_export_says_what_to_do() -> None:
    text = "(* @PATH := '' *)\nPROGRAM P\nVAR\nEND_VAR\n_LD_BODY\n_NETWORKS : 1\nEND_PROGRAM"
    _, (mistake,) = read_source("belt.exp", text, EPAS_4)
    assert str(mistake).startswith("belt.exp:5:1: The export contains a body in a graphic language")
    assert "Convert the POU to ST or IL" in mistake.hint


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("<", "The XML is damaged"),
        ("<a><b></a>", "The XML is damaged"),
        ("<html/>", "<html> is not the root of a known format; expected PLCopen XML (TC6), IEC 61131-10"),
        ('<pou xmlns="urn:other"/>', "<pou> is not the root of a known format"),
        ("<a>" * 300 + "</a>" * 300, "The XML is damaged: Excessive depth"),
    ],
)
def test_other_documents_are_a_message(text: str, expected: str) -> None:
    (message,) = messages(text)
    assert expected in message


ENTITY = '<!DOCTYPE project [<!ENTITY x "y">]>'
HOSTILE = [
    ENTITY,
    '<!DOCTYPE project [<!ENTITY x SYSTEM "file:///etc/passwd">]>',
    '<!DOCTYPE project SYSTEM "http://127.0.0.1/x.dtd">',
    '<!DOCTYPE project [<!ENTITY a "xxxxxxxxxx"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;"><!ENTITY x "&b;&b;&b;&b;">]>',
]


@pytest.mark.parametrize("doctype", HOSTILE)
@pytest.mark.parametrize("before", ["", '<?xml version="1.0"?>\n', "<!-- <a> -->", " <?style x?> <!--\n--> "])
def test_a_document_with_entities_is_refused(doctype: str, before: str) -> None:
    unit, mistakes = read(f"{before}{doctype}{tc6(pou('<ST>&x;</ST>'))}")
    assert unit.declarations == ()
    assert [mistake.what for mistake in mistakes] == ["The document has a document type declaration"]


def test_an_entity_that_nothing_declares_is_damage() -> None:
    (message,) = messages(tc6(pou("<ST>&x;</ST>")))
    assert "The XML is damaged" in message


def test_the_size_is_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(xml, "CHARACTERS", 100)
    (message,) = messages(tc6(pou("<ST>;</ST>")))
    assert "expected at most 100" in message


def test_the_encoding_of_the_declaration_does_not_matter_any_more() -> None:
    text = '<?xml version="1.0" encoding="UTF-16"?>\n' + tc6(pou("<ST>(* \u00e4 *) ;</ST>"))
    assert messages(text) == []


def test_characters_that_cannot_be_encoded_are_no_crash() -> None:
    assert isinstance(messages(tc6(pou("<ST>x := '\ud800';</ST>"))), list)


@pytest.mark.long
def test_a_flood_of_mistakes_is_cut_off() -> None:
    wires = "".join(f'<coil localId="{n}"><variable>m</variable></coil>' for n in range(2_000))
    assert len(messages(tc6(pou(f"<LD>{wires}</LD>")))) == 200


MSBUILD = '<Project xmlns="http://schemas.microsoft.com/developer/msbuild/2003"><ItemGroup/></Project>'


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("a/Belt.plcproj", MSBUILD, "This is the list of files of a TwinCAT PLC project"),
        ("Belt.PLCPROJ", MSBUILD, "hint: Give the folder that it is in"),
        ("Belt.tsproj", '<TcSmProject TcSmVersion="1.0"/>', "This is the list of parts of a TwinCAT project"),
        ("Belt.sln", "\ufeff\r\nMicrosoft Visual Studio Solution File, Format Version 12.00", "of a solution"),
        ("Belt.project", "PK\x03\x04\x14\0", "choose Project, Export PLCopenXML"),
        ("Belt.pro", "CoDeSys+\0\0\x01", "choose Project, Export, and give the .exp file"),
        ("Belt.xml", MSBUILD, "<Project> is not the root of a known format"),
    ],
)
def test_a_file_of_a_project_says_what_to_give_instead(name: str, text: str, expected: str) -> None:
    unit, mistakes = read_source(name, text, EPAS_4)
    assert unit.declarations == ()
    assert len(mistakes) == 1
    assert expected in str(mistakes[0]) or expected in f"hint: {mistakes[0].hint}"


def test_a_program_may_have_the_ending_of_a_library() -> None:
    """The content of a file says what it is."""
    assert read_source("belt.lib", "PROGRAM P VAR x : INT; END_VAR x := 1; END_PROGRAM", EPAS_4)[1] == []
