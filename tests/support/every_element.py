"""Documents of the exchange formats that hold every kind of element, for tests that damage them."""

from exchange_documents import block, coil, contact, pou, rail, sink, source, tc6
from object_documents import CODESYS_OBJECTS, PART10_CLASSES

_WIRE = '<connectionPointIn><connection refLocalId="{}"/></connectionPointIn>'

NETWORKS = tc6(
    '<dataTypes><dataType name="T"><baseType><array><dimension lower="1" upper="3"/><baseType><struct>'
    '<variable name="a"><type><INT/></type><initialValue><simpleValue value="3"/></initialValue></variable></struct>'
    "</baseType></array></baseType></dataType></dataTypes>"
    + pou(
        f"<LD>{rail()}{contact('1', 'a', '0', attributes='edge=' + repr('rising'))}{contact('2', 'b', '0')}"
        f"{contact('3', 'c', '1', '2')}{coil('4', 'm', '3', attributes='storage=' + repr('set'))}"
        + source("5", "n + 1")
        + block("6", "ADD", {"EN": "3", "IN1": "5", "IN2": "6.OUT"}, "ENO OUT")
        + block("7", "TON", {"IN": "6.ENO", 'PT negated="true"': "5"}, "Q ET", 'instanceName="t1"')
        + sink("8", "n", "6.OUT")
        + sink("9", "x", "7.Q", attributes='negated="true"')
        + '<label localId="10" label="end"/><jump localId="11" label="end">'
        + _WIRE.format(3)
        + '</jump><return localId="12"/><connector localId="13" name="K">'
        + _WIRE.format(2)
        + '</connector><continuation localId="14" name="K"/>'
        + coil("15", "k", "14")
        + "</LD>",
        variables={"a": "BOOL", "b": "BOOL", "n": "INT", "t1": '<derived name="TON"/>'},
    )
)

CHART = tc6(
    pou(
        "<SFC>"
        '<step localId="1" name="S" initialStep="true"><connectionPointOut formalParameter="s"/></step>'
        f'<selectionDivergence localId="2">{_WIRE.format(1)}</selectionDivergence>'
        f'<transition localId="3" priority="1">{_WIRE.format(2)}<condition><inline name=""><ST>'
        "<xhtml:p>a AND b</xhtml:p></ST></inline></condition></transition>"
        f'<transition localId="4">{_WIRE.format(2)}<condition><reference name="Go"/></condition></transition>'
        f'<simultaneousDivergence localId="5" name="F">{_WIRE.format(3)}</simultaneousDivergence>'
        f'<step localId="6" name="A">{_WIRE.format(5)}</step><step localId="7" name="B">{_WIRE.format(5)}</step>'
        f'<actionBlock localId="8">{_WIRE.format(6)}<action qualifier="D" duration="T#3s"><reference name="lamp"/>'
        "</action><action><inline><ST><xhtml:p>n := 1;</xhtml:p></ST></inline></action></actionBlock>"
        f'<simultaneousConvergence localId="9">{_WIRE.format(6)}{_WIRE.format(7)}</simultaneousConvergence>'
        f'<inVariable localId="10"><expression>a</expression></inVariable><transition localId="11">{_WIRE.format(9)}'
        f'<condition negated="true">{_WIRE.format(10)}</condition></transition>'
        f'<selectionConvergence localId="12">{_WIRE.format(4)}{_WIRE.format(11)}</selectionConvergence>'
        f'<jumpStep localId="13" targetName="S">{_WIRE.format(12)}</jumpStep></SFC>',
        more='<actions><action name="lamp"><body><IL><xhtml:p>LD a\nST b</xhtml:p></IL></body></action></actions>'
        '<transitions><transition name="Go"><body><ST><xhtml:p>a</xhtml:p></ST></body></transition></transitions>',
    ),
    instances='<configuration name="c"><resource name="r"><task name="t" priority="1" interval="PT0.01S">'
    '<pouInstance name="P" typeName=""/></task><globalVars name="G"><variable name="g" address="%QX1.0"><type><BOOL/>'
    "</type></variable></globalVars></resource></configuration>",
)

PART_10 = (
    '<Project xmlns="www.iec.ch/public/TC65SC65BWG7TF10" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"><Types>'
    '<GlobalNamespace><DataTypeDecl name="E"><UserDefinedTypeSpec xsi:type="EnumTypeWithNamedValueSpec"><Enumerator '
    'name="R" value="1"/><BaseType>INT</BaseType></UserDefinedTypeSpec></DataTypeDecl><Program name="P"><Vars '
    'accessSpecifier="private"><Variable name="a"><Type><TypeName>BOOL</TypeName></Type></Variable></Vars><MainBody>'
    '<BodyContent xsi:type="LD"><Rung evaluationOrder="1" label="l"><LdObject xsi:type="LeftPowerRail">'
    '<ConnectionPointOut connectionPointOutId="1"/></LdObject><LdObject xsi:type="Contact" operand="a" edge="rising">'
    '<ConnectionPointIn><Connection refConnectionPointOutId="1"/></ConnectionPointIn><ConnectionPointOut '
    'connectionPointOutId="2"/></LdObject><FbdObject xsi:type="Block" typeName="ADD"><InputVariables><InputVariable '
    'parameterName="IN1"><ConnectionPointIn><FeedbackConnection refConnectionPointOutId="3" feedbackVariable="f"/>'
    '</ConnectionPointIn></InputVariable></InputVariables><OutputVariables><OutputVariable parameterName="OUT">'
    '<ConnectionPointOut connectionPointOutId="3"/></OutputVariable></OutputVariables></FbdObject><LdObject '
    'xsi:type="Coil" operand="m" latch="set"><ConnectionPointIn><Connection refConnectionPointOutId="2"/>'
    "</ConnectionPointIn></LdObject></Rung></BodyContent></MainBody></Program></GlobalNamespace></Types><Instances>"
    '<Configuration name="c"><Resource name="r"><Task name="t" interval="T#5ms" priority="3"/><ProgramInstance name="p"'
    ' typeName="P" associatedTaskName="t"/></Resource></Configuration></Instances></Project>'
)

TWINCAT = (
    '<TcPlcObject><POU Name="P"><Declaration><![CDATA[PROGRAM P\nVAR a : INT; END_VAR]]></Declaration><Implementation>'
    '<ST><![CDATA[a := 1; // x]]></ST></Implementation><Action Name="A"><Implementation><ST>a := 2;</ST>'
    "</Implementation></Action></POU></TcPlcObject>"
)
ENI = "<pou><name>P</name><interface><![CDATA[PROGRAM P]]></interface><st><body><![CDATA[;]]></body></st></pou>"
DOCUMENTS = (NETWORKS, CHART, PART_10, TWINCAT, ENI, CODESYS_OBJECTS, PART10_CLASSES)
