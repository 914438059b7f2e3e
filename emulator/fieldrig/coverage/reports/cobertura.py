"""Coverage in Cobertura's form.

Source: coverage-04.dtd of Cobertura 1.9.  A class is a POU; its lines are those of the file.
"""

from pathlib import Path
from xml.etree import ElementTree as Xml

from fieldrig.coverage.places import Kind
from fieldrig.coverage.summary import Count, Coverage, Part, pous

_HEAD = (
    b'<?xml version="1.0" encoding="utf-8"?>\n'
    b'<!DOCTYPE coverage SYSTEM "http://cobertura.sourceforge.net/xml/coverage-04.dtd">\n'
)


def cobertura(coverage: Coverage) -> bytes:
    """Return the report.  Its time is 0, so that the same coverage gives the same file."""
    files = coverage.files()
    every = [has_run for file in files for has_run in file.lines().values()]
    lines, branches = Count(sum(every), len(every)), coverage.total.count(Kind.BRANCH)
    root = Xml.Element("coverage", _rates(lines, branches))
    root.attrib |= {
        "lines-covered": str(lines.run),
        "lines-valid": str(lines.all),
        "branches-covered": str(branches.run),
        "branches-valid": str(branches.all),
        "complexity": "0",
        "version": "fieldrig",
        "timestamp": "0",
    }
    Xml.SubElement(Xml.SubElement(root, "sources"), "source").text = Path.cwd().as_posix()
    packages = Xml.SubElement(root, "packages")
    for file in files:
        package = Xml.SubElement(packages, "package", {"name": file.name} | _part_rates(file))
        classes = Xml.SubElement(package, "classes")
        for pou in pous(file):
            _class(classes, file.name, pou)
    Xml.indent(root)
    return _HEAD + bytes(Xml.tostring(root, encoding="utf-8")) + b"\n"


def _class(classes: Xml.Element, file: str, pou: Part) -> None:
    node = Xml.SubElement(classes, "class", {"name": pou.name, "filename": file} | _part_rates(pou))
    Xml.SubElement(node, "methods")
    lines, branches = Xml.SubElement(node, "lines"), pou.branches()
    for line, has_run in pou.lines().items():
        shown = Xml.SubElement(lines, "line", number=str(line), hits=str(int(has_run)))
        if line in branches:
            taken = Count(sum(one for _, one in branches[line]), len(branches[line]))
            shown.attrib |= {
                "branch": "true",
                "condition-coverage": f"{int(taken.per_cent)}% ({taken.run}/{taken.all})",
            }


def _part_rates(part: Part) -> dict[str, str]:
    lines = part.lines()
    return _rates(Count(sum(lines.values()), len(lines)), part.count(Kind.BRANCH)) | {"complexity": "0"}


def _rates(lines: Count, branches: Count) -> dict[str, str]:
    return {"line-rate": _rate(lines), "branch-rate": _rate(branches)}


def _rate(count: Count) -> str:
    return f"{count.per_cent / 100:.4f}"
