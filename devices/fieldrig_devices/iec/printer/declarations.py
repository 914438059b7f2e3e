"""Declarations, POUs and configurations as text."""

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.printer.bodies import body
from fieldrig_devices.iec.printer.expressions import expression_text as text_of
from fieldrig_devices.iec.printer.lines import Lines
from fieldrig_devices.iec.printer.variables import generic_constants, type_declaration, type_spec, variables


def declaration(lines: Lines, node: tree.Declaration) -> None:
    lines.front(node)
    match node:
        case tree.Pou():
            _pou(lines, node)
            _remark(lines, node)
        case tree.Interface():
            _interface(lines, node)
            _remark(lines, node)
            return
        case tree.Variables():
            variables(lines, node)
            return
        case tree.TypeDeclaration():
            type_declaration(lines, node)
        case tree.Configuration():
            _configuration(lines, node)
            _remark(lines, node)


def _remark(lines: Lines, statement: tree.Statement) -> None:
    """Add the comment behind the END of something, whose other comments are printed in front of that END."""
    if statement.remark:
        lines.append(f" {statement.remark}")


def _pou(lines: Lines, pou: tree.Pou) -> None:
    extends = ("EXTENDS", f"{pou.extends}{generic_constants(pou.extends_with)}") if pou.extends else ()
    implements = ("IMPLEMENTS", ", ".join(pou.implements)) if pou.implements else ()
    head = [pou.kind.value, *pou.modifiers, pou.name]
    if pou.blocks_in_front and (extends or implements):
        lines.add(" ".join(head))
        head, front = [], pou.blocks[: pou.blocks_in_front]
        for block in front:
            lines.front(block)
            variables(lines, block)
    else:
        front = ()
    lines.add(" ".join([*head, *extends, *implements]))
    if pou.result is not None:
        lines.append(" : ")
        type_spec(lines, pou.result)
    for block in pou.blocks[len(front) :]:
        lines.front(block)
        variables(lines, block)
    if pou.blocks and (pou.body != tree.StBody(()) or not (pou.methods or pou.actions)):
        lines.add("")
    body(lines, pou.body)
    _methods(lines, pou.methods)
    for action in pou.actions:
        lines.add("")
        lines.front(action)
        lines.add(f"ACTION {action.name}:")
        with lines.indented():
            body(lines, action.body)
        lines.add("END_ACTION")
        lines.behind(action)
    lines.comments(pou.after)
    lines.add(f"END_{pou.kind.value}")


def _interface(lines: Lines, interface: tree.Interface) -> None:
    extends = ("EXTENDS", ", ".join(interface.extends)) if interface.extends else ()
    lines.add(" ".join(["INTERFACE", interface.name, *extends]))
    _methods(lines, interface.methods)
    lines.add("END_INTERFACE")


def _methods(lines: Lines, methods: tuple[tree.Method, ...]) -> None:
    before: tree.Method | None = None
    for method in methods:
        if method.accessor:
            _accessor(lines, method, before)
        else:
            _end_of_property(lines, before)
            lines.add("")
            lines.front(method)
            _method(lines, method)
            _remark(lines, method)
        before = method
    _end_of_property(lines, before)


def _accessor(lines: Lines, method: tree.Method, before: tree.Method | None) -> None:
    """Print a part of a property; parts of the same one that follow each other are together."""
    is_further = before is not None and (before.name, before.accessor, method.accessor) == (method.name, "GET", "SET")
    if not is_further or before is None or before.result != method.result or before.modifiers != method.modifiers:
        _end_of_property(lines, before)
        lines.add("")
        _head(lines, "PROPERTY", method)
    lines.front(method)
    lines.add(method.accessor)
    _inside(lines, method)
    lines.add(f"END_{method.accessor}")
    _remark(lines, method)


def _end_of_property(lines: Lines, before: tree.Method | None) -> None:
    if before is not None and before.accessor:
        lines.add("END_PROPERTY")


def _head(lines: Lines, word: str, method: tree.Method) -> None:
    lines.add(" ".join([word, *method.modifiers, method.name]))
    if method.result is not None:
        lines.append(" : ")
        type_spec(lines, method.result)


def _method(lines: Lines, method: tree.Method) -> None:
    _head(lines, "METHOD", method)
    _inside(lines, method)
    lines.add("END_METHOD")


def _inside(lines: Lines, method: tree.Method) -> None:
    for block in method.blocks:
        lines.front(block)
        variables(lines, block)
    if method.blocks:
        lines.add("")
    body(lines, method.body)
    lines.comments(method.after)


# ---- configurations


def _configuration(lines: Lines, node: tree.Configuration) -> None:
    if node.name:
        lines.add(f"CONFIGURATION {node.name}")
        with lines.indented():
            _blocks(lines, node)
            if node.resource:
                _resource(lines, node)
            else:
                _parts(lines, node)
            for resource in node.resources:
                _resource(lines, resource)
            lines.comments(node.after)
        lines.add("END_CONFIGURATION")
    else:
        _resource(lines, node)


def _blocks(lines: Lines, node: tree.Configuration) -> None:
    for block in node.blocks:
        lines.front(block)
        variables(lines, block)


def _resource(lines: Lines, node: tree.Configuration) -> None:
    lines.add(f"RESOURCE {node.resource}")
    if node.processor:
        lines.append(f" ON {node.processor}")
    with lines.indented():
        if not node.name:
            _blocks(lines, node)
        _parts(lines, node)
        if not node.name:
            lines.comments(node.after)
    lines.add("END_RESOURCE")


def _parts(lines: Lines, node: tree.Configuration) -> None:
    for task in node.tasks:
        lines.front(task)
        pairs = (("SINGLE", task.single), ("INTERVAL", task.interval), ("PRIORITY", task.priority))
        settings = [f"{word} := {text_of(value)}" for word, value in pairs if value is not None]
        lines.add(f"TASK {task.name}({', '.join(settings)});")
        lines.behind(task)
    for program in node.programs:
        lines.front(program)
        task_text = f" WITH {program.task}" if program.task else ""
        lines.add(f"PROGRAM {program.name}{task_text} : {program.type};")
        lines.behind(program)
