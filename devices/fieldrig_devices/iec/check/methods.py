"""Methods: which one a call means, and the instance that it works with."""

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import dispatch, inheritance, library_names
from fieldrig_devices.iec.check.checker import Checker
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.program import AddressOf, Cell, Place, Pou, This
from fieldrig_devices.iec.types import BlockType, PointerType

Called = tuple[Place | None, Pou]
"""The instance, unless it is the one whose code runs, and the method."""


def is_this(context: Context, node: tree.Expression) -> bool:
    """True for `THIS^`, the instance whose code runs, and for `SUPER^`, which is the same as far as variables go.

    The standard writes both without ^.
    """
    return is_super(context, node) or _is_word(context, node, "THIS")


def pointer_to_this(context: Context, node: tree.Expression) -> AddressOf | None:
    """Return the pointer that THIS without ^ is; None for anything else."""
    if not isinstance(node, tree.Name) or node.text.upper() != "THIS" or not context.project.dialect.has_this_pointer:
        return None
    block = context.block
    if block is None or block.type is None or context.find(node.text) is not None:
        return None
    return AddressOf(This(block.type), PointerType(block.type))


def is_super(context: Context, node: tree.Expression) -> bool:
    return _is_word(context, node, "SUPER")


def _is_word(context: Context, node: tree.Expression, word: str) -> bool:
    dialect, named = context.project.dialect, node
    if isinstance(node, tree.Dereference):
        named = node.of
    elif not dialect.has_classes:
        return False
    if not isinstance(named, tree.Name) or named.text.upper() != word or not dialect.has_methods:
        return False
    return context.block is not None and (named is not node or context.find(word) is None)


def find(checker: Checker, called: tree.Expression) -> Called | None:
    """Return the method that is called; None if what is called is no method."""
    context = checker.context
    if isinstance(called, tree.Name):
        method = _own(context, called.text)
        hiding = context.names.get(context.key(called.text))
        is_own_result = context.owner is not None and hiding is context.owner.result  # a call in itself
        if method is None or (hiding is not None and not is_own_result):
            return None
        return None, method  # it hides what the project or a library has under its name
    if not isinstance(called, tree.Member):
        return None
    if is_super(context, called.of):
        method = inheritance.method_above(context, called.name)
        return None if method is None else (None, method)
    if is_this(context, called.of):
        method = _own(context, called.name)
        return None if method is None else (None, method)
    front = library_names.without_library(context, called.of)  # a type in front, `Library.Colour.red`, has no method
    if isinstance(front, tree.Name) and context.find(front.text) is None and not _own(context, front.text):
        return None
    owner = checker.meaning(called.of)
    if isinstance(owner, Pou) and owner.instance is not None:
        owner = Cell(owner.instance, owner.instance.type)
    owner = dispatch.target(owner) if isinstance(owner, Place) else owner
    if not isinstance(owner, Place) or not isinstance(owner.type, BlockType) or owner.type.pou is None:
        return None
    facade = dispatch.general(owner)
    if facade is not None and context.key(called.name) in facade.methods:
        return dispatch.through_facade(owner, facade), facade.methods[context.key(called.name)]
    method = owner.type.pou.methods.get(context.key(called.name))
    if method is None:
        return None
    return (None if isinstance(owner, Cell) and owner.variable is _instance(context) else owner), method


def _own(context: Context, name: str) -> Pou | None:
    return context.block.methods.get(context.key(name)) if context.block is not None else None


def _instance(context: Context) -> object:
    return context.block.instance if context.block is not None else None
