"""Passages of the manual about programs that can be read in two ways.  The defaults are the likelier readings."""

from dataclasses import dataclass
from typing import Literal

Events = Literal["remembered", "counted", "sampled"]
"""Events between two cycles of their group count once, each of them counts, or none does."""

StartEvents = Literal["changes", "all", "none"]
"""Events before the POWERON parts have finished: those that occur then count, all that are true then, or none."""


@dataclass(frozen=True, slots=True)
class Readings:
    events: Events = "remembered"
    events_at_start: StartEvents = "changes"
    common_variables_cause_events: bool = False
    """False: ON_EVENT and EXCEPTION take no notice of a COMMON variable until something else in them changes.

    COMMON variables "do not produce event" (manual line 2644).
    """
    remembers_conditions: bool = False
    """True: CONDITION and CASE go on after a short event as well, which is over before the cycle of the task."""
    actions_first: bool = False
    """True: all actions come before all sequences in a basic cycle, whatever the order of their declarations."""
    equations_last: bool = False
    """True: equations are evaluated after the programs of a basic cycle, not before them."""
    exceptions_wake: bool = True
    """False: an exception of a suspended sequence waits for the end of the wait."""
    exceptions_occur_once: bool = False
    """True: an exception that has occurred is over; its sequence has none until it arms another one."""
    duplicates_of: Literal["sequence", "task"] = "sequence"
    """DUPL counts the items of one sequence, or those of all sequences of the task."""
    error_stops_task: bool = False
    """True: a task whose sequence has ended by 03..E031, E032 or E033 starts no other one until the reset."""
    math_error_is_fatal: bool = True
    """False: an error of a function or of ^ has a finite result instead of stopping the application by 02..FFF3."""
    zero_to_zero_is_error: bool = False
    """True: 0 ^ 0 is such an error; False: it is 1.0."""
    checks_workspaces: bool = True
    """The "stack control" without which a workspace that is too small has no consequences."""
    workspace_error: Literal["E", "F"] = "E"
    """The type of the message about such a workspace, 03..E02C or 03..F02C."""
