"""The reserved words and the symbolic values (appendix A of the manual, and the words of its chapters)."""

from collections.abc import Mapping
from typing import Final

_STRUCTURE = """
    ABORT ABORT_SEQUENCE ACTION ACTIONS APPLICATION BOOLEAN CALL CASE COMMON CONDITION DUALPORT_IN DUALPORT_OUT
    DUAL_PORT DUPL_START ELSE END END_ACTION END_ACTIONS END_BOOLEAN END_CASE END_DUALPORT END_EVENTS END_IF END_LOOP
    END_PORT END_POWERON END_ROUTINE END_ROUTINES END_SEQUENCE END_SPECS END_TASK ENTRY EQUATION EVENTS EXCEPTION
    EXCEPTION_ENTRY IF INTERNAL LINKED_OUTPUT LOOP NAME ON ON_EVENT ON_STATE POWERON REMOVE_EXCEPTION ROUTINES SEQUENCE
    SPECS TASK THEN VME WAIT WAIT_TIME WITH XEQ_ACTION XEQ_SEQUENCE XEQ_TASK
"""
STRUCTURE: Final = frozenset(_STRUCTURE.split())
"""Words that build declarations and statements.  DUALPORT does so behind VME only; DualPort is an object."""

_SYMBOLIC = """
    HIGH LOW YES NO NONE CURRENT MAX RISING FALLING INC DEC POSITION SPEED TORQUE VALUE ONCE REPETITIVE IMMEDIATE
    ON_REQUEST INPUT OUTPUT NEXT_PERIOD POSITIVE NEGATIVE ZERO_MAXIMUM ZERO_MINIMUM ON_OFF TOGGLE AUTOREPEAT HEXA ST1
    SMART_IO PI TIMEOUT
"""
SYMBOLIC: Final = frozenset(_SYMBOLIC.split())
"""Words that stand for a value."""

LABEL_KEYWORDS: Final = STRUCTURE | {"TIMEOUT"}
"""Words that end a list of statements or begin one, so that they are never the name of an object."""

PREDECLARED: Final[Mapping[str, str]] = {
    "PAMDISPLAY": "PAMDISPLAY",
    "PamDisplay": "PAMDISPLAY",
    "DualPort": "DUALPORT",
    "RS422Port": "RS422PORT",
}
"""Objects that every application has, under the spellings of the manual, with their kinds."""
