"""The checks of a chart as a whole: its steps, its transitions, and the actions that it names."""

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import Variable


def check_chart(body: tree.SfcBody, context: Context) -> bool:
    """Report what is wrong with a chart.  True if it can be lowered."""
    steps: dict[str, tree.Step] = {}
    is_whole = _steps(body, context, steps)
    is_whole = _initial_steps(body, context) and is_whole
    is_whole = _transitions(body, context, steps) and is_whole
    is_whole = _actions(body, context) and is_whole
    if is_whole:
        _unreachable(body, context, steps)
    return is_whole


def _steps(body: tree.SfcBody, context: Context, steps: dict[str, tree.Step]) -> bool:
    """Put the steps into `found` by name."""
    is_whole = True
    for step in body.steps:
        name = context.key(step.name)
        if name in steps:
            context.say(step, f"step {step.name} exists already in line {steps[name].position.line}", "another name")
            is_whole = False
            continue
        steps[name] = step
        if name in context.names:
            context.say(step, f"step {step.name} has the name of a variable", "another name")
            is_whole = False
    return is_whole


def _initial_steps(body: tree.SfcBody, context: Context) -> bool:
    initial = [step for step in body.steps if step.is_initial]
    if not initial:
        context.say(body.steps[0] if body.steps else body, "the chart has no initial step", "INITIAL_STEP name:")
    for step in initial[1:]:
        context.say(step, f"{step.name} is a second initial step, beside {initial[0].name}", "one initial step")
    return len(initial) == 1


def _transitions(body: tree.SfcBody, context: Context, steps: dict[str, tree.Step]) -> bool:
    is_whole = True
    for transition in body.transitions:
        for name in (*transition.sources, *transition.targets):
            if context.key(name) not in steps:
                hint = context.project.reports.closest(name, [step.name for step in body.steps])
                context.say(transition, f"there is no step {name}", "a step of this chart", hint)
                is_whole = False
    return is_whole


def _actions(body: tree.SfcBody, context: Context) -> bool:
    """An action is an action of the POU or a BOOL variable."""
    is_whole = True
    for step in body.steps:
        if step.uses and not context.project.limits.has_iec_steps:
            what = f"{step.name} is an IEC step, for which the controller has no IECsfc.lib"
            expected = "ENTRY, ACTIVE and EXIT in the step, or version V00.06.00 of the controller (PD-204)"
            context.say(step, what, expected)
            is_whole = False
        for use in step.uses:
            is_whole = _action(use, context) and is_whole
            for name in use.indicators:
                if context.find(name) is None:
                    context.say_unknown(use, name, "an indicator variable that is declared")
                    is_whole = False
    return is_whole


def _action(use: tree.ActionUse, context: Context) -> bool:
    actions = context.owner.actions if context.owner is not None else {}
    if context.key(use.name) in actions:
        return True
    entity = context.find(use.name)
    if isinstance(entity, Variable) and entity.type is Elementary.BOOL:
        return True
    if entity is not None:
        context.say(use, f"{use.name} is neither an action nor a BOOL variable", "an action of this POU")
        return False
    known = [name.rpartition(".")[2] for name in (action.name for action in actions.values())]
    hint = context.project.reports.closest(use.name, known)
    context.say(use, f"there is no action {use.name}", f"ACTION {use.name}: ... END_ACTION", hint)
    return False


def _unreachable(body: tree.SfcBody, context: Context, steps: dict[str, tree.Step]) -> None:
    """Report steps that no transition leads to.  It is a note, because the rest of the chart runs."""
    reached = {context.key(step.name) for step in body.steps if step.is_initial}
    is_growing = True
    while is_growing:
        is_growing = False
        for transition in body.transitions:
            if {context.key(name) for name in transition.sources} <= reached:
                targets = {context.key(name) for name in transition.targets}
                is_growing = is_growing or not targets <= reached
                reached |= targets
    for name, step in steps.items():
        if name not in reached:
            context.note(
                step, f"step {step.name} never becomes active", "Add a TRANSITION to it from a step that runs."
            )
