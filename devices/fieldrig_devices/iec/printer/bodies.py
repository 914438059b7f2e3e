"""Bodies as text, with charts."""

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.printer import statements
from fieldrig_devices.iec.printer.expressions import expression_text as text_of
from fieldrig_devices.iec.printer.lines import INDENT, Lines


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
