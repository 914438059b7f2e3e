// The expression under the cursor, and the names that the debugger may have for it.
"use strict";

const WORDS = {
  st: /[A-Za-z_]\w*(?:\^|\[[^\][]*\]|\.\w+)*/g,
  pam: /[A-Za-z_]\w*/g,
  arp: /[@#]?[A-Za-z]\w*/g,
};
const NO_CODE = {
  st: /'(?:[^'$]|\$.)*'|"(?:[^"$]|\$.)*"|\/\/.*$|\(\*.*?(?:\*\)|$)/g,
  pam: /"[^"]*"|\/\/.*$|\/\*.*?(?:\*\/|$)/g,
  arp: /"[^"]*"|;.*$/g,
};
const SCOPE = /^[ \t]*(PROGRAM|FUNCTION_BLOCK|FUNCTION|CLASS)[ \t]+(?:(?:ABSTRACT|FINAL|PUBLIC|INTERNAL)[ \t]+)*([A-Za-z_]\w*)/gim;

// Return { text, start, end } of the expression at a column, up to the part under it; nothing in a comment or a text.
exports.expressionAt = (language, line, column) => {
  const code = line.replace(NO_CODE[language], (hidden) => " ".repeat(hidden.length));
  for (const found of code.matchAll(WORDS[language])) {
    const end = found.index + found[0].length;
    if (column < found.index || column > end) continue;
    const rest = found[0].slice(column - found.index);
    const cut = language === "st" ? rest.search(/[.^[]/) : -1;
    const text = cut < 0 ? found[0] : found[0].slice(0, column - found.index + cut);
    const isWhole = (text.match(/\[/g) ?? []).length === (text.match(/\]/g) ?? []).length;
    return isWhole ? { text, start: found.index, end: found.index + text.length } : undefined;
  }
  return undefined;
};

// Return { kind, name } of the program, block or function that a place in a text of ST is in.
exports.scopeAt = (textBefore) => {
  const found = [...textBefore.matchAll(SCOPE)].pop();
  return found ? { kind: found[1].toUpperCase(), name: found[2] } : undefined;
};
