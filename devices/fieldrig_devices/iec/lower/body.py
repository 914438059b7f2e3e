"""One body while it is lowered: its instructions so far, its places, and its intermediate results.

What is here knows no calls: the expressions that it stores are free of them (`hoisting`).
"""

from collections.abc import Callable

from fieldrig.coverage.marks import HIT, combination
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.costs import Costs
from fieldrig_devices.iec.images import Images
from fieldrig_devices.iec.layout import CALL_SIZE, storage
from fieldrig_devices.iec.lower.assembler import Assembler
from fieldrig_devices.iec.lower.conditions import formula_of, is_decision, texts_of
from fieldrig_devices.iec.lower.emitter import Emitter
from fieldrig_devices.iec.lower.expressions import Expressions
from fieldrig_devices.iec.lower.marks import Marks
from fieldrig_devices.iec.lower.places import Places
from fieldrig_devices.iec.lower.values import Value, constant
from fieldrig_devices.iec.program import Cell, Expression, Load, Parameter, Place, Pou, Space, Variable
from fieldrig_devices.iec.tree import Section
from fieldrig_devices.iec.types import EnumType, Type
from fieldrig_devices.iec.types import Value as CellValue


class Context:
    """The common part of the routines of one program: numbers of types, images and native POUs."""

    def __init__(self, costs: Costs, is_covered: Callable[[Pou], bool] = lambda pou: False) -> None:
        """`is_covered` says for which POUs marks show what has run."""
        self.costs = costs
        self.images = Images()
        self.forms: list[Type] = []
        """The types that pointers are compared with, by number."""
        self._form_numbers: dict[Type, int] = {}
        self.constants: list[list[CellValue]] = []
        """The start values of structures and arrays on the stack, by number."""
        self.is_covered = is_covered
        self.marks = 0
        """The number of marks that have been made."""

    def form(self, kind: Type) -> int:
        if kind not in self._form_numbers:
            self._form_numbers[kind] = len(self.forms)
            self.forms.append(kind)
        return self._form_numbers[kind]

    def image(self, cells: list[CellValue]) -> str:
        self.constants.append(cells)
        return f"image_{len(self.constants) - 1}"

    def mark(self, count: int = 1) -> int:
        """Return the number of a new mark, or of the first of several."""
        self.marks += count
        return self.marks - count

    @staticmethod
    def routine(pou: Pou) -> str:
        """Return the name of the routine of a POU."""
        return pou.name.lower()


class Body:
    """`intermediate` is the number of bytes in the frame for intermediate results; `used` is how many it takes."""

    def __init__(self, context: Context, pou: Pou, intermediate: int) -> None:
        self.context, self.pou = context, pou
        self.assembler = Assembler(context.costs)
        self.places = Places(pou, context.form)
        self.expressions = Expressions(self.places)
        self.frame_size = pou.frame_size + intermediate + CALL_SIZE
        self.used = 0
        self._taken = 0
        self._held = 0
        """The cells for what lasts longer than a statement."""
        self.marks = Marks(pou, self._mark, is_on=context.is_covered(pou))

    def begin(self, line: int) -> None:
        """Begin a statement, which may use the cells for intermediate results again."""
        self.assembler.line, self._taken = line, self._held

    def _mark(self) -> int:
        """Add a mark; return its number."""
        number = self.context.mark()
        self.assembler.mark(f"{HIT}[{number}] = 1")
        return number

    def value(self, expression: Expression, emitter: Emitter, node: tree.Expression | None = None) -> Value:
        """Return the value of a condition or of what is assigned, which may have to be cut to its type.

        `node` is where the source has it: then the conditions of a decision have marks, if they are wanted.
        """
        if node is None or not self.marks.is_detailed or not is_decision(expression):
            return self.expressions.raw(expression, emitter)
        formula, conditions = formula_of(expression), list[str]()
        value = emitter.atom(self.expressions.decision(expression, emitter, conditions))
        first = self.context.mark(1 << len(conditions))
        emitter.add(combination(first, conditions))
        self.marks.decision(formula, first, texts_of(node, len(conditions)), self.marks.place_of(node))
        return value

    def emitter(self) -> Emitter:
        return self.assembler.emitter()

    def do(self, emitter: Emitter) -> None:
        self.assembler.do(emitter)

    def wait(self) -> Emitter:
        """Hold the task up until the host has done its work."""
        self.assembler.hold("is_waiting()")
        return self.emitter()

    # ---- stores

    def store(self, place: Place, value: Expression, node: tree.Expression | None = None) -> None:
        """Store a value; `node` is where the source has it, if conditions in it may have marks."""
        emitter = self.emitter()
        if storage(place.type) is None:
            assert isinstance(value, Load)
            cells = self.places.cells(value.place, emitter)
            self.places.store_cells(place, cells, emitter)
        elif isinstance(place, Parameter) and place.is_slow:
            text = self.expressions.value(value, emitter).text
            emitter.add(f"begin_write({self.places.parameter(place, emitter)}, {text})")
            emitter.charge(emitter.costs.parameter_ns)
            self.do(emitter)
            emitter = self.wait()
            emitter.add("finish()")
        else:
            raw = self.value(value, emitter, node)
            self.places.store(place, raw, emitter)
        self.do(emitter)

    def start(self, variable: Variable, emitter: Emitter) -> None:
        """Add the lines that give a variable on the stack its start value."""
        cells = self.context.images.variable(variable)
        where = self.places.cell(variable)
        emitter.charge(emitter.costs.copy_ns * len(cells))
        kind = storage(variable.type)
        if kind is None:
            emitter.add(f"M[{where}:{where.plus(len(cells))}] = {self.context.image(cells)}")
        else:
            emitter.add(f"M[{where}] = {constant(cells[0], kind).text}")

    def note_states(self) -> None:
        """Mark the values of the enumerations of this POU, as its body begins; it costs the program no time."""
        for variable in self.marks.states_to_note():
            assert isinstance(variable.type, EnumType)
            low, high = min(variable.type.values.values()), max(variable.type.values.values())
            first = self.context.mark(high - low + 2)  # the last one is for numbers that are no values
            emitter = self.emitter()
            value = emitter.atom(self.expressions.raw(Load(Cell(variable, variable.type)), emitter)).text
            emitter.add(
                f"{HIT}[{first - low} + {value} if {low} <= {value} <= {high} else {first + high - low + 1}] = 1"
            )
            self.assembler.mark(*emitter.lines)
            for name, number in variable.type.values.items():
                self.marks.alone(first + number - low, self.marks.state(variable, name))

    # ---- intermediate results

    def intermediate(self, kind: Type) -> Variable:
        offset = self.pou.frame_size + self._taken
        self._taken += kind.size
        self.used = max(self.used, self._taken)
        return Variable("", kind, Space.FRAME, Section.TEMP, offset=offset)

    def held(self, kind: Type) -> Variable:
        """Return a cell that nothing else uses up to the end of the body."""
        self._taken = self._held
        variable = self.intermediate(kind)
        self._held = self._taken
        return variable

    def keep(self, value: Expression) -> Load:
        """Store a value in an intermediate cell."""
        cell = Cell(self.intermediate(value.type), value.type)
        self.store(cell, value)
        return Load(cell)
