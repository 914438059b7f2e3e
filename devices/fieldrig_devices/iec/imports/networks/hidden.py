"""Variables that an import adds to a POU: the value of a wire, the enable of a block, the memory of an edge.

Their names are legal and unlikely, such as `Net2_Enable7`, so that watch windows can show them.
"""

from dataclasses import dataclass, field

from fieldrig_devices.iec import tree


@dataclass(slots=True)
class Hidden:
    """The added variables of one POU."""

    taken: set[str]
    """Names of the POU and of the file, in small letters."""
    has_memory: bool
    """False for a function, whose variables do not outlive the call."""
    known: dict[str, tree.TypeSpec]
    """The types of the variables that the POU sees, to which the added ones belong."""
    narrow: dict[str, tree.TypeSpec]
    """The smaller types of the results that some of them hold with 32 bits."""
    variables: list[tree.Variable] = field(default_factory=list)
    network: int = 0
    _count: int = 0

    def add(
        self, what: str, type: tree.TypeSpec, line: int, remark: str, narrow: tree.TypeSpec | None = None
    ) -> tree.Name:
        """Declare a variable for `what` and return its name.

        `narrow` is the type of a result that the variable holds with more bits, which each use of it cuts or takes.
        """
        self._count += 1
        name = self.free(f"Net{self.network}_{what}{self._count}")
        position = tree.Position(line, 1)
        self.known[name.casefold()] = type
        if narrow is not None:
            self.narrow[name.casefold()] = narrow
        self.variables.append(tree.Variable(name, type, narrow=narrow, remark=f"(* {remark} *)", position=position))
        return tree.Name(name, position=position)

    def free(self, name: str) -> str:
        """The name, with a letter behind it if it is taken."""
        while name.casefold() in self.taken:
            name += "x"
        self.taken.add(name.casefold())
        return name

    def block(self) -> tuple[tree.Variables, ...]:
        if not self.variables:
            return ()
        return (tree.Variables(tree.Section.LOCAL, tuple(self.variables), position=self.variables[0].position),)
