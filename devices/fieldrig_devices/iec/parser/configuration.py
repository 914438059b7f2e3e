"""CONFIGURATION with its resource, tasks and programs.

Source: PacDrive manual 596 to 610 for the model; IEC 61131-3 for the text.
"""

from fieldrig_devices.iec import tokens as token
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.parser.cursor import UnexpectedError
from fieldrig_devices.iec.parser.declarations import BEHIND, SECTIONS, Declarations

_STARTS = frozenset({"PROGRAM", "RESOURCE", "END_RESOURCE", "END_CONFIGURATION", *SECTIONS, token.END})


class Configurations(Declarations):
    """Reads configurations."""

    def configuration(self) -> tree.Configuration:
        """Read CONFIGURATION ... END_CONFIGURATION, or RESOURCE ... END_RESOURCE alone."""
        opening = self.i
        self.gather()
        node = tree.Configuration("", position=self.positions[opening], comments=self.taken())
        is_whole = self.kinds[opening] == "CONFIGURATION"
        resources: list[tree.Configuration] = []
        if is_whole:
            self.i += 1
            node.name = self.name("the name of the configuration")
            self.accept(";")
        while self.kinds[self.i] not in ("END_CONFIGURATION", token.END):
            if self.kinds[self.i] == "RESOURCE":
                resources.append(self._resource())
                if not is_whole:
                    break
            elif not self._part(node):
                break
        if is_whole:
            self._end("END_CONFIGURATION", opening, "CONFIGURATION")
        if len(resources) == 1:
            (only,) = resources
            node.blocks += only.blocks
            node.tasks += only.tasks
            node.programs += only.programs
            node.resource, node.processor = only.resource, only.processor
        else:
            node.resources = tuple(resources)
        self.gather_from(opening)
        node.after = self.taken()
        node.remark = self.remark()
        return node

    def _resource(self) -> tree.Configuration:
        opening = self.i
        node = tree.Configuration("", position=self.positions[opening])
        self.i += 1
        node.resource = self.name("the name of the resource")
        if self.accept_word("ON"):
            node.processor = self.name("the type of the controller")
        self.accept(";")
        while self.kinds[self.i] not in ("END_RESOURCE", "END_CONFIGURATION", token.END):
            if not self._part(node):
                break
        self._end("END_RESOURCE", opening, "RESOURCE")
        return node

    def _part(self, node: tree.Configuration) -> bool:
        """Read one part.  False if something else follows that another declaration begins with."""
        at = self.i
        self.gather()
        if self.kinds[at] in SECTIONS:
            node.blocks += (self.block_of_variables(),)
            return True
        if self.kinds[at] in BEHIND or self.kinds[at] == "CONFIGURATION":
            return False
        front = self.taken()
        part: tree.TaskDeclaration | tree.ProgramInstance
        try:
            if self.accept_word("TASK"):
                part = self._task()
                node.tasks += (part,)
            elif self.accept("PROGRAM"):
                part = self._program()
                node.programs += (part,)
            else:
                raise self.unexpected("TASK, PROGRAM or END_RESOURCE")
        except UnexpectedError:
            self._pending[:0] = front
            self._skip_part(at)
            return True
        self.gather_from(at)
        part.position, part.comments, part.remark = self.positions[at], front + self.taken(), self.remark()
        return True

    def _skip_part(self, start: int) -> None:
        if self.i == start and self.kinds[self.i] != token.END:
            self.i += 1
        while self.kinds[self.i] not in _STARTS and not self.is_word("TASK"):
            self.i += 1
            if self.kinds[self.i - 1] == ";":
                break

    def _task(self) -> tree.TaskDeclaration:
        task = tree.TaskDeclaration(self.name("the name of the task"))
        opening = self.i
        self.expect("(", "A task is written TASK name(INTERVAL := T#10ms, PRIORITY := 16);")
        while self.kinds[self.i] != ")":
            word = self.texts[self.i].upper()
            if word not in ("INTERVAL", "PRIORITY", "SINGLE"):
                raise self.unexpected("INTERVAL, PRIORITY or SINGLE")
            self.i += 1
            self.expect(":=")
            setattr(task, word.lower(), self.expression())
            if not self.accept(","):
                break
        self.close(")", opening)
        self._semicolon_of_part()
        return task

    def _program(self) -> tree.ProgramInstance:
        self.accept("RETAIN")
        name = self.name("the name of the program")
        task = self.name("the name of a task") if self.accept_word("WITH") else ""
        type_name = name
        if self.accept(":"):
            type_name = self.name("the name of a PROGRAM")
        self._semicolon_of_part()
        return tree.ProgramInstance(name, task, type_name)

    def _semicolon_of_part(self) -> None:
        if self.accept(";"):
            return
        if self.is_next_line():
            self.missing(";")
        else:
            raise self.unexpected(";")
