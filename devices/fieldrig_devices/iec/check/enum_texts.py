"""The names of enumeration values as texts: TO_STRING and TO_WSTRING of a type with the attribute 'to_string'.

Source: the public descriptions of CODESYS V3 and TwinCAT 3.  Such a type gets a function that compares a value with
each of its own; a number that is none of them becomes the text of the number.
"""

import re
from collections.abc import Sequence
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import constants
from fieldrig_devices.iec.check.context import Context, position_of
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.program import CallFunction, Expression
from fieldrig_devices.iec.types import EnumType, StringType

CONVERSIONS: Final = ("TO_STRING", "TO_WSTRING")
_ATTRIBUTE: Final = re.compile(r"\{\s*attribute\s+'to_string'\s*\}", re.IGNORECASE)
_FUNCTION: Final = "__TEXT_OF_{}"


def function_of(node: tree.TypeDeclaration, dialect: Dialect) -> tree.Pou | None:
    """Return the function for the texts of a type; None for a type without the attribute."""
    has_attribute = any(_ATTRIBUTE.search(comment) for comment in node.comments)
    if not isinstance(node.type, tree.EnumSpec) or not has_attribute or not dialect.writes_todays_texts:
        return None
    text = _text(node.name, node.type.base or "INT", [value.name for value in node.type.values])
    unit, _ = parse(text, "", dialect)
    (made,) = unit.declarations
    assert isinstance(made, tree.Pou)
    return made


def _text(name: str, base: str, values: Sequence[str]) -> str:
    function = _FUNCTION.format(name)
    lines = [f"FUNCTION {function} : STRING(255)", f"VAR_INPUT value : {name}; END_VAR"]
    lines += [f"IF value = {name}.{value} THEN {function} := '{value}'; RETURN; END_IF" for value in values]
    return "\n".join([*lines, f"{function} := {base}_TO_STRING(value);", "END_FUNCTION"])


def call(context: Context, name: str, values: Sequence[Expression], at: tree.Node) -> Expression | None:
    """Return the call for the text of a value; None if its type has no such function."""
    project = context.project
    if name not in CONVERSIONS or len(values) != 1 or not isinstance(values[0].type, EnumType):
        return None
    function = project.pous.get(project.key(_FUNCTION.format(values[0].type.name)))
    if function is None or function.result is None:
        return None
    if context.pou is not None:
        project.calls.setdefault(context.pou, {}).setdefault(function, position_of(at))
    (value,) = project.sources[function].inputs
    made = CallFunction(function, ((value, values[0]),), function.result.type)
    return constants.converted(made, StringType(255, is_wide=True)) if name == "TO_WSTRING" else made
