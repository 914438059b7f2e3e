"""Properties: an access to one is a call of the method behind it, of which there is one to read and one to write it."""

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import methods
from fieldrig_devices.iec.check.checker import Checker
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.texts import text
from fieldrig_devices.iec.types import PointerType

Access = tree.Name | tree.Member


def name_to_write(name: str) -> str:
    """Return the name of the method that writes a property, which no method of a source text can have."""
    return f"{name}@set"


def reading(checker: Checker, node: tree.Expression) -> list[tree.Call] | None:
    """Return the call that reads a property, or an empty list after a message; None if the expression is none."""
    if not _may_be_one(checker.context, node):
        return None
    assert isinstance(node, Access)
    if _exists(checker, node):
        return [tree.Call(node, (), position=node.position)]
    if not _exists(checker, _to_write(node)):
        return None
    checker.context.say(node, f"the property {text(node)} has no GET", "a property that can be read")
    return []


def writing(checker: Checker, node: tree.Assign) -> list[tree.Call] | None:
    """Return the call that writes a property, or an empty list after a message; None if the target is none."""
    target = node.target
    if not _may_be_one(checker.context, target):
        return None
    assert isinstance(target, Access)
    called = _to_write(target)
    if _exists(checker, called):
        return [tree.Call(called, (tree.Argument(node.value, position=node.value.position),), position=node.position)]
    if not _exists(checker, target) or _refers(checker, target):
        return None
    checker.context.say(target, f"the property {text(target)} has no SET", "a property that can be written")
    return []


def _may_be_one(context: Context, node: tree.Expression) -> bool:
    known = context.project.properties
    if not known or not isinstance(node, Access):
        return False
    return context.key(node.text if isinstance(node, tree.Name) else node.name) in known


def _to_write(node: Access) -> Access:
    if isinstance(node, tree.Name):
        return tree.Name(name_to_write(node.text), position=node.position)
    return tree.Member(node.of, name_to_write(node.name), position=node.position)


def _refers(checker: Checker, node: Access) -> bool:
    """True for a property that is a reference, by which what it refers to is written."""
    method = methods.find(checker, node)
    kind = method[1].result.type if method is not None and method[1].result is not None else None
    return isinstance(kind, PointerType) and kind.is_reference


def _exists(checker: Checker, called: Access) -> bool:
    """True for an accessor; a variable or component of the same name is none, and hides it."""
    context = checker.context
    if isinstance(called, tree.Name) and context.key(called.text.removesuffix("@set")) in context.names:
        return False
    method = methods.find(checker, called)
    return method is not None and method[1].is_accessor
