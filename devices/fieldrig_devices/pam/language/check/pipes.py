"""Pipes: which blocks may follow each other, and which may be shared (sections 2.18 and 2.24 of the digest)."""

from collections.abc import Iterable, Iterator

from fieldrig_devices.pam.language.check.symbols import Names, Symbol, with_article
from fieldrig_devices.pam.language.items import Actions, Program, Routines, Task
from fieldrig_devices.pam.language.objects import INPUT_BLOCKS, OUTPUT_BLOCKS, TRANSFORMERS
from fieldrig_devices.pam.language.tree import Connect, If, Loop, Reference, Statement


def check_pipe(pipe: Connect, names: Names) -> None:
    """Report blocks at a wrong place of a pipe, and those that would have two inputs (PAML-400, PAML-408, PAML-541)."""
    last = len(pipe.blocks) - 1
    seen: set[str] = set()
    for position, reference in enumerate(pipe.blocks):
        symbol = names.object(reference)
        if symbol is None:
            continue
        if reference.name in seen and symbol.kind in TRANSFORMERS:
            names.wrong(
                reference.place, f"{reference.name} is twice in the pipe", "each block once, as it has one input"
            )
        seen.add(reference.name)
        if reference.index is not None:
            names.wrong(reference.place, f"the block {reference.name} has an index", reference.name)
        allowed, expected = TRANSFORMERS, "a transformer"
        if position == 0:
            allowed, expected = OUTPUT_BLOCKS, "a CONVERTER"
        elif position == last:
            allowed, expected = INPUT_BLOCKS, "a SAMPLER, TMP_GENERATOR or PMP_GENERATOR"
        if symbol.kind not in allowed:
            names.wrong(reference.place, f"{reference.name} is {with_article(symbol.kind)}", expected, _HINT)
        elif symbol.kind == "DISTRIBUTOR" and position != last - 1:
            names.wrong(
                reference.place,
                f"the distributor {reference.name} is inside the pipe",
                "the place behind its input",
            )


_HINT = "A pipe is written from its end: CONVERTER << transformers << generator or SAMPLER."


def check_sharing(program: Program, names: Names) -> None:
    """Report blocks that get their values from different blocks in pipes to different destinations (PAML-408)."""
    first: dict[str, tuple[Connect, tuple[str, ...]]] = {}
    for pipe in pipes_of(program):
        blocks = [reference.name for reference in pipe.blocks]
        for position, reference in enumerate(pipe.blocks):
            leading = tuple(blocks[position + 1 :])
            known, expected = first.setdefault(reference.name, (pipe, leading))
            if leading != expected and _destination(pipe, names) != _destination(known, names):
                what = f"{reference.name} has another input in the pipe of line {known.place.line}"
                names.wrong(reference.place, what, " << ".join((reference.name, *expected)))
                break


def _destination(pipe: Connect, names: Names) -> str:
    """Return the object that the converter of a pipe moves, or the converter itself."""
    symbol: Symbol | None = names.symbols.get(pipe.blocks[0].name)
    for parameter in symbol.declaration.parameters if symbol is not None and symbol.declaration is not None else ():
        if parameter.name == "DESTINATION" and isinstance(parameter.values[0], Reference):
            return parameter.values[0].name
    return pipe.blocks[0].name


def pipes_of(program: Program) -> Iterator[Connect]:
    for item in program.items:
        match item:
            case Task(sequences=sequences, power_on=power_on):
                for sequence in sequences:
                    yield from _pipes(sequence.body)
                yield from _pipes(power_on or ())
            case Actions(reactions=reactions, power_on=power_on):
                for reaction in reactions:
                    yield from _pipes(reaction.body)
                yield from _pipes(power_on or ())
            case Routines(routines=routines, power_on=power_on):
                for routine in routines:
                    yield from _pipes(routine.body)
                yield from _pipes(power_on or ())


def _pipes(statements: Iterable[Statement]) -> Iterator[Connect]:
    for statement in statements:
        match statement:
            case Connect():
                yield statement
            case If(then=then, otherwise=otherwise):
                yield from _pipes((*then, *otherwise))
            case Loop(body=body):
                yield from _pipes(body)
