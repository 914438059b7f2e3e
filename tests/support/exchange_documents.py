"""Documents of exchange formats around a body, for tests, and what an import makes of them."""

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import EDITION_3
from fieldrig_devices.iec.imports import read_source
from fieldrig_devices.iec.parser import parse, parse_body
from fieldrig_devices.languages.mistakes import Mistake

LISTING_57 = """<?xml version="1.0" encoding="ISO-8859-1"?>
<pou>
  <accesslevels> rw,rw,r,rw,r,rw,rw,rw </accesslevels>
  <path> \\/languages </path>
  <name> ST_EXAMPLE </name>
  <flags> 4 </flags>
  <interface>
    <![CDATA[PROGRAM ST_EXAMPLE
VAR
  YVAL: INT := -250;
  BOTTOM: INT := -250;
  RUN_STRING: STRING(20) := 'Start';
        OFFSET: INT := 2;
    END_VAR
]]>
</interface>
<st>
  <body>
    <![CDATA[RUN_STRING:='Start';
    IF (YVAL < 0) THEN
      YVAL := YVAL + OFFSET;
    BOTTOM := YVAL + OFFSET;
    END_IF;
    ]]>
  </body>
</st>
</pou>
"""
"""Lines 6300 to 6333 of the PacDrive manual: an object of the ENI."""


def tc6(content: str, *, version: str = "0201", instances: str = "") -> str:
    """A project of PLCopen TC6 with this content of `types`."""
    return (
        f'<project xmlns="http://www.plcopen.org/xml/tc6_{version}" xmlns:xhtml="http://www.w3.org/1999/xhtml">'
        '<fileHeader companyName="" productName="test" productVersion="1" creationDateTime="2026-01-01T00:00:00"/>'
        f"<types>{content}</types><instances><configurations>{instances}</configurations></instances></project>"
    )


def pou(body: str, *, variables: dict[str, str] | None = None, kind: str = "program", more: str = "") -> str:
    """A POU with local variables, whose types are elements such as `<BOOL/>` or names of types."""
    declared = "".join(
        f'<variable name="{name}"><type>{of if of.startswith("<") else f"<{of}/>"}</type></variable>'
        for name, of in (variables or {}).items()
    )
    interface = f"<interface><localVars>{declared}</localVars></interface>"
    return f'<pous><pou name="P" pouType="{kind}">{interface}{more}<body>{body}</body></pou></pous>'


def point(*wires: str) -> str:
    """An input point: a wire is an identifier, or an identifier and the name of an output, `7.OUT`."""
    found = (wire.partition(".") for wire in wires)
    connections = "".join(
        f'<connection refLocalId="{source}"' + (f' formalParameter="{pin}"' if pin else "") + "/>"
        for source, _, pin in found
    )
    return f"<connectionPointIn>{connections}</connectionPointIn>"


def rail() -> str:
    return '<leftPowerRail localId="0"><position x="0" y="0"/><connectionPointOut formalParameter=""/></leftPowerRail>'


def contact(id: str, variable: str, *wires: str, attributes: str = "") -> str:
    return _operand("contact", id, variable, wires, attributes)


def coil(id: str, variable: str, *wires: str, attributes: str = "") -> str:
    return _operand("coil", id, variable, wires, attributes)


def _operand(name: str, id: str, variable: str, wires: tuple[str, ...], attributes: str) -> str:
    out = f"<connectionPointOut/><variable>{variable}</variable>"
    return f'<{name} localId="{id}" {attributes}>{point(*wires)}{out}</{name}>'


def source(id: str, expression: str, attributes: str = "") -> str:
    out = f"<connectionPointOut/><expression>{expression}</expression>"
    return f'<inVariable localId="{id}" {attributes}>{out}</inVariable>'


def sink(id: str, variable: str, *wires: str, attributes: str = "") -> str:
    return f'<outVariable localId="{id}" {attributes}>{point(*wires)}<expression>{variable}</expression></outVariable>'


def block(
    id: str, type: str, inputs: dict[str, str], outputs: str = "OUT", attributes: str = "", more: str = ""
) -> str:
    """A block; its inputs are wires by the name of the pin, its outputs names with blanks between them."""
    given = ""
    for pin, wire in inputs.items():
        name, _, modifiers = pin.partition(" ")
        given += f'<variable formalParameter="{name}" {modifiers}>{point(*filter(None, [wire]))}</variable>'
    results = "".join(f'<variable formalParameter="{pin}"><connectionPointOut/></variable>' for pin in outputs.split())
    return (
        f'<block localId="{id}" typeName="{type}" {attributes}><inputVariables>{given}</inputVariables>'
        f"<inOutVariables/><outputVariables>{results}</outputVariables>{more}</block>"
    )


def read(text: str, name: str = "test.xml") -> tuple[tree.Unit, list[Mistake]]:
    return read_source(name, text, EDITION_3)


def only_pou(text: str) -> tree.Pou:
    """The one POU of a document that has nothing wrong."""
    unit, mistakes = read(text)
    assert mistakes == []
    (found,) = (declaration for declaration in unit.declarations if isinstance(declaration, tree.Pou))
    return found


def statements(text: str) -> tuple[tree.AnyStatement, ...]:
    body = only_pou(text).body
    assert isinstance(body, tree.StBody)
    return body.statements


def st(text: str) -> tuple[tree.AnyStatement, ...]:
    """The statements of a body in Structured Text, with labels and jumps."""
    body, mistakes = parse_body(text, "expected", "ST", EDITION_3)
    assert mistakes == []
    assert isinstance(body, tree.StBody)
    return body.statements


def unit_of(text: str) -> tree.Unit:
    unit, mistakes = parse(text, "test.xml", EDITION_3)
    assert mistakes == []
    return unit


def messages(text: str) -> list[str]:
    """The mistakes of a document, without notes."""
    return [str(mistake) for mistake in read(text)[1] if not mistake.is_note]
