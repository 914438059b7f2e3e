"""Messages, alarms and listeners of Tc3_EventLogger, and the lists of events that TwinCAT makes of a project."""

from pathlib import Path

import pytest
from plc_project import project
from st_tests import one
from typer.testing import CliRunner

from fieldrig_devices.iec.commands import app
from fieldrig_devices.iec.imports.event_classes import classes_of, declarations
from fieldrig_devices.iec.imports.report import Report
from fieldrig_devices.iec.testing.case import Verdict

TMC = """<?xml version="1.0"?>
<TcModuleClass><DataTypes>
<DataType><Name GUID="{97CF8247-B59C-4E2C-B4B0-7350D0471457}">Oven</Name>
<DisplayName TxtId=""><![CDATA[The oven]]></DisplayName><DisplayName TxtId="" LcId="1031">Der Ofen</DisplayName>
<EventId><Name Id="3">TooHot</Name><DisplayName TxtId=""><![CDATA[It's {1} degrees {0}, {x} {2}]]></DisplayName>
<DisplayName TxtId="" LcId="1031">Zone {0} ist zu heiß: {1}$</DisplayName><Severity>Warning</Severity></EventId>
<EventId><Name Id="4">Burnt</Name><Severity>Critical</Severity></EventId>
</DataType>
<DataType><Name GUID="{B57D3F4A-0836-49B0-81C3-BED5F4817EC9}">TcEventSeverity</Name>
<EnumInfo><Text>TCEVENTSEVERITY_Verbose</Text><Enum>0</Enum></EnumInfo></DataType>
</DataTypes></TcModuleClass>
"""
EVENTS = declarations(classes_of(TMC, Report("oven.tmc")))
LISTENER = """
FUNCTION_BLOCK Heard EXTENDS FB_ListenerBase
VAR sent, raised, cleared, confirmed : INT; id : UDINT; source : STRING(100); json : STRING(200); END_VAR
METHOD OnMessageSent VAR_INPUT fbEvent : REFERENCE TO FB_TcEvent; END_VAR
sent := sent + 1; id := fbEvent.nEventId; source := fbEvent.ipSourceInfo.sName;
fbEvent.GetJsonAttribute(json, SIZEOF(json));
END_METHOD
METHOD OnAlarmRaised VAR_INPUT fbEvent : REFERENCE TO FB_TcEvent; END_VAR raised := raised + 1; END_METHOD
METHOD OnAlarmCleared VAR_INPUT fbEvent : REFERENCE TO FB_TcEvent; END_VAR cleared := cleared + 1; END_METHOD
METHOD OnAlarmConfirmed VAR_INPUT fbEvent : REFERENCE TO FB_TcEvent; END_VAR confirmed := confirmed + 1; END_METHOD
END_FUNCTION_BLOCK
"""
VARIABLES = """VAR
    m : FB_TcMessage; a : FB_TcAlarm; l : FB_TcEventLogger; s : FB_TcSourceInfo; given : FB_TcArguments;
    r : FB_RequestEventText;
    h : Heard; c : ITcEventFilterConfig; i : I_TcMessage; text : STRING(80); n : INT; isWrong : BOOL;
END_VAR
"""
HOLDS = [
    (
        "ASSERT_LT(m.Send(0), 0, 'not created yet'); ASSERT_EQ(m.CreateEx(TC_EVENTS.Oven.TooHot, 0), 0);"
        "ASSERT_EQ(m.Send(0), 0); m.Release(); ASSERT_TRUE(FAILED(m.Send(0)));"
    ),
    (
        "m.CreateEx(TC_EVENTS.Oven.Burnt, 0); m.ipArguments.Clear().AddString('at').AddInt(5);"
        "ASSERT_TRUE(m.RequestEventText(1033, text, SIZEOF(text))); ASSERT_EQ(text, 'at 5', 'it has no text');"
        "m.ipArguments.Clear(); m.RequestEventText(1033, text, SIZEOF(text)); ASSERT_EQ(text, '');"
    ),
    (
        "m.CreateEx(TC_EVENTS.Oven.TooHot, 0); m.ipArguments.Clear().AddString('below').AddInt(250);"
        "m.RequestEventText(1033, text, SIZEOF(text)); ASSERT_EQ(text, 'It$'s 250 degrees below, {x} ');"
        "m.RequestEventText(1031, text, SIZEOF(text)); ASSERT_EQ(text, 'Zone below ist zu hei$DF: 250$$');"
        "m.RequestEventText(1036, text, SIZEOF(text)); ASSERT_EQ(text, 'It$'s 250 degrees below, {x} ');"
        "m.RequestEventText(1033, text, 5); ASSERT_EQ(text, 'It$'s');"
        "m.RequestEventClassName(1031, text, SIZEOF(text)); ASSERT_EQ(text, 'Der Ofen');"
        "m.RequestEventClassName(1033, text, SIZEOF(text)); ASSERT_EQ(text, 'The oven');"
        "m.RequestEventClassName(1033, text, 8, bError => isWrong); ASSERT_TRUE(isWrong);"
    ),
    (
        "r.Request(TC_EVENT_CLASSES.Oven, 3, 1031, given.AddInt(7).AddReal(1.5));"
        "ASSERT_TRUE(r.GetString(text, SIZEOF(text))); ASSERT_EQ(text, 'Zone 7 ist zu hei$DF: 1.5$$');"
    ),
    (
        "m.CreateEx(TC_EVENTS.Oven.TooHot, 0); i := m; ASSERT_TRUE(i.EqualsToEventEntryEx(TC_EVENTS.Oven.TooHot));"
        "ASSERT_FALSE(i.EqualsToEventEntryEx(TC_EVENTS.Oven.Burnt)); ASSERT_EQ(i.nEventId, 3);"
        "ASSERT_EQ(GUID_TO_STRING(i.EventClass), '97CF8247-B59C-4E2C-B4B0-7350D0471457');"
    ),
    (
        "h.Subscribe(ADR(c), 0); c.AddEventClass(TC_EVENT_CLASSES.Oven, TcEventSeverity.Info); s.sName := 'here';"
        "m.CreateEx(TC_EVENTS.Oven.TooHot, s); m.SetJsonAttribute('{}'); m.Send(0); h.Execute(); h.Execute();"
        "ASSERT_EQ(h.sent, 1); ASSERT_EQ(h.id, 3); ASSERT_EQ(h.source, 'here'); ASSERT_EQ(h.json, '{}');"
    ),
    (
        "h.Subscribe(ADR(c), 0); c.AddEventClass(TC_EVENT_CLASSES.Oven, TcEventSeverity.Error);"
        "m.CreateEx(TC_EVENTS.Oven.TooHot, 0); m.Send(0); h.Execute(); ASSERT_EQ(h.sent, 0, 'a warning is no error');"
    ),
    (
        "h.Subscribe(0, 0); l.SendMessageEx(TC_EVENTS.Oven.Burnt, s, 0, given.AddString('black')); h.Execute();"
        "ASSERT_EQ(h.sent, 1); ASSERT_EQ(h.id, 4); h.Unsubscribe(); ASSERT_EQ(h.Execute(), 1);"
    ),
    (
        "h.Subscribe(0, 0); a.CreateEx(TC_EVENTS.Oven.Burnt, TRUE, 0); ASSERT_EQ(a.Raise(0), 0);"
        "ASSERT_EQ(a.Raise(0), 1);"
        "ASSERT_TRUE(a.bRaised); ASSERT_EQ(a.Clear(0, FALSE), 0); ASSERT_FALSE(a.bRaised); ASSERT_TRUE(a.bActive);"
        "ASSERT_EQ(a.Confirm(0), 0); ASSERT_FALSE(a.bActive); ASSERT_EQ(a.Confirm(0), 1);"
        "ASSERT_EQ(a.eConfirmationState, TcEventConfirmationState.Confirmed); h.Execute();"
        "ASSERT_EQ(h.raised, 1); ASSERT_EQ(h.cleared, 1); ASSERT_EQ(h.confirmed, 1);"
    ),
    (
        "h.Subscribe(0, 0); m.CreateEx(TC_EVENTS.Oven.TooHot, 0); FOR n := 1 TO 70 DO m.Send(0); END_FOR; h.Execute();"
        "ASSERT_EQ(h.sent, 32, 'the oldest are lost');"
    ),
]


@pytest.mark.parametrize("body", HOLDS)
def test_events_happen_and_are_heard(tmp_path: Path, body: str) -> None:
    outcome = one(tmp_path, VARIABLES + body, EVENTS + LISTENER, dialect="codesys")
    assert (outcome.verdict, outcome.failures) == (Verdict.PASSED, ())


@pytest.mark.parametrize(
    "text",
    [
        TMC.replace("EventId", "SubItem"),
        TMC.replace("97CF8247-", ""),
        TMC.replace(">Oven<", ">2 ovens<"),
        "<TcModuleClass>",
        "<Other><DataTypes/></Other>",
    ],
)
def test_what_is_no_class_of_events_is_left_out(text: str) -> None:
    assert declarations(classes_of(text, Report("oven.tmc"))) == ""


SUITE = """FUNCTION_BLOCK OvenTest EXTENDS TcUnit.FB_TestSuite
VAR message : FB_TcMessage; text : STRING(80); END_VAR
TEST('numbers');
message.CreateEx(TC_EVENTS.Oven.Burnt, 0);
AssertEquals_UDINT(4, message.nEventId, '');
message.RequestEventClassName(1031, text, SIZEOF(text));
AssertEquals_STRING('Der Ofen', text, '');
AssertTrue(message.eSeverity = TcEventSeverity.Critical, 'critical');
TEST_FINISHED();
END_FUNCTION_BLOCK
"""


def test_a_suite_has_the_events_of_its_project(tmp_path: Path) -> None:
    (tmp_path / "Oven.tmc").write_text(TMC)
    done = CliRunner().invoke(app, ["test", str(project(tmp_path / "Plc", {"OvenTest.st": SUITE}))])
    assert done.exit_code == 0, done.output
    assert "1 test: 1 passed" in done.output
