"""Units of which a part does not compile: it is left out, and a run that reaches it gets a fault with the reason.

A project for a machine names libraries without sources, for axes, events or sockets, and its suites seldom
reach the code that needs them.  So a type that is not there gets a placeholder, a function block without inputs, and a
body that does not compile becomes a fault.  What uses a placeholder (a call, an output, its size) does not compile in
turn.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import CODESYS
from fieldrig_devices.iec.library.selection import words as words_of
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.tcunit import library
from fieldrig_devices.iec.tcunit.reach import Item
from fieldrig_devices.languages.mistakes import Mistake

_MOST_CHARACTERS: Final = 200
Part = tree.Pou | tree.Action | tree.Method


def placeholder(name: str, mistake: Mistake) -> Item:
    """Return a function block in the place of a type that is not there; a call of it is a fault."""
    pou = tree.Pou(tree.PouKind.FUNCTION_BLOCK, name, None, (), _fault(mistake), position=tree.Position(1, 1))
    return Item(name.casefold(), f"<{name}>", 1, pou, False, frozenset(words_of(pou)))


def cause(mistake: Mistake, missing: Mapping[str, Mistake]) -> Mistake:
    """Return the mistake behind one that is only about a placeholder, at the place of this one."""
    named = {*words_of([mistake.what])}
    behind = next((known for name, known in missing.items() if name in named), mistake)
    return replace(mistake, what=behind.what, expected=behind.expected, hint=behind.hint)


def without_part(item: Item, mistake: Mistake, reason: Mistake, missing: Iterable[str]) -> tuple[Item, str] | None:
    """Return the item without what a mistake is in, and the name of that part, empty for a start value.

    `reason` is what a run that reaches the part reports, and `missing` has the names of the placeholders in small
    letters.  None if the mistake is in a declaration that is needed.
    """
    pou = item.declaration
    if not isinstance(pou, tree.Pou):
        return None
    known: list[Part] = [pou, *pou.actions, *pou.methods]
    parts = [part for part in known if part.position.line <= mistake.line]
    if not parts:
        return None
    owner = max(parts, key=lambda part: part.position.line)
    if _is_declared(owner, mistake.line):
        changed = _without_start_value(owner, mistake.line, frozenset(missing))
        return None if changed is None else (_with_part(item, owner, changed), "")
    if isinstance(owner.body, tree.NativeBody):
        return None
    name = pou.name if owner is pou else f"{pou.name}.{owner.name}"
    return _with_part(item, owner, replace(owner, body=_fault(reason))), name


def unknown_sizes(items: Sequence[Item], missing: Iterable[str]) -> Iterator[Mistake]:
    """Yield a mistake for each SIZEOF of a type or variable that has a placeholder in it."""
    types = set(missing)
    if not types:
        return
    variables: set[str] = set()
    while True:
        before = len(types) + len(variables)
        for item in items:
            named = [one.name.casefold() for one in _declared(item) if types & _sized(one.type)]
            variables.update(named)
            if named and not isinstance(item.declaration, tree.Variables):
                types.add(item.name)
            variables.update(one.name.casefold() for one in _local(item) if types & _sized(one.type))
        if len(types) + len(variables) == before:
            break
    for item in items:
        for node in tree.walk(item.declaration):
            if isinstance(node, tree.Call) and getattr(node.called, "text", "").casefold() == "sizeof":
                last = [*words_of(node.arguments)][-1:]
                if {*last} & (types | variables):
                    what = f"the size of {last[0]} is not known, because a type in it is not there"
                    yield Mistake(*node.called.position, what, file=item.file)


def _is_declared(owner: Part, line: int) -> bool:
    """True for a line among the declarations of a part."""
    if isinstance(owner, tree.Action):
        return False
    last = max((one.position.line for block in owner.blocks for one in block.variables), default=owner.position.line)
    first = next((one.position.line for one in _statements(owner.body)), None)
    return line <= last if first is None else line < first


def _statements(body: tree.Body) -> Sequence[tree.Node]:
    return body.statements if isinstance(body, tree.StBody) else ()


def _without_start_value(owner: Part, line: int, missing: frozenset[str]) -> Part | None:
    """Return a part without the start value of a variable of a missing type; None if the line has no such variable."""
    if isinstance(owner, tree.Action):
        return None
    is_new = False
    blocks = []
    for block in owner.blocks:
        variables = []
        for one in block.variables:
            is_meant = one.position.line == line and missing & {*words_of(one.type)}
            has_start = one.initial is not None or (isinstance(one.type, tree.NamedType) and one.type.arguments)
            if is_meant and has_start:
                is_new = True
                kind = replace(one.type, arguments=(), rows=()) if isinstance(one.type, tree.NamedType) else one.type
                one = replace(one, type=kind, initial=None)
            variables.append(one)
        blocks.append(replace(block, variables=tuple(variables)))
    return replace(owner, blocks=tuple(blocks)) if is_new else None


def _with_part(item: Item, old: Part, new: Part) -> Item:
    """Return the item with one part changed; both parts of a property are where its head is, so both are changed."""
    pou = item.declaration
    assert isinstance(pou, tree.Pou)
    if isinstance(new, tree.Pou):
        changed = new
    elif isinstance(new, tree.Action):
        changed = replace(pou, actions=tuple(new if one is old else one for one in pou.actions))
    else:
        body, blocks = new.body, new.blocks
        is_cut = body is not old.body
        methods = (replace(one, body=body) if is_cut and one.position == old.position else one for one in pou.methods)
        changed = replace(
            pou,
            methods=tuple(
                replace(one, blocks=blocks) if pou.methods[n] is old else one for n, one in enumerate(methods)
            ),
        )
    return replace(item, declaration=changed, words=frozenset(words_of(changed)))


def _declared(item: Item) -> Iterator[tree.Variable]:
    """Yield the variables of an item itself, not those of its methods."""
    match item.declaration:
        case tree.Pou(blocks=blocks):
            yield from (one for block in blocks for one in block.variables)
        case tree.TypeDeclaration(type=tree.StructSpec(fields=fields)):
            yield from fields
        case tree.TypeDeclaration(name=name, type=spec):
            yield tree.Variable(name, spec)
        case tree.Variables(variables=variables):
            yield from variables


def _local(item: Item) -> Iterator[tree.Variable]:
    """Yield the variables of the methods of an item."""
    if isinstance(item.declaration, tree.Pou):
        for method in item.declaration.methods:
            yield from (one for block in method.blocks for one in block.variables)


def _sized(spec: tree.TypeSpec) -> set[str]:
    """Return the words of a type on which its size depends."""
    while isinstance(spec, tree.ArraySpec):
        spec = spec.element
    return set() if isinstance(spec, tree.PointerSpec) else {*words_of(spec)}


def _fault(mistake: Mistake) -> tree.StBody:
    """Return a body that ends the suite with a fault, at the place of the mistake."""
    text = mistake.what[:_MOST_CHARACTERS].replace("$", "$$").replace("'", "$'")
    unit, wrong = parse(f"PROGRAM p {library.LEFT_OUT}('{text}'); END_PROGRAM", mistake.file, CODESYS)
    pou = unit.declarations[0]
    assert not wrong
    assert isinstance(pou, tree.Pou)
    assert isinstance(pou.body, tree.StBody)
    for node in tree.walk(pou.body):
        if isinstance(node, tree.Node):
            node.position = tree.Position(mistake.line, mistake.column)
    return pou.body
