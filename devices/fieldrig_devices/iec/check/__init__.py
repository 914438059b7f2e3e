"""The checker: it turns the trees of all source files into the checked program and reports all mistakes at once.

    context.py, project.py          what names mean, in a body and in the whole project
    declarations.py                 the order of work for declarations
      type_specs.py, variables.py, initials.py, located.py, sizes.py, configured.py, tasks.py
    checker.py, expressions.py      what the bodies of all languages stand on, as a protocol and as the class
      places.py (elements.py, writing.py), operators.py, times.py, calls.py (standard.py, special.py), arguments.py,
      assignable.py, implicit.py, constants.py, untyped.py
    statements.py, blocks.py        Structured Text; il.py and sfc.py are beside it
    whole.py                        the whole project: limits, recursion, final sizes

Source: PacDrive manual 4.2 to 4.3 (digest 1.16, 1.19, 2.2, 2.3).  Where it is silent the rule is that of CoDeSys V2.3,
and then that of IEC 61131-3; the place of the rule says so.  A mistake has no follow-on mistakes: an unknown name is
reported once in each body, and what depends on it is left alone.
"""

from collections.abc import Callable, Collection, Sequence

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import bodies, configured, edges, enable, whole
from fieldrig_devices.iec.check.declarations import Declarations
from fieldrig_devices.iec.check.dispatch import Dispatchers
from fieldrig_devices.iec.check.extension import Extension
from fieldrig_devices.iec.check.project import Project
from fieldrig_devices.iec.check.startup import Startup
from fieldrig_devices.iec.check.tasks import Tasks
from fieldrig_devices.iec.dialect import EPAS_4, Dialect
from fieldrig_devices.iec.host import Host
from fieldrig_devices.iec.library.sources import sources
from fieldrig_devices.iec.limits import MAX_4, Limits
from fieldrig_devices.iec.program import Program
from fieldrig_devices.languages.mistakes import Mistake


def check(
    units: Sequence[tree.Unit],
    host: Host,
    dialect: Dialect = EPAS_4,
    *,
    library_files: Collection[str] | None = None,
    limits: Limits = MAX_4,
    resource: str = "",
    extension: Extension | None = None,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> tuple[Program, list[Mistake]]:
    """Check the files of a project with those of its libraries.

    `library_files` are the names of units that belong to libraries, by default the standard library's and the host's;
    the project may redefine their names. `resource` is the one that runs, if there are several. The program may be used
    if no mistake is more than a note. Mistakes are in the order of files and lines. `on_progress` is called after each
    body. An `extension` adds statements for tests.
    """
    if library_files is None:
        library_files = [*(name for name, _ in sources(dialect.name)), *(known.name for known in host.libraries)]
    project = Project(host, dialect, limits, extension)
    declarations = Declarations(project, frozenset(library_files), resource)
    declarations.declare(units)
    links = configured.apply(project, declarations.config_blocks, declarations.variables.incomplete)
    Tasks(project).configure(declarations.configurations)
    dispatchers = Dispatchers(project)
    dispatchers.begin()
    startup = Startup(project)
    startup.begin()
    if extension is not None:
        extension.begin(project)
    done = 0
    while done < len(project.sources):  # a body may need a further function that starts its variables
        # charts first: other bodies may look at their steps, which are variables from then on
        for source in sorted(list(project.sources.values())[done:], key=bodies.has_no_chart):
            bodies.check_pou(project, source, startup)
            done += 1
            on_progress(done, len(project.sources))
    startup.finish()
    dispatchers.finish()
    edges.begin_bodies(project)
    enable.begin_bodies(project)
    whole.check(project, declarations.variables.lists)
    types = declarations.specs.declared()
    result = Program(project.pous, project.globals, types, project.tasks, host.objects, links, dialect)
    if extension is not None:
        extension.finish(result)
    order = {unit.file: number for number, unit in enumerate(units)}
    mistakes = dict.fromkeys(project.reports.mistakes)
    return result, sorted(mistakes, key=lambda mistake: (order.get(mistake.file, -1), mistake.line, mistake.column))
