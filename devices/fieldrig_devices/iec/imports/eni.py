"""Objects of the ENI, the engineering interface of EPAS-4 and CoDeSys V2.3: XML around declarations and a body.

Source: PacDrive manual 6289 to 6333 (PD-345).  Access rights, path and flags have no meaning for the controller.
"""

import re
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.imports.pieces import Pieces
from fieldrig_devices.iec.imports.report import Report
from fieldrig_devices.iec.imports.xml import Element, element, elements, line_of, name_of, text_of
from fieldrig_devices.iec.parser import parse

ROOTS: Final = ("pou", "dut", "gvl", "object")
_TEXTS: Final = ("st", "il")
_DRAWN: Final = ("fbd", "ld", "sfc", "cfc")
_POU: Final = re.compile(r"\b(PROGRAM|FUNCTION_BLOCK|FUNCTION)\b", re.IGNORECASE)


def read_object(root: Element, report: Report, dialect: Dialect) -> tree.Unit:
    """A POU, or an object that consists of declarations alone."""
    name = text_of(element(root, "name")).strip()
    interface = element(root, "interface")
    pieces = Pieces()
    with report.inside(f"object {name[:60]}" if name else "object"):
        if interface is None:
            report.mistake(line_of(root), "The object has no <interface>", "the declarations in <interface>")
        else:
            pieces.add(text_of(interface), line_of(interface))
        kind = _POU.search(pieces.text())
        for part in elements(root, *_DRAWN):
            report.mistake(
                line_of(part),
                f"The body is in {name_of(part).upper()}, whose form in the ENI is not published",
                "a body in ST or IL",
                "Convert the POU to ST or IL in the programming system, and fetch it again.",
            )
        for part in elements(root, *_TEXTS):
            body = element(part, "body")
            pieces.add(text_of(part if body is None else body), line_of(part if body is None else body))
        if kind is not None:
            pieces.close(f"END_{kind.group().upper()}")
        unit, mistakes = parse(pieces.text(), report.file, dialect)
        report.take(mistakes)
    return unit
