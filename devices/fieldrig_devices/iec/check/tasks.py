"""The task configuration: tasks with their priority and kind, and the programs that they run (digest 1.4)."""

from collections.abc import Sequence
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.expressions import Expressions
from fieldrig_devices.iec.check.project import Project
from fieldrig_devices.iec.check.texts import a, text
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.literal_texts import time_text
from fieldrig_devices.iec.program import Pou, Task, TaskKind, Variable
from fieldrig_devices.iec.tree import PouKind

LOWEST_PRIORITY: Final = 31
DEFAULT_PRIORITY: Final = LOWEST_PRIORITY
"""The priority of a task that gives none, and of the one that is made if there is no task configuration: the dialog of
EPAS-4 proposes 31 (manual 3705)."""
DEFAULT_INTERVAL_MS: Final = 10.0
MAINS: Final = ("plc_prg", "main")
"""The programs that CoDeSys and TwinCAT run if there is no task configuration."""


class Tasks:
    def __init__(self, project: Project) -> None:
        self._project = project
        self._tasks: dict[str, Task] = {}
        self._places: dict[str, tree.Position] = {}
        self._names: dict[Pou, str] = {}
        """The first name that a configuration gives each program."""

    def configure(self, configurations: Sequence[tuple[tree.Configuration, str]]) -> None:
        configured = [(node, file) for node, file in configurations if node.tasks or node.programs]
        if not configured:
            self._without_configuration()
        for node, file in configured:
            context = Context(self._project, None, file)
            for task in node.tasks:
                self._task(task, context)
            for instance in node.programs:
                self._program(instance, context)
        if self._project.dialect.allows_idle_tasks:
            self._give_main()
        self._check()
        self._project.tasks = list(self._tasks.values())

    def _without_configuration(self) -> None:
        programs, main, reports = self._programs(), self._main(), self._project.reports
        if main is not None:
            position = self._project.sources[main].tree.position
            reports.note(
                main.file,
                position,
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
                position.line,
                is_default=True,
            )
            self._tasks[MAINS[0]] = task
        elif programs and self._project.extension is None:  # a test calls the programs itself
            names = ", ".join(pou.name for pou in programs[:8])
            position = self._project.sources[programs[0]].tree.position
            reports.say(
                programs[0].file,
                position,
                f"no task runs any of the programs {names}",
                "a task configuration",
                "name one of them PLC_PRG, or write CONFIGURATION",
            )

    def _programs(self) -> list[Pou]:
        return [pou for pou in self._project.pous.values() if pou.kind is PouKind.PROGRAM]

    def _main(self) -> Pou | None:
        """Return the program that runs if no task names one."""
        programs = self._programs()
        named = [pou for name in MAINS if (pou := self._project.pous.get(name)) in programs]
        return named[0] if named else programs[0] if len(programs) == 1 else None

    def _give_main(self) -> None:
        """Let the first task run the main program if none of the tasks names a program, as older files of TwinCAT."""
        main, first = self._main(), next(iter(self._tasks.items()), None)
        if main is not None and first is not None and not any(task.programs for task in self._tasks.values()):
            name, task = first
            task.programs.append(main)
            what = f"the task {task.name} names no program, and runs {main.name}"
            self._project.reports.note(task.file, self._places[name], what)

    # ---- tasks

    def _task(self, node: tree.TaskDeclaration, context: Context) -> None:
        name = context.key(node.name)
        if name in self._tasks:
            context.say(node, f"the task {node.name} is declared twice", "another name")
            return
        self._places[name] = node.position
        priority = self._priority(node, context)
        interval = self._interval(node, context)
        event = self._event(node.single, context) if node.single is not None else None
        kind = TaskKind.EVENT if node.single is not None else TaskKind.CYCLIC if interval else TaskKind.FREE
        self._tasks[name] = Task(node.name, kind, priority, interval, event, [], context.file, node.position.line)

    def _priority(self, node: tree.TaskDeclaration, context: Context) -> int:
        if node.priority is None:
            return DEFAULT_PRIORITY
        priority = Expressions(context).constant_integer(node.priority)
        lowest = context.project.dialect.lowest_priority
        if priority is not None and not 0 <= priority <= lowest:
            context.say(node.priority, f"the priority {priority}", f"0 (highest) to {lowest} (PD-061)")
        return priority if priority is not None else DEFAULT_PRIORITY

    def _interval(self, node: tree.TaskDeclaration, context: Context) -> float:
        """Milliseconds; 0 for a free-running task."""
        if node.interval is None:
            return 0.0
        interval = Expressions(context).constant_as(node.interval, context.project.dialect.time)
        if interval is not None and int(interval.value) <= 0:
            shown = time_text(int(interval.value)) if interval.value else "0"
            expected = "a TIME such as T#10ms, or no INTERVAL for a free-running task"
            context.say(node.interval, f"the interval is {shown}", expected)
        return float(interval.value) if interval is not None else 0.0

    def _event(self, node: tree.Expression, context: Context) -> Variable | None:
        entity = context.find(node.text) if isinstance(node, tree.Name) else None
        if isinstance(entity, Variable) and entity.type is Elementary.BOOL:
            return entity
        if entity is None and isinstance(node, tree.Name):
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
            self._note_shared(node, pou, context)
            task.programs.append(pou)
            task.instances.setdefault(context.key(node.name), pou)
        else:
            task.programs.append(NO_PROGRAM)

    def _note_shared(self, node: tree.ProgramInstance, pou: Pou, context: Context) -> None:
        """Note that two names are one program, where edition 3 of the standard has two with their own variables."""
        name = context.key(node.name)
        first = self._names.setdefault(pou, node.name)
        if context.key(first) != name and pou.variables:
            what = f"{first} and {node.name} are one program {pou.name}, with the same variables"
            context.note(node, what, "a FUNCTION_BLOCK with two instances has its variables twice")

    def _free(self, node: tree.ProgramInstance, context: Context) -> Task:
        """A program without WITH runs free, at the lowest priority (IEC 61131-3)."""
        lowest = max([LOWEST_PRIORITY, *(task.priority for task in self._tasks.values())])
        task = Task(node.name, TaskKind.FREE, lowest, 0.0, None, [], context.file, node.position.line)
        name = context.key(node.name)
        self._tasks[name], self._places[name] = task, node.position
        return task

    def _check(self) -> None:
        reports, limit = self._project.reports, self._project.limits.tasks
        if len(self._tasks) > limit:
            name, last = list(self._tasks.items())[limit]
            reports.say(last.file, self._places[name], f"{len(self._tasks)} tasks", f"at most {limit} (PD-310)")
        for name, task in list(self._tasks.items()):
            if not task.programs and self._project.dialect.allows_idle_tasks:
                reports.note(task.file, self._places[name], f"the task {task.name} names no program", "it is left out")
                del self._tasks[name]
            elif not task.programs:
                reports.say(
                    task.file,
                    self._places[name],
                    f"the task {task.name} names no program",
                    f"PROGRAM ... WITH {task.name} : ...; (PD-033)",
                )
            task.programs = [pou for pou in task.programs if pou is not NO_PROGRAM]


NO_PROGRAM: Final = Pou(PouKind.PROGRAM, "", "")
"""Stands for a program that was not found, so that its task has no second mistake."""
