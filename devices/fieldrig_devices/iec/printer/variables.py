"""Blocks of variables, types and start values as text."""

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.parser.initials import RESERVED
from fieldrig_devices.iec.printer import statements
from fieldrig_devices.iec.printer.expressions import argument_text, direct_text
from fieldrig_devices.iec.printer.expressions import expression_text as text_of
from fieldrig_devices.iec.printer.lines import Lines


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
    if variable.place:
        at = f" AT '{variable.place.replace('$', '$$')}'"
    lines.add(f"{variable.name}{at} : ")
    type_spec(lines, variable.type)
    edge = f" {variable.edge}" if variable.edge else ""
    lines.append(f"{edge}{_initial(variable.initial, variable.type)};")


def _arguments(arguments: tuple[tree.Argument, ...]) -> str:
    return f"({', '.join(map(argument_text, arguments))})"


def generic_constants(given: tuple[tree.Expression, ...]) -> str:
    return f"<{', '.join(map(text_of, given))}>" if given else ""


def type_spec(lines: Lines, spec: tree.TypeSpec) -> None:
    """Append a type to the last line, and further lines if it needs them."""
    match spec:
        case tree.NamedType(name, arguments, rows, parameters):
            name += generic_constants(parameters)
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
            type_spec(lines, element)
        case tree.OpenArraySpec(count, element):
            lines.append(f"ARRAY[{', '.join('*' * count)}] OF ")
            type_spec(lines, element)
        case tree.PointerSpec(to, is_reference):
            lines.append("REFERENCE TO " if is_reference else "POINTER TO ")
            type_spec(lines, to)
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


def type_declaration(lines: Lines, node: tree.TypeDeclaration) -> None:
    extends = node.type.extends if isinstance(node.type, tree.StructSpec) else ""
    lines.add(f"TYPE {node.name}{f' EXTENDS {extends}' if extends else ''} : ")
    type_spec(lines, node.type)
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
