"""Documents with interfaces, classes and methods: an export of the CODESYS family, and one of IEC 61131-10."""

from exchange_documents import tc6


def variable(name: str, type: str) -> str:
    return f'<variable name="{name}"><type>{type}</type></variable>'


PREFIX = "http://www.3s-software.com/plcopenxml"


def added(kind: str, content: str) -> str:
    return f'<data name="{PREFIX}/{kind}" handleUnknown="implementation">{content}</data>'


def access(words: str) -> str:
    return f"<addData>{added('accessmodifiers', f'<AccessModifiers {words}/>')}</addData>"


def text_of(words: str) -> str:
    text = f'<InterfaceAsPlainText><xhtml xmlns="http://www.w3.org/1999/xhtml">{words}</xhtml></InterfaceAsPlainText>'
    return f"<addData>{added('interfaceasplaintext', text)}</addData>"


def st_body(text: str) -> str:
    return f'<body><ST><xhtml xmlns="http://www.w3.org/1999/xhtml">{text}</xhtml></ST></body>'


AMOUNT = f"<inputVars>{variable('amount', '<INT/>')}</inputVars>"
CODESYS_OBJECTS = tc6("<dataTypes/><pous/>", version="0200").replace(
    "</project>",
    "<addData>"
    + added(
        "interface",
        f'<Interface name="I_Fill"><Methods><Method name="Fill"><interface><returnType><BOOL/></returnType>{AMOUNT}'
        '</interface></Method></Methods><Properties><Property name="Level"><interface><returnType><INT/></returnType>'
        "</interface><GetAccessor><interface/></GetAccessor></Property></Properties></Interface>",
    )
    + added(
        "pou",
        '<pou name="Vessel" pouType="functionBlock"><interface><localVars>'
        + variable("held", "<INT/>")
        + text_of("FUNCTION_BLOCK ABSTRACT Vessel IMPLEMENTS LIB.I_Fill // METHOD FINAL x\nVAR\n held : INT;\nEND_VAR")
        + "</localVars><addData>"
        + added("pouinheritance", "<Inheritance><Implements>LIB.I_Fill</Implements></Inheritance>")
        + f"</addData></interface>{st_body('')}<addData>"
        + added(
            "method",
            '<Method name="Room" ObjectId="1"><interface><returnType><INT/></returnType>'
            + access('Abstract="true" Protected="true"')
            + f"</interface>{st_body('')}</Method>",
        )
        + added(
            "method",
            f'<Method name="Fill" ObjectId="2"><interface><returnType><BOOL/></returnType>{AMOUNT}</interface>'
            + st_body("Fill := held + amount &lt;= Room(); IF Fill THEN held := held + amount; END_IF")
            + "<InterfaceAsPlainText><xhtml>METHOD FINAL Fill : BOOL</xhtml></InterfaceAsPlainText><addData/></Method>",
        )
        + added(
            "property",
            '<Property name="Level" ObjectId="3"><interface><returnType><INT/></returnType>'
            + access("")
            + "</interface>"
            + f"<GetAccessor><interface/>{st_body('Level := held;')}<addData/></GetAccessor><addData/></Property>",
        )
        + "</addData></pou>",
    )
    + added(
        "pou",
        '<pou name="Drum" pouType="functionBlock"><interface><addData>'
        + added("pouinheritance", "<Inheritance><Extends>Vessel</Extends></Inheritance>")
        + f"</addData></interface>{st_body('')}<addData>"
        + added(
            "method",
            '<Method name="Room" ObjectId="4"><interface><returnType><INT/></returnType>'
            + access('Protected="true"')
            + f"</interface>{st_body('Room := 15;')}</Method>",
        )
        + "</addData></pou>",
    )
    + added(
        "pou",
        '<pou name="PLC_PRG" pouType="program"><interface><localVars>'
        + variable("oil", '<derived name="Drum"/>')
        + variable("a", "<BOOL/>")
        + variable("b", "<BOOL/>")
        + variable("n", "<INT/>")
        + variable("any", '<derived name="I_Fill"/>')
        + "</localVars></interface>"
        + st_body("any := oil; a := any.Fill(12); b := oil.Fill(4); n := any.Level;")
        + "</pou>",
    )
    + "</addData></project>",
)


XSI = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'


def part10(content: str, instances: str = "") -> str:
    """A project of IEC 61131-10."""
    return (
        f'<Project xmlns="www.iec.ch/public/TC65SC65BWG7TF10" {XSI} schemaVersion="1.0">'
        '<FileHeader companyName="" productName="test" productVersion="1"/>'
        '<ContentHeader name="test" creationDateTime="2026-01-01T00:00:00"/>'
        f"<Types><GlobalNamespace>{content}</GlobalNamespace></Types><Instances>{instances}</Instances></Project>"
    )


def named(name: str, type: str) -> str:
    return f'<Variable name="{name}"><Type><TypeName>{type}</TypeName></Type></Variable>'


def content(kind: str, inside: str, more: str = "") -> str:
    return f'<BodyContent xsi:type="{kind}" {more}>{inside}</BodyContent>'


def result(kind: str) -> str:
    return f"<ResultType><TypeName>{kind}</TypeName></ResultType>"


def inputs(*variables: str) -> str:
    return f"<Parameters><InputVars>{''.join(variables)}</InputVars></Parameters>"


def body(text: str) -> str:
    return f"<MainBody>{content('ST', f'<ST><![CDATA[{text}]]></ST>')}</MainBody>"


PART10_CLASSES = part10(
    f'<Interface name="Filling"><Method name="Fill">{result("BOOL")}{inputs(named("amount", "REAL"))}</Method>'
    "</Interface>"
    f'<Class name="Vessel" abstract="true"><Implements><TypeName>Shop\\Filling</TypeName></Implements>'
    f'<Vars accessSpecifier="protected">{named("held", "REAL")}</Vars>'
    f'<Method name="Room" accessSpecifier="public" abstract="true">{result("REAL")}</Method>'
    f'<Method name="Fill" accessSpecifier="public" final="true">{result("BOOL")}{inputs(named("amount", "REAL"))}'
    f"{body('IF held + amount <= Room() THEN held := held + amount; Fill := TRUE; END_IF;')}</Method></Class>"
    '<Class name="Drum"><Extends><TypeName>Vessel</TypeName></Extends>'
    f'<Vars accessSpecifier="public">{named("height", "REAL")}</Vars>'
    f'<Method name="Room" accessSpecifier="public" override="true">{result("REAL")}{body("Room := 3.0 * height;")}'
    "</Method></Class>"
    f'<FunctionBlock name="Pump" final="true"><Vars accessSpecifier="private">{named("n", "INT")}</Vars>'
    f'<Method name="Step" accessSpecifier="public">{body("n := n + 1;")}</Method>{body("Step();")}</FunctionBlock>'
    f'<Program name="PLC_PRG"><Vars accessSpecifier="private">{named("oil", "Drum")}{named("a", "BOOL")}'
    f"{named('b', 'BOOL')}{named('p', 'Pump')}</Vars>"
    f"{body('oil.height := 5.0; a := oil.Fill(12.0); b := oil.Fill(4.0); p();')}</Program>"
)
