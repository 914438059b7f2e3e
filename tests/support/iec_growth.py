"""Texts that grow by one construct of the language each, for the work that a compiler has with them."""

from collections.abc import Callable, Iterable
from typing import Final


def main(declarations: str = "", body: str = "", before: str = "") -> str:
    return f"{before}\nPROGRAM PLC_PRG\nVAR\nx, y : INT; b : BOOL;\n{declarations}\nEND_VAR\n{body}\nEND_PROGRAM\n"


def lines(texts: Iterable[str]) -> str:
    return "\n".join(texts)


def each(count: int, text: str) -> str:
    """Repeat a text; `@` in it is the number from 0, and `@@` the number before."""
    return lines(text.replace("@@", str(max(number - 1, 0))).replace("@", str(number)) for number in range(count))


def nested(count: int, before: str, inside: str, after: str) -> str:
    return before * count + inside + after * count


def chain(count: int, text: str, between: str = " + ") -> str:
    return between.join(text.replace("@", str(number)) for number in range(count))


def block(count: int, body: str, head: str = "FUNCTION_BLOCK F@", tail: str = "END_FUNCTION_BLOCK") -> str:
    return each(count, f"{head}\n{body}\n{tail}")


STRUCTURE: Final = "TYPE S@ : STRUCT {} END_STRUCT; END_TYPE"
FIRST: Final = "TYPE S : STRUCT a : INT; END_STRUCT; END_TYPE\n"
FIRST_BLOCK: Final = "FUNCTION_BLOCK F VAR_INPUT i : INT; END_VAR VAR n : INT; END_VAR n := i; END_FUNCTION_BLOCK\n"
POINTED: Final = "TYPE S : STRUCT next : POINTER TO S; a : INT; END_STRUCT; END_TYPE\n"

WIDE: Final[dict[str, Callable[[int], str]]] = {
    "variables": lambda n: main(each(n, "v@ : INT;")),
    "variables of one type": lambda n: main(chain(n, "v@", ", ") + " : INT;"),
    "sections of variables": lambda n: main(each(n, "END_VAR VAR v@ : INT;")),
    "start values": lambda n: main(each(n, "v@ : INT := @ MOD 100 + 1;")),
    "comments": lambda n: main(each(n, "v@ : INT; (* number @ *)")),
    "global variables": lambda n: main("", "g0 := 1;", f"VAR_GLOBAL\n{each(n, 'g@ : INT;')}\nEND_VAR"),
    "lists of global variables": lambda n: main("", "g0 := 1;", each(n, "VAR_GLOBAL g@ : INT; END_VAR")),
    "external variables": lambda n: main(
        f"END_VAR VAR_EXTERNAL {each(n, 'g@ : INT;')}", "g0 := 1;", f"VAR_GLOBAL\n{each(n, 'g@ : INT;')}\nEND_VAR"
    ),
    "constants": lambda n: main(
        "", "x := c0;", f"VAR_GLOBAL CONSTANT\nc0 : INT := 1;\n{each(n, 'd@ : INT := c0 + 1;')}\nEND_VAR"
    ),
    "retained variables": lambda n: main(f"END_VAR VAR RETAIN {each(n, 'r@ : INT;')}"),
    "located variables": lambda n: main("", "m0 := 1;", f"VAR_GLOBAL {each(n, 'm@ AT %MW@ : INT;')} END_VAR"),
    "variables of one address": lambda n: main(
        "", "m0 := TRUE;", f"VAR_GLOBAL {each(n, 'm@ AT %MX1.0 : BOOL;')} END_VAR"
    ),
    "types": lambda n: main("v : T0;", "", each(n, "TYPE T@ : INT; END_TYPE")),
    "subranges": lambda n: main("v : T0;", "", each(n, "TYPE T@ : INT(0..@); END_TYPE")),
    "structures": lambda n: main("v : S0;", "", each(n, STRUCTURE.format("a : INT; c : BOOL;"))),
    "components": lambda n: main(
        "v : S;", "v.a1 := 1;", f"TYPE S : STRUCT {each(n, 'a@ : INT;')} END_STRUCT; END_TYPE"
    ),
    "components with start values": lambda n: main(
        "v : S;", "v.a1 := 1;", f"TYPE S : STRUCT {each(n, 'a@ : INT := 5;')} END_STRUCT; END_TYPE"
    ),
    "accesses to components": lambda n: main(
        "v : S;", each(n, "v.a@ := 1;"), f"TYPE S : STRUCT {each(n, 'a@ : INT;')} END_STRUCT; END_TYPE"
    ),
    "start values of components": lambda n: main(
        f"v : S := ({chain(n, 'a@ := 1', ', ')});", "", f"TYPE S : STRUCT {each(n, 'a@ : INT;')} END_STRUCT; END_TYPE"
    ),
    "values of an enumeration": lambda n: main("v : E;", "v := e1;", f"TYPE E : ({chain(n, 'e@', ', ')}); END_TYPE"),
    "numbers of an enumeration": lambda n: main(
        "v : E;", "v := e1;", f"TYPE E : ({chain(n, 'e@ := @', ', ')}); END_TYPE"
    ),
    "uses of an enumeration": lambda n: main(
        "v : E;", each(n, "IF v = e@ THEN v := e1; END_IF;"), f"TYPE E : ({chain(n, 'e@', ', ')}); END_TYPE"
    ),
    "branches of an enumeration": lambda n: main(
        "v : E;",
        f"CASE v OF {each(n, 'e@: x := 1;')} END_CASE;",
        f"TYPE E : ({chain(n, 'e@', ', ')}); END_TYPE",
    ),
    "enumerations": lambda n: main("v : E0;", "", each(n, "TYPE E@ : (a@, b@, c@); END_TYPE")),
    "enumerations of variables": lambda n: main(each(n, "v@ : (a@, b@);"), ""),
    "start values of an array": lambda n: main(f"v : ARRAY[1..{n}] OF INT := {chain(n, '@', ', ')};"),
    "repeated start values": lambda n: main(f"v : ARRAY[1..{2 * n}] OF INT := {chain(n, '2(@)', ', ')};"),
    "arrays": lambda n: main(each(n, "v@ : ARRAY[1..2] OF INT;"), each(n, "v@[x] := 1;")),
    "arrays of structures": lambda n: main(each(n, "v@ : ARRAY[1..2] OF S;"), each(n, "v@[x].a := 1;"), FIRST),
    "strings": lambda n: main(
        each(n, "v@ : STRING(@) := 'text @';").replace("(0)", "(1)").replace("STRING(", "STRING(1"), ""
    ),
    "pointers": lambda n: main(each(n, "v@ : POINTER TO INT;"), each(n, "v@ := ADR(x);")),
    "function blocks": lambda n: main("f : F0;", "f();", block(n, "VAR i : INT; END_VAR\ni := 1;")),
    "instances": lambda n: main(each(n, "f@ : F;"), each(n, "f@(i := 1);"), FIRST_BLOCK),
    "instances of the standard": lambda n: main(each(n, "f@ : TON;"), each(n, "f@(IN := b, PT := T#1s);")),
    "inputs": lambda n: main(
        "f : F;",
        f"f({chain(n, 'i@ := @', ', ')});",
        f"FUNCTION_BLOCK F VAR_INPUT {each(n, 'i@ : INT;')} END_VAR ; END_FUNCTION_BLOCK",
    ),
    "outputs": lambda n: main(
        each(n, "o@ : INT;") + "f : F;",
        f"f({chain(n, 'o@ => o@', ', ')});",
        f"FUNCTION_BLOCK F VAR_OUTPUT {each(n, 'o@ : INT;')} END_VAR ; END_FUNCTION_BLOCK",
    ),
    "variables by reference": lambda n: main(
        "f : F;",
        f"f({chain(n, 'i@ := x', ', ')});",
        f"FUNCTION_BLOCK F VAR_IN_OUT {each(n, 'i@ : INT;')} END_VAR ; END_FUNCTION_BLOCK",
    ),
    "inputs of a function": lambda n: main(
        "",
        f"x := F({chain(n, '@', ', ')});",
        f"FUNCTION F : INT VAR_INPUT {each(n, 'i@ : INT;')} END_VAR F := i0; END_FUNCTION",
    ),
    "functions": lambda n: main(
        "", "x := F0(1);", each(n, "FUNCTION F@ : INT VAR_INPUT i : INT; END_VAR F@ := i; END_FUNCTION")
    ),
    "functions that call one another": lambda n: main(
        "", "x := F0(1);", each(n, "FUNCTION F@ : INT VAR_INPUT i : INT; END_VAR F@ := F@@(i); END_FUNCTION")
    ),
    "functions that call the next": lambda n: main(
        "",
        "x := F0(1);",
        lines(f"FUNCTION F{k} : INT VAR_INPUT i : INT; END_VAR F{k} := F{k + 1}(i); END_FUNCTION" for k in range(n))
        + f"\nFUNCTION F{n} : INT VAR_INPUT i : INT; END_VAR F{n} := i; END_FUNCTION",
    ),
    "calls of functions": lambda n: main(
        "", each(n, "x := F(@);"), "FUNCTION F : INT VAR_INPUT i : INT; END_VAR F := i; END_FUNCTION"
    ),
    "calls of the standard's functions": lambda n: main("", each(n, "x := MAX(x, MIN(y, @));")),
    "actions": lambda n: (
        "PROGRAM PLC_PRG VAR x : INT; END_VAR x := 1;\nEND_PROGRAM\n" + each(n, "ACTION a@: x := 1; END_ACTION")
    ),
    "instances in a configuration": lambda n: (
        main()
        + (
            "CONFIGURATION c RESOURCE r ON PLC TASK t(INTERVAL := T#10ms, PRIORITY := 1);\n"
            + each(n, "PROGRAM i@ WITH t : p@;")
            + "\nEND_RESOURCE END_CONFIGURATION\n"
            + each(n, "PROGRAM p@ VAR i : INT; END_VAR i := 1; END_PROGRAM")
        )
    ),
    "addresses of instances": lambda n: (
        "FUNCTION_BLOCK L VAR i AT %I* : BOOL; END_VAR ; END_FUNCTION_BLOCK\n"
        + main(each(n, "l@ : L;"))
        + f"VAR_CONFIG\n{each(n, 'PLC_PRG.l@.i AT %IX@.0 : BOOL;')}\nEND_VAR"
    ),
    "start values in a configuration": lambda n: (
        f"TYPE S : STRUCT\n{each(n, 'm@ : INT;')}\nEND_STRUCT; END_TYPE\n"
        + main("s : S;")
        + f"VAR_CONFIG\n{each(n, 'PLC_PRG.s.m@ : INT := @;')}\nEND_VAR"
    ),
    "programs": lambda n: main("", "p0();", each(n, "PROGRAM p@ VAR i : INT; END_VAR i := 1; END_PROGRAM")),
    "assignments": lambda n: main("", each(n, "x := x + 1;")),
    "conditions": lambda n: main("", each(n, "IF x = @ THEN y := 1; ELSE y := 2; END_IF;")),
    "alternatives": lambda n: main("", f"IF x = -1 THEN y := 0; {each(n, 'ELSIF x = @ THEN y := 1;')} END_IF;"),
    "branches": lambda n: main("", f"CASE x OF {each(n, '@: y := 1;')} END_CASE;"),
    "labels of a branch": lambda n: main("", f"CASE x OF {chain(n, '@', ', ')}: y := 1; END_CASE;"),
    "ranges of branches": lambda n: main("", f"CASE x OF {each(n, '@0..@5: y := 1;')} END_CASE;"),
    "loops": lambda n: main("", each(n, "FOR x := 0 TO 9 DO y := 1; END_FOR; WHILE b DO EXIT; END_WHILE;")),
    "empty statements": lambda n: main("", ";" * n),
    "numbers": lambda n: main("", each(n, "x := @ MOD 16#FF;")),
    "texts": lambda n: main("s : STRING;", each(n, "s := 'text @';")),
    "times": lambda n: main("t : TIME;", each(n, "t := T#1m@s;")),
    "long text": lambda n: main("s : STRING;", f"s := '{'a' * n}';"),
    "long number": lambda n: main("", f"x := {'0' * n}1;"),
    "long name": lambda n: main(f"v{'a' * n} : INT;", f"v{'a' * n} := 1;"),
    "long comment": lambda n: main("", f"(* {'* ( ' * n} *) ;"),
    "open comment": lambda n: main("", "(* " * n),
    "pragmas": lambda n: main(each(n, "{attribute 'hide'} v@ : INT;")),
    "terms": lambda n: main("", f"x := {chain(n, 'y')};"),
    "mixed terms": lambda n: main("", f"x := {chain(n, 'y * 2 - 3', ' + ')};"),
    "conditions of a chain": lambda n: main("", f"b := {chain(n, '(x = @)', ' OR ')};"),
    "comparisons of a chain": lambda n: main("", f"b := {chain(n, 'b', ' = ')};"),
    "components of pointers": lambda n: main(
        "p : POINTER TO S; s : S;", f"p := ADR(s); x := p{'^.next' * n}^.a;", POINTED
    ),
    "operations of IL": lambda n: main("", "LD x\n" + "ADD 1\n" * n + "ST y\n"),
    "labels of IL": lambda n: main("", each(n, "l@: LD x\nST y\nJMP l@@\n")),
    "jumps of IL over one another": lambda n: main(
        "",
        lines(f"l{k}: LD b\nJMPC l{k + 2}\nLD x\nST y" for k in range(n))
        + f"\nl{n}: LD x\nST y\nl{n + 1}: LD x\nST y\n",
    ),
    "jumps of IL back": lambda n: main("", each(n, "l@: LD b\nJMPC l0\nLD x\nST y")),
    "brackets of IL": lambda n: main("", each(n, "LD x\nADD( y\nMUL 2\n)\nST x\n")),
    "steps": lambda n: main(
        "",
        "INITIAL_STEP s0 : END_STEP\n"
        + lines(
            f"TRANSITION FROM s{k} TO s{k + 1} := b; END_TRANSITION STEP s{k + 1} : a0(N); END_STEP" for k in range(n)
        )
        + f"\nTRANSITION FROM s{n} TO s0 := b; END_TRANSITION\nACTION a0: x := 1; END_ACTION",
    ),
    "actions of a step": lambda n: main(
        "",
        f"INITIAL_STEP s0 : {each(n, 'a@(N);')} END_STEP TRANSITION FROM s0 TO s0 := b; END_TRANSITION\n"
        + each(n, "ACTION a@: x := 1; END_ACTION"),
    ),
    "parallel steps": lambda n: main(
        "",
        f"INITIAL_STEP s0 : END_STEP TRANSITION FROM s0 TO ({chain(n, 'p@', ', ')}) := b; END_TRANSITION\n"
        + each(n, "STEP p@ : END_STEP")
        + f"TRANSITION FROM ({chain(n, 'p@', ', ')}) TO s0 := b; END_TRANSITION",
    ),
    "alternative steps": lambda n: main(
        "",
        "INITIAL_STEP s0 : END_STEP\n"
        + each(
            n,
            "TRANSITION FROM s0 TO p@ := x = @; END_TRANSITION STEP p@ : END_STEP "
            "TRANSITION FROM p@ TO s0 := b; END_TRANSITION",
        ),
    ),
    # mistakes
    "unknown names": lambda n: main("", each(n, "v@ := 1;")),
    "one unknown name": lambda n: main("", each(n, "v := 1;")),
    "unknown names near many": lambda n: main(each(n, "w@ : INT;"), each(n, "v@ := 1;")),
    "unknown types": lambda n: main(each(n, "v@ : T@;")),
    "unknown functions": lambda n: main("", each(n, "x := G@(1);")),
    "unknown components": lambda n: main("v : S;", each(n, "v.b@ := 1;"), FIRST),
    "names declared twice": lambda n: main(each(n, "v : INT;")),
    "types declared twice": lambda n: main("", "", each(n, "TYPE T : INT; END_TYPE")),
    "wrong types": lambda n: main("", each(n, "b := @ + 1000;")),
    "wrong statements": lambda n: main("", each(n, "x = ;")),
    "wrong characters": lambda n: main("", "? " * n),
    "missing ends": lambda n: main("", each(n, "IF b THEN x := 1;")),
    "missing semicolons": lambda n: main("", each(n, "x := 1")),
    "open texts": lambda n: main("", each(n, "x := 'a;")),
    "open brackets": lambda n: main("", each(n, "x := (1;")),
}
"""Texts for EPAS-4, and so for every dialect: with a number, a text that is about as long as the number."""

TODAY: Final[dict[str, Callable[[int], str]]] = {
    "conditions of the compiler": lambda n: main(
        "",
        each(
            n, "{define D@} {IF NOT defined (D@)} x := 2; {ELSIF defined (D@) OR defined (E)} x := @; {ELSE} y {END_IF}"
        ),
    ),
    "conditions in conditions of the compiler": lambda n: main(
        "", f"{each(n, '{IF NOT defined (D@)} x := @;')} {'{END_IF}' * n}"
    ),
    "assignments as conditions": lambda n: main("q : BOOL;", each(n, "IF q := x > @ THEN x := 2; END_IF;")),
    "assignments in an expression": lambda n: main("y : INT;", f"x := {chain(n, '(y := @)', ' + ')};"),
    "methods": lambda n: main(
        "f : F;", "f.m0();", f"FUNCTION_BLOCK F\n{each(n, 'METHOD m@ : INT m@ := 1; END_METHOD')}\nEND_FUNCTION_BLOCK"
    ),
    "calls of methods": lambda n: main(
        "f : F;",
        each(n, "x := f.m@();"),
        f"FUNCTION_BLOCK F\n{each(n, 'METHOD m@ : INT m@ := 1; END_METHOD')}\nEND_FUNCTION_BLOCK",
    ),
    "properties": lambda n: main(
        "f : F;",
        "x := f.p0;",
        f"FUNCTION_BLOCK F\n{each(n, 'PROPERTY p@ : INT GET p@ := 1; END_GET END_PROPERTY')}\nEND_FUNCTION_BLOCK",
    ),
    "interfaces": lambda n: main(
        "f : F;",
        "",
        each(n, "INTERFACE I@ METHOD m@ : INT END_METHOD END_INTERFACE")
        + f"\nFUNCTION_BLOCK F IMPLEMENTS {chain(n, 'I@', ', ')}\n"
        + f"{each(n, 'METHOD m@ : INT m@ := 1; END_METHOD')}\nEND_FUNCTION_BLOCK",
    ),
    "methods of an interface": lambda n: main(
        "f : F; i : I;",
        "i := f; i.m0();",
        f"INTERFACE I {each(n, 'METHOD m@ : INT END_METHOD')} END_INTERFACE\n"
        f"FUNCTION_BLOCK F IMPLEMENTS I\n{each(n, 'METHOD m@ : INT m@ := 1; END_METHOD')}\nEND_FUNCTION_BLOCK",
    ),
    "blocks behind an interface": lambda n: main(
        "f : F0; i : I;",
        "i := f; i.m();",
        "INTERFACE I METHOD m : INT END_METHOD END_INTERFACE\n"
        + block(n, "METHOD m : INT m := 1; END_METHOD", "FUNCTION_BLOCK F@ IMPLEMENTS I"),
    ),
    "blocks that extend one": lambda n: main(
        "f : E0;", "f();", FIRST_BLOCK + block(n, "VAR k@ : INT; END_VAR k@ := 1;", "FUNCTION_BLOCK E@ EXTENDS F")
    ),
    "interfaces that extend one another": lambda n: main(
        "",
        "",
        "INTERFACE I0 END_INTERFACE\n" + lines(f"INTERFACE I{k + 1} EXTENDS I{k} END_INTERFACE" for k in range(n)),
    ),
    "structures that extend one": lambda n: main(
        "v : E0;", "", FIRST + each(n, "TYPE E@ EXTENDS S : STRUCT c@ : INT; END_STRUCT; END_TYPE")
    ),
    "named lists": lambda n: main("", "x := g0;", each(n, "VAR_GLOBAL g@ : INT; END_VAR")),
    "instances that are started": lambda n: main(
        each(n, "f@ : F(@);"),
        "",
        "FUNCTION_BLOCK F METHOD FB_init : BOOL VAR_INPUT bInitRetains, bInCopyCode : BOOL; i : INT; END_VAR\n"
        "; END_METHOD END_FUNCTION_BLOCK",
    ),
    "start values that are computed": lambda n: main(
        each(n, "v@ : INT := F();"), "", "FUNCTION F : INT F := 1; END_FUNCTION"
    ),
    "references": lambda n: main(each(n, "r@ : REFERENCE TO INT;"), each(n, "r@ REF= x; r@ := 1;")),
    "static variables": lambda n: main(
        "", "", f"FUNCTION F : INT VAR_STAT {each(n, 's@ : INT;')} END_VAR F := s0; END_FUNCTION"
    ),
    "unions": lambda n: main("v : U;", "v.a0 := 1;", f"TYPE U : UNION {each(n, 'a@ : INT;')} END_UNION; END_TYPE"),
    "pieces of text": lambda n: main("s : STRING;", f"s := CONCAT({chain(n, 's', ', ')});"),
}
"""Texts for the dialect `codesys` and, where it has them, for edition 3."""

DEEP: Final[dict[str, Callable[[int], str]]] = {
    "brackets": lambda n: main("", f"x := {nested(n, '(', '1', ')')};"),
    "negations": lambda n: main("", f"b := {'NOT ' * n}b;"),
    "signs": lambda n: main("", f"x := {'- ' * n}y;"),
    "calls": lambda n: main("", f"x := {nested(n, 'ABS(', 'x', ')')};"),
    "results that are references": lambda n: main(
        "",
        f"x := {nested(n, 'R(', 'x', ')')};",
        "FUNCTION R : REFERENCE TO INT VAR_IN_OUT v : INT; END_VAR R REF= v; END_FUNCTION",
    ),
    "shifted literals": lambda n: main("d : DWORD;", f"x := {nested(n, 'BOOL_TO_INT(SHL(1, ', '1', ') = d)')};"),
    "structures in the other byte order": lambda n: main(
        "d, e : ARRAY[0..1] OF DWORD;", f"e := {nested(n, 'TO_BIG_ENDIAN(', 'd', ')')};"
    ),
    "indexes": lambda n: main("a : ARRAY[0..9] OF INT;", f"x := {nested(n, 'a[', 'x', ']')};"),
    "powers": lambda n: main("r : REAL;", f"r := {chain(n, 'r', ' ** ')};"),
    "operators to the right": lambda n: main("", f"x := {nested(n, '1 + (', '1', ')')};"),
    "IF": lambda n: main("", nested(n, "IF b THEN ", "x := 1;", " END_IF;")),
    "FOR": lambda n: main("", nested(n, "FOR x := 0 TO 1 DO ", "y := 1;", " END_FOR;")),
    "WHILE": lambda n: main("", nested(n, "WHILE b DO ", "y := 1;", " END_WHILE;")),
    "REPEAT": lambda n: main("", nested(n, "REPEAT ", "y := 1;", " UNTIL b END_REPEAT;")),
    "CASE": lambda n: main("", nested(n, "CASE x OF 1: ", "y := 1;", " END_CASE;")),
    "ELSE": lambda n: main("", nested(n, "IF b THEN x := 1; ELSE ", "x := 2;", " END_IF;")),
    "comments": lambda n: main("", nested(n, "(* ", "a", " *)") + ";"),
    "paths in a configuration": lambda n: main("v : INT;") + f"VAR_CONFIG PLC_PRG.v{'.a' * n} : INT := 1; END_VAR",
    "structures in one another": lambda n: main(
        f"v : S{n - 1};",
        "v.a := 1;",
        "TYPE S0 : STRUCT a : INT; END_STRUCT; END_TYPE\n"
        + lines(f"TYPE S{k + 1} : STRUCT a : INT; s : S{k}; END_STRUCT; END_TYPE" for k in range(n)),
    ),
    "twice in one another": lambda n: main(
        f"v : S{n - 1};",
        "v.a := 1;",
        "TYPE S0 : STRUCT a : INT; END_STRUCT; END_TYPE\n"
        + lines(f"TYPE S{k + 1} : STRUCT a : INT; s, t : S{k}; END_STRUCT; END_TYPE" for k in range(n)),
    ),
    "twice, and nothing in them": lambda n: main(
        f"v : S{n};",
        "",
        FIRST_BLOCK
        + "TYPE S0 : STRUCT END_STRUCT; END_TYPE\n"
        + lines(f"TYPE S{k + 1} : STRUCT s, t : S{k}; END_STRUCT; END_TYPE" for k in range(n)),
    ),
    "twice with start values": lambda n: main(
        f"v : S{n};",
        "v.a := 1;",
        "TYPE S0 : STRUCT a : INT := 1; END_STRUCT; END_TYPE\n"
        + lines(
            f"TYPE S{k + 1} : STRUCT a : INT; s : S{k} := (a := 2); t : S{k}; END_STRUCT; END_TYPE" for k in range(n)
        ),
    ),
    "pairs with instances": lambda n: main(
        f"v : S{n};",
        "",
        FIRST_BLOCK
        + "TYPE S0 : STRUCT f : F; END_STRUCT; END_TYPE\n"
        + lines(f"TYPE S{k + 1} : STRUCT s, t : S{k}; END_STRUCT; END_TYPE" for k in range(n)),
    ),
    "pairs that are started": lambda n: main(
        f"v : S{n};",
        "",
        "FUNCTION_BLOCK F METHOD FB_init : BOOL VAR_INPUT bInitRetains, bInCopyCode : BOOL; END_VAR\n"
        "; END_METHOD END_FUNCTION_BLOCK\nTYPE S0 : STRUCT f : F; END_STRUCT; END_TYPE\n"
        + lines(f"TYPE S{k + 1} : STRUCT s, t : S{k}; END_STRUCT; END_TYPE" for k in range(n)),
    ),
    "blocks in one another": lambda n: main(
        f"f : F{n - 1};",
        "f();",
        "FUNCTION_BLOCK F0 VAR i : INT; END_VAR i := 1; END_FUNCTION_BLOCK\n"
        + lines(f"FUNCTION_BLOCK F{k + 1} VAR f : F{k}; END_VAR f(); END_FUNCTION_BLOCK" for k in range(n)),
    ),
    "pairs of blocks": lambda n: main(
        f"f : F{n - 1};",
        "f();",
        "FUNCTION_BLOCK F0 VAR i : INT; END_VAR i := 1; END_FUNCTION_BLOCK\n"
        + lines(f"FUNCTION_BLOCK F{k + 1} VAR f, g : F{k}; END_VAR f(); g(); END_FUNCTION_BLOCK" for k in range(n)),
    ),
    "pairs of empty blocks": lambda n: main(
        f"f : F{n - 1};",
        "f();",
        "FUNCTION_BLOCK F0 ; END_FUNCTION_BLOCK\n"
        + lines(f"FUNCTION_BLOCK F{k + 1} VAR f, g : F{k}; END_VAR f(); g(); END_FUNCTION_BLOCK" for k in range(n)),
    ),
    "blocks that extend one another": lambda n: main(
        f"f : F{n - 1};",
        "f();",
        "FUNCTION_BLOCK F0 VAR i : INT; END_VAR i := 1; END_FUNCTION_BLOCK\n"
        + lines(
            f"FUNCTION_BLOCK F{k + 1} EXTENDS F{k} VAR j{k} : INT; END_VAR SUPER^(); END_FUNCTION_BLOCK"
            for k in range(n)
        ),
    ),
    "methods that are overridden": lambda n: main(
        f"f : F{n - 1};",
        "f.m();",
        "FUNCTION_BLOCK F0 METHOD m : INT m := 1; END_METHOD END_FUNCTION_BLOCK\n"
        + lines(
            f"FUNCTION_BLOCK F{k + 1} EXTENDS F{k} METHOD m : INT m := SUPER^.m(); END_METHOD END_FUNCTION_BLOCK"
            for k in range(n)
        ),
    ),
    "structures that extend one another": lambda n: main(
        f"v : S{n - 1};",
        "v.a := 1;",
        "TYPE S0 : STRUCT a : INT; END_STRUCT; END_TYPE\n"
        + lines(f"TYPE S{k + 1} EXTENDS S{k} : STRUCT b{k} : INT; END_STRUCT; END_TYPE" for k in range(n)),
    ),
    "constants by one another": lambda n: main(
        "",
        "x := c1;",
        "VAR_GLOBAL CONSTANT\n" + lines(f"c{k} : INT := c{k + 1};" for k in range(n)) + f"c{n} : INT := 1;\nEND_VAR",
    ),
    "constants by the one above": lambda n: main(
        "",
        "x := c1;",
        "VAR_GLOBAL CONSTANT\nc0 : INT := 1;" + lines(f"c{k + 1} : INT := c{k};" for k in range(n)) + "\nEND_VAR",
    ),
    "constants by two": lambda n: main(
        "",
        "x := c1;",
        "VAR_GLOBAL CONSTANT\n"
        + lines(f"c{k} : LREAL := c{k + 1} + c{k + 1};" for k in range(n))
        + f"c{n} : LREAL := 1;\nEND_VAR",
    ),
    "types by one another": lambda n: main(
        "v : T0;", "", lines(f"TYPE T{k} : T{k + 1}; END_TYPE" for k in range(n)) + f"TYPE T{n} : INT; END_TYPE"
    ),
    "arrays of arrays": lambda n: main(f"v : {'ARRAY[0..0] OF ' * n}INT;", f"v{'[0]' * n} := 1;"),
    "pointers to pointers": lambda n: main(f"v : {'POINTER TO ' * n}INT;", f"x := v{'^' * n};"),
    "structures without a name": lambda n: main(
        f"v : {nested(n, 'STRUCT s : ', 'INT', '; END_STRUCT')};", f"v{'.s' * n} := 1;"
    ),
    "start values in brackets": lambda n: main(
        f"v : S{n} := {nested(n, '(s := ', '(a := 1)', ')')};",
        "",
        "TYPE S0 : STRUCT a : INT; END_STRUCT; END_TYPE\n"
        + lines(f"TYPE S{k + 1} : STRUCT s : S{k}; END_STRUCT; END_TYPE" for k in range(n)),
    ),
    "lists in lists": lambda n: main(f"v : ARRAY[0..1] OF INT := {nested(n, '[', '1', ']')};"),
    "arguments of blocks": lambda n: main("f : F;", f"f(i := {nested(n, 'MAX(1, ', '2', ')')});", FIRST_BLOCK),
    "brackets of IL": lambda n: main("", f"LD x\n{nested(n, chr(10) + 'ADD( y', '', chr(10) + ')')}\nST x\n"),
    "macros of pointers": lambda n: main("p : POINTER TO S;", f"x := {nested(n, 'ABS(p^.a + ', '1', ')')};", POINTED),
    "selections": lambda n: main("", f"x := {nested(n, 'SEL(b, ', '1', ', 2)')};"),
    "selections twice": lambda n: main("", f"x := {nested(n, 'MAX(x, MIN(', '1', ', 2))')};"),
    "functions that call": lambda n: main(
        "",
        f"x := F{n - 1}();",
        "FUNCTION F0 : INT F0 := 1; END_FUNCTION\n"
        + lines(f"FUNCTION F{k + 1} : INT F{k + 1} := F{k}() + F{k}(); END_FUNCTION" for k in range(n)),
    ),
}
"""Constructs within themselves; most have a limit, which is a message."""
