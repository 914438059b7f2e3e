"""The links of a TwinCAT project between outputs and inputs of its own programs.

Source: the public form of `.tsproj`: `Mappings` with `OwnerA`, `OwnerB` and `Link`, whose ends are `TASK Inputs^PATH`
and `TASK Outputs^PATH`.  Links with hardware are left out.
"""

import re
from typing import Final

from fieldrig_devices.iec.imports.report import Report
from fieldrig_devices.iec.imports.xml import Element, attribute, element, elements, read_xml

Link = tuple[str, str]
"""The paths of an output and of the input that gets its value."""
_END: Final = re.compile(r"[^^]* (Inputs|Outputs)\^([\w.\[\],]+)")


def links_of(text: str, report: Report) -> list[Link]:
    """Return the links in a project; none if it has none, or is damaged."""
    root = read_xml(text, report)
    owners = elements(element(root, "Mappings"), "OwnerA") if root is not None else []
    links = [
        _link(link)
        for owner in owners
        for other in elements(owner, "OwnerB")
        if attribute(other, "Name") == attribute(owner, "Name")
        for link in elements(other, "Link")
    ]
    return [link for link in links if link is not None]


def _link(node: Element) -> Link | None:
    ends = [_END.fullmatch(attribute(node, name)) for name in ("VarA", "VarB")]
    paths = {match[1]: match[2] for match in ends if match is not None}
    return (paths["Outputs"], paths["Inputs"]) if len(paths) == len(ends) else None
