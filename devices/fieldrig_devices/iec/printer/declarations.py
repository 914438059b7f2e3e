"""Declarations, POUs, charts and configurations as text."""

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.parser.initials import RESERVED
from fieldrig_devices.iec.printer import statements
from fieldrig_devices.iec.printer.expressions import argument_text, direct_text
from fieldrig_devices.iec.printer.expressions import expression_text as text_of
from fieldrig_devices.iec.printer.lines import INDENT, Lines


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
            _type(lines, node)
        case tree.Configuration():
            _configuration(lines, node)
            _remark(lines, node)


def _remark(lines: Lines, statement: tree.Statement) -> None:
    """Add the comment behind the END of something, whose other comments are printed in front of that END."""
    if statement.remark:
        lines.append(f" {statement.remark}")


# ---- variables and types


def variables(lines: Lines, block: tree.Variables) -> None:
    words = [block.section.value] + [block.access] * bool(block.access)
    words += ["RETAIN"] * block.is_retain + ["PERSISTENT"] * block.is_persistent + ["CONSTANT"] * block.is_constant
    lines.add(" ".join(words))
    with lines.indented():
        for number, variable in enumerate(block.variables):
            lines.front(variable, number == 0)
            _variable(lines, variable)
            lines.behind(variable)
    lines.add("END_VAR")
    lines.behind(block)


def _variable(lines: Lines, variable: tree.Variable) -> None:
    at = f" AT {direct_text(variable.location)}" if variable.location is not None else ""
    lines.add(f"{variable.name}{at} : ")
    _spec(lines, variable.type)
    edge = f" {variable.edge}" if variable.edge else ""
    lines.append(f"{edge}{_initial(variable.initial, variable.type)};")


def _arguments(arguments: tuple[tree.Argument, ...]) -> str:
    return f"({', '.join(map(argument_text, arguments))})"


def _spec(lines: Lines, spec: tree.TypeSpec) -> None:
    """Append a type to the last line, and further lines if it needs them."""
    match spec:
        case tree.NamedType(name, arguments, rows):
            lines.append(name)
            if arguments:
                lines.append(_arguments(arguments))
            if rows:
                lines.append(f"[{', '.join(map(_arguments, rows))}]")
        case tree.StringSpec(length, is_wide):
            name = "WSTRING" if is_wide else "STRING"
            lines.append(name if length is None else f"{name}({text_of(length)})")
        case tree.SubrangeSpec(base, low, high):
            lines.append(f"{base.name}({text_of(low)}..{text_of(high)})")
        case tree.ArraySpec(dimensions, element):
            lines.append(f"ARRAY[{', '.join(map(statements.label_text, dimensions))}] OF ")
            _spec(lines, element)
        case tree.OpenArraySpec(count, element):
            lines.append(f"ARRAY[{', '.join('*' * count)}] OF ")
            _spec(lines, element)
        case tree.PointerSpec(to, is_reference):
            lines.append("REFERENCE TO " if is_reference else "POINTER TO ")
            _spec(lines, to)
        case tree.EnumSpec():
            _enumeration(lines, spec)
        case tree.StructSpec(fields, is_union):
            word = "UNION" if is_union else "STRUCT"
            lines.append(word)
            with lines.indented():
                for number, field in enumerate(fields):
                    lines.front(field, number == 0)
                    _variable(lines, field)
                    lines.behind(field)
            lines.add(f"END_{word}")


def _enumeration(lines: Lines, spec: tree.EnumSpec) -> None:
    texts = [value.name if value.value is None else f"{value.name} := {text_of(value.value)}" for value in spec.values]
    base = f" {spec.base}" if spec.base else ""
    if not any(value.comments or value.remark for value in spec.values):
        lines.append(f"({', '.join(texts)}){base}")
        return
    lines.append("(")
    with lines.indented():
        for value, text in zip(spec.values, texts, strict=True):
            lines.comments(value.comments)
            lines.add(text if value is spec.values[-1] else f"{text},")
            if value.remark:
                lines.append(f" {value.remark}")
    lines.add(f"){base}")


def _type(lines: Lines, node: tree.TypeDeclaration) -> None:
    extends = node.type.extends if isinstance(node.type, tree.StructSpec) else ""
    lines.add(f"TYPE {node.name}{f' EXTENDS {extends}' if extends else ''} : ")
    _spec(lines, node.type)
    initial = _initial(node.initial, node.type)
    is_struct = isinstance(node.type, tree.StructSpec) and not initial
    lines.append(initial if is_struct else f"{initial};")
    lines.behind(node)
    lines.add("END_TYPE")


# ---- start values


def _initial(initial: tree.Initial | None, spec: tree.TypeSpec) -> str:
    if initial is None:
        return ""
    if isinstance(initial, tree.ArrayInitial) and _is_open(initial, spec):
        return f" := {', '.join(map(_element, initial.elements))}"
    return f" := {_element(initial)}"


def _is_open(initial: tree.ArrayInitial, spec: tree.TypeSpec) -> bool:
    """True if the values of an array need no brackets, as the manual writes them."""
    elements = initial.elements
    is_list = len(elements) > 1 or any(isinstance(element, tree.Repeated) for element in elements)
    if isinstance(spec, tree.ArraySpec):
        return is_list or (len(elements) == 1 and not isinstance(elements[0], tree.ArrayInitial))
    return is_list and isinstance(spec, tree.NamedType) and spec.name.upper() not in RESERVED


def _element(element: tree.Initial | tree.Repeated) -> str:
    match element:
        case tree.Repeated(count, value):
            return f"{text_of(count)}({_element(value)})"
        case tree.ArrayInitial(elements):
            return f"[{', '.join(map(_element, elements))}]"
        case tree.StructInitial(fields):
            return f"({', '.join(f'{field.name} := {_element(field.value)}' for field in fields)})"
    return text_of(element)


# ---- POUs


def _pou(lines: Lines, pou: tree.Pou) -> None:
    extends = ("EXTENDS", pou.extends) if pou.extends else ()
    implements = ("IMPLEMENTS", ", ".join(pou.implements)) if pou.implements else ()
    lines.add(" ".join([pou.kind.value, *pou.modifiers, pou.name, *extends, *implements]))
    if pou.result is not None:
        lines.append(" : ")
        _spec(lines, pou.result)
    for block in pou.blocks:
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
        _spec(lines, method.result)


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


def body(lines: Lines, node: tree.Body) -> None:
    match node:
        case tree.StBody(block):
            statements.statements(lines, block)
        case tree.IlBody(block_of_il):
            statements.instructions(lines, block_of_il)
        case tree.SfcBody():
            _chart(lines, node)
        case tree.NativeBody():
            lines.add("{native}")


# ---- charts


def _chart(lines: Lines, chart: tree.SfcBody) -> None:
    parts: list[tree.Step | tree.Transition] = [*chart.steps, *chart.transitions]
    for number, part in enumerate(parts):
        lines.front(part, number == 0)
        if isinstance(part, tree.Step):
            _step(lines, part)
        else:
            _transition(lines, part)
        lines.behind(part)


def _step(lines: Lines, step: tree.Step) -> None:
    lines.add(f"{'INITIAL_STEP' if step.is_initial else 'STEP'} {step.name}:")
    with lines.indented():
        for use in step.uses:
            time = f", {text_of(use.time)}" if use.time is not None else ""
            lines.add(f"{use.name}({', '.join([use.qualifier + time, *use.indicators])});")
        for word, section in (("ENTRY", step.entry), ("ACTIVE", step.active), ("EXIT", step.exit)):
            if section is not None:
                lines.add(word)
                with lines.indented():
                    body(lines, section)
                lines.add(f"END_{word}")
    lines.add("END_STEP")


def _transition(lines: Lines, transition: tree.Transition) -> None:
    words = ["TRANSITION"]
    words += [transition.name] if transition.name else []
    words += [f"(PRIORITY := {transition.priority})"] if transition.priority else []
    lines.add(f"{' '.join(words)} FROM {_steps(transition.sources)} TO {_steps(transition.targets)}")
    lines.add(f"{INDENT}:= {text_of(transition.condition)};")
    lines.add("END_TRANSITION")


def _steps(names: tuple[str, ...]) -> str:
    return names[0] if len(names) == 1 else f"({', '.join(names)})"


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
