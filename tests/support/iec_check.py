"""Checking a source text, for tests of the language: its program, its messages, the type of an expression."""

from collections.abc import Sequence
from functools import cache

from fieldrig.clock import VirtualClock
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import check
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.declarations import Declarations
from fieldrig_devices.iec.check.expressions import Expressions
from fieldrig_devices.iec.check.project import Project
from fieldrig_devices.iec.dialect import EPAS_4, Dialect
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.host import Library, NativeFunction
from fieldrig_devices.iec.library.selection import needed
from fieldrig_devices.iec.library.sources import sources
from fieldrig_devices.iec.limits import MAX_4, Limits
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.program import ConfiguredObject, Program, Variable
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.iec.types import ObjectParameter, ObjectType, Type
from fieldrig_devices.languages.mistakes import Mistake

MC_4 = ObjectType(
    "MC_4",
    (
        ObjectParameter("AxisState", 3, Elementary.DINT),
        ObjectParameter("Enable", 4, Elementary.BOOL, is_writable=True),
    ),
)
CONTROLLER = ObjectType("PacDriveM", (ObjectParameter("Timer1", 7, Elementary.DINT),))
LIBRARY = """
FUNCTION ControllerEnableSet : DINT
VAR_INPUT lAxis : DINT; END_VAR
{native}
END_FUNCTION
"""
LIBRARIES = (Library("MAx-4.lib", LIBRARY, {"controllerenableset": NativeFunction(lambda axis: (0,))}, {}),)


class ConfiguredHost(StandaloneHost):
    """A controller with an axis and its own parameters; programs are only checked against it."""

    def __init__(self, libraries: Sequence[Library] = LIBRARIES) -> None:
        super().__init__(VirtualClock())
        self.libraries = libraries
        self.object_types = {"mc_4": MC_4, "pacdrivem": CONTROLLER}
        self.objects = {
            "axis_10": ConfiguredObject("Axis_10", MC_4, 0x5000),
            "pacdrivem": ConfiguredObject("PacDriveM", CONTROLLER, 0x100),
        }


@cache
def parsed(text: str, name: str, dialect: Dialect) -> tree.Unit:
    """Parse a text, which must have no mistakes."""
    unit, mistakes = parse(text, name, dialect)
    assert not mistakes, mistakes
    return unit


def checked(
    *texts: str,
    dialect: Dialect = EPAS_4,
    limits: Limits = MAX_4,
    host: ConfiguredHost | None = None,
    with_libraries: bool = True,
) -> tuple[Program, list[Mistake]]:
    """Check texts, which must have no mistakes for the parser, together with the libraries."""
    host = host or ConfiguredHost()
    files = [*sources(dialect.name), *((library.name, library.text) for library in host.libraries)]
    files = files if with_libraries else []
    own = [parsed(text, f"{number}.st", dialect) for number, text in enumerate(texts, 1)]
    libraries = needed([parsed(text, name, dialect) for name, text in files], own, texts)
    return check([*libraries, *own], host, dialect, limits=limits)


def messages(
    *texts: str,
    dialect: Dialect = EPAS_4,
    limits: Limits = MAX_4,
    notes: bool = False,
    host: ConfiguredHost | None = None,
) -> list[str]:
    """Return the messages about the texts as `line:column what; expected`."""
    _, mistakes = checked(*texts, dialect=dialect, limits=limits, host=host)
    return [
        f"{found.line}:{found.column} {found.what}" + (f"; {found.expected}" if found.expected else "")
        for found in mistakes
        if notes or not found.is_note
    ]


def hints(*texts: str) -> list[str]:
    return [found.hint for found in checked(*texts)[1] if not found.is_note]


def program(declarations: str, statements: str = "", before: str = "") -> str:
    """A PROGRAM with its statements in line 3; what stands before it is in line 1."""
    return f"{before} PROGRAM PLC_PRG VAR {declarations} END_VAR\n\n{statements}\nEND_PROGRAM"


def variables(declarations: str, before: str = "", with_libraries: bool = True) -> dict[str, Variable]:
    """The checked variables of a program, which has no mistakes."""
    found, mistakes = checked(program(declarations, before=before), with_libraries=with_libraries)
    assert not [mistake for mistake in mistakes if not mistake.is_note], mistakes
    return found.pous["plc_prg"].variables


def type_of(expression: str, declarations: str = "", dialect: Dialect = EPAS_4, before: str = "") -> Type:
    """The type of an expression in a program with these declarations."""
    project = Project(ConfiguredHost(), dialect, MAX_4)
    units = [parsed(text, name, dialect) for name, text in sources(dialect.name)]
    units.append(parsed(program(declarations, f"result_ := {expression};", before), "1.st", dialect))
    Declarations(project, frozenset()).declare(units)
    source = project.sources[project.pous["plc_prg"]]
    assert isinstance(source.tree.body, tree.StBody)
    statement = source.tree.body.statements[0]
    assert isinstance(statement, tree.Assign)
    found = Expressions(Context(project, source, "1.st")).expression(statement.value)
    assert not [mistake for mistake in project.reports.mistakes if not mistake.is_note], project.reports.mistakes
    assert found is not None
    return found.type
