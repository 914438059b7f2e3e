"""The parts of a test file as text."""

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.printer.bodies import body
from fieldrig_devices.iec.printer.expressions import expression_text
from fieldrig_devices.iec.printer.lines import Lines
from fieldrig_devices.iec.printer.variables import variables


def part_of_tests(lines: Lines, node: tree.Test | tree.Use | tree.RigUse) -> None:
    match node:
        case tree.Use(file=file):
            lines.front(node)
            lines.add(f"USES {quoted(file)};")
            lines.behind(node)
        case tree.RigUse():
            _rig(lines, node)
        case tree.Test():
            _test(lines, node)


def quoted(text: str) -> str:
    """Return a text in quotes, as USES, RIG, TEST and AT have it."""
    return "'" + text.replace("$", "$$").replace("'", "$'") + "'"


def _rig(lines: Lines, use: tree.RigUse) -> None:
    lines.front(use)
    after = f" AFTER {expression_text(use.delay)}" if use.delay is not None else ""
    lines.add(f"RIG {quoted(use.file)}{after};")
    lines.behind(use)


def _test(lines: Lines, test: tree.Test) -> None:
    lines.front(test)
    if test.spelled:
        lines.add(f"{test.spelled} {test.name}")
    else:
        lines.add(" ".join([test.word.value, *([quoted(test.name)] if test.word is tree.TestWord.TEST else [])]))
    if test.rig is not None:
        _rig(lines, test.rig)
    if test.skip is not None:
        lines.add(f"SKIP {quoted(test.skip)};")
    for block in test.blocks:
        lines.front(block)
        variables(lines, block)
    if test.blocks:
        lines.add("")
    body(lines, test.body)
    lines.comments(test.after)
    lines.add(f"END_{test.spelled or test.word.value}")
    if test.remark:
        lines.append(f" {test.remark}")
