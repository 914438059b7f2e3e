"""The resource that a controller runs: a configuration may have several, and a controller is one of them.

Source: PacDrive manual 596 to 610; IEC 61131-3, 2.7.  The tasks of the other resources are left out.  Their global
variables remain, so that programs which only those resources run still compile.
"""

from collections.abc import Iterator, Sequence

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.project import Project


def chosen(project: Project, units: Sequence[tree.Unit], wanted: str) -> str:
    """Return the key of the resource that runs, empty if the source names none.

    There is a message if the setting is missing although there are several, or names one that does not exist.
    """
    resources: dict[str, tuple[str, tree.Position, str]] = {}
    for unit in units:
        for node in unit.declarations:
            if isinstance(node, tree.Configuration):
                for part in parts(node):
                    if part.resource:
                        resources.setdefault(project.key(part.resource), (part.resource, part.position, unit.file))
    names = ", ".join(name for name, _, _ in resources.values())
    if wanted and project.key(wanted) not in resources:
        _, position, file = next(iter(resources.values()), ("", tree.Position(1, 1), units[-1].file if units else ""))
        project.reports.say(file, position, f"there is no resource {wanted}", names or "a RESOURCE in the source")
    elif not wanted and len(resources) > 1:
        _, position, file = list(resources.values())[1]
        what = f"there are the resources {names}, and a controller runs one of them"
        project.reports.say(file, position, what, "the key resource of the controller, or --resource, with its name")
    return project.key(wanted) if project.key(wanted) in resources else next(iter(resources), "")


def parts(node: tree.Configuration) -> Iterator[tree.Configuration]:
    """Yield a configuration itself, and the resources in it if there are several."""
    yield node
    yield from node.resources
