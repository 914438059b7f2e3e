"""The task configuration: tasks with their priority and kind, and the programs that they run (digest 1.4)."""

from collections.abc import Sequence
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.expressions import Expressions
from fieldrig_devices.iec.check.project import Project
from fieldrig_devices.iec.check.texts import a, text
from fieldrig_devices.iec.program import Pou, Task, TaskKind, Variable
from fieldrig_devices.iec.tree import PouKind
from fieldrig_devices.iec.types import Elementary

LOWEST_PRIORITY: Final = 31
DEFAULT_PRIORITY: Final = 16
"""The priority of a task that gives none, and of the one that is made if there is no task configuration."""
DEFAULT_INTERVAL_MS: Final = 10.0
MAIN: Final = "plc_prg"
"""The program that CoDeSys runs if there is no task configuration."""


class Tasks:
    def __init__(self, project: Project) -> None:
        self._project = project
        self._tasks: dict[str, Task] = {}
        self._places: dict[str, tree.Place] = {}

    def configure(self, configurations: Sequence[tuple[tree.Configuration, str]]) -> None:
        found = [(node, file) for node, file in configurations if node.tasks or node.programs]
        if not found:
            self._without_configuration()
        for node, file in found:
            context = Context(self._project, None, file)
            for task in node.tasks:
                self._task(task, context)
            for instance in node.programs:
                self._program(instance, context)
        self._check()
        self._project.tasks = list(self._tasks.values())

    def _without_configuration(self) -> None:
        programs = [pou for pou in self._project.pous.values() if pou.kind is PouKind.PROGRAM]
        main = self._project.pous.get(MAIN)
        if main is None and len(programs) == 1:
            main = programs[0]
        reports = self._project.reports
        if main is not None:
            place = self._project.sources[main].tree.place
            reports.note(
                main.file,
                place,
                f"{main.name} runs every {DEFAULT_INTERVAL_MS:g} ms, because there is no task configuration",
                "write CONFIGURATION with TASK and PROGRAM ... WITH ...",
            )
            task = Task(
                main.name,
                TaskKind.CYCLIC,
                DEFAULT_PRIORITY,
                DEFAULT_INTERVAL_MS,
                None,
                [main],
                main.file,
                place.line,
                is_default=True,
            )
            self._tasks[MAIN] = task
        elif programs:
            names = ", ".join(pou.name for pou in programs[:8])
            place = self._project.sources[programs[0]].tree.place
            reports.say(
                programs[0].file,
                place,
                f"no task runs any of the programs {names}",
                "a task configuration",
                "name one of them PLC_PRG, or write CONFIGURATION",
            )

    # ---- tasks

    def _task(self, node: tree.TaskDeclaration, context: Context) -> None:
        name = context.key(node.name)
        if name in self._tasks:
            context.say(node, f"the task {node.name} is declared twice", "another name")
            return
        self._places[name] = node.place
        priority = self._priority(node, context)
        interval = self._interval(node, context)
        event = self._event(node.single, context) if node.single is not None else None
        kind = TaskKind.EVENT if node.single is not None else TaskKind.CYCLIC if interval else TaskKind.FREE
        self._tasks[name] = Task(node.name, kind, priority, interval, event, [], context.file, node.place.line)

    def _priority(self, node: tree.TaskDeclaration, context: Context) -> int:
        if node.priority is None:
            return DEFAULT_PRIORITY
        found = Expressions(context).constant_integer(node.priority)
        if found is not None and not 0 <= found <= LOWEST_PRIORITY:
            context.say(node.priority, f"the priority {found}", f"0 (highest) to {LOWEST_PRIORITY} (PD-061)")
        return found if found is not None else DEFAULT_PRIORITY

    def _interval(self, node: tree.TaskDeclaration, context: Context) -> float:
        """Milliseconds; 0 for a free-running task."""
        if node.interval is None:
            return 0.0
        found = Expressions(context).constant_as(node.interval, Elementary.TIME)
        if found is not None and found.value == 0:
            context.say(
                node.interval, "the interval is 0", "a TIME such as T#10ms, or no INTERVAL for a free-running task"
            )
        return float(found.value) if found is not None else 0.0

    def _event(self, node: tree.Expression, context: Context) -> Variable | None:
        found = context.find(node.text) if isinstance(node, tree.Name) else None
        if isinstance(found, Variable) and found.type is Elementary.BOOL:
            return found
        if found is None and isinstance(node, tree.Name):
            context.say_unknown(node, node.text, "a global BOOL behind SINGLE")
        else:
            context.say(node, f"{text(node)} starts an event task", "a global BOOL behind SINGLE")
        return None

    # ---- programs

    def _program(self, node: tree.ProgramInstance, context: Context) -> None:
        pou = self._project.pous.get(context.key(node.type))
        if pou is None or pou.kind is not PouKind.PROGRAM:
            programs = [name for name, known in self._project.pous.items() if known.kind is PouKind.PROGRAM]
            hint = self._project.reports.closest(node.type, programs)
            what = (
                f"{node.type} is {a(pou.kind.value)}" if pou is not None else f"the program {node.type} is not declared"
            )
            context.say(node, what, "the name of a PROGRAM", hint)
        task = self._tasks.get(context.key(node.task)) if node.task else self._free(node, context)
        if task is None:
            hint = self._project.reports.closest(node.task, self._tasks)
            context.say(node, f"there is no task {node.task}", "the name of a TASK", hint)
            return
        if isinstance(pou, Pou) and pou.kind is PouKind.PROGRAM:
            task.programs.append(pou)
        else:
            task.programs.append(NO_PROGRAM)

    def _free(self, node: tree.ProgramInstance, context: Context) -> Task:
        """A program without WITH runs free, at the lowest priority (IEC 61131-3)."""
        task = Task(node.name, TaskKind.FREE, LOWEST_PRIORITY, 0.0, None, [], context.file, node.place.line)
        name = context.key(node.name)
        self._tasks[name], self._places[name] = task, node.place
        return task

    def _check(self) -> None:
        reports, limit = self._project.reports, self._project.limits.tasks
        if len(self._tasks) > limit:
            name, last = list(self._tasks.items())[limit]
            reports.say(last.file, self._places[name], f"{len(self._tasks)} tasks", f"at most {limit} (PD-310)")
        for name, task in self._tasks.items():
            if not task.programs:
                reports.say(
                    task.file,
                    self._places[name],
                    f"the task {task.name} names no program",
                    f"PROGRAM ... WITH {task.name} : ...; (PD-033)",
                )
            task.programs = [pou for pou in task.programs if pou is not NO_PROGRAM]


NO_PROGRAM: Final = Pou(PouKind.PROGRAM, "", "")
"""Stands for a program that was not found, so that its task has no second mistake."""
