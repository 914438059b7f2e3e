"""Tests of programs in a source file: USES, RIG, SETUP, TEARDOWN and TEST.

Their words are keywords only where no declaration can begin otherwise, and only with a text or a section behind them.
So a program may use all of them as names.
"""

from typing import Final

from fieldrig_devices.iec import tokens as token
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.parser.cursor import TEXTS, UnexpectedError
from fieldrig_devices.iec.parser.declarations import SECTIONS
from fieldrig_devices.iec.parser.methods import Methods

_WORDS: Final = {word.value: word for word in tree.TestWord}
_NAMED: Final = frozenset({"TEST", "RIG", "USES"})
_OF_TRUST: Final = frozenset({"TEST_PROGRAM", "TEST_FUNCTION_BLOCK"})
"""Words of truST, with the name of the test behind them."""


class Tests(Methods):
    """Reads the parts of a test file."""

    def __init__(self, tokens: token.Tokens, file: str, dialect: Dialect) -> None:
        super().__init__(tokens, file, dialect)
        self.tests: list[tree.Test] = []
        self.uses: list[tree.Use] = []
        self.rig: tree.RigUse | None = None

    def is_part_of_tests(self) -> bool:
        """True if a part of a test file begins here."""
        word = self.texts[self.i].upper()
        if word in _OF_TRUST:
            return self.kinds[self.i + 1] == token.NAME and self._end_of_block(word) is not None
        if self.kinds[self.i] != token.NAME or word not in _NAMED | _WORDS.keys():
            return False
        following = self.kinds[self.i + 1]
        if word in _NAMED:
            return following in TEXTS
        return following in SECTIONS or self._end_of_block(word) is not None

    def part_of_tests(self) -> None:
        word, front = self.texts[self.i].upper(), self.taken()
        self.is_test = True
        try:
            if word == "USES":
                self.uses.append(self._use_of_tests(front))
            elif word == "RIG":
                self.rig = self._rig_of_tests(front)
            elif word in _OF_TRUST:
                self._block_of_tests(tree.TestWord.TEST, front, word)
            else:
                self._block_of_tests(_WORDS[word], front)
        finally:
            self.is_test = False

    def _end_of_block(self, word: str) -> int | None:
        """Return the token that ends a block, in front of the next one; None without one."""
        for at in range(self.i + 1, len(self.kinds)):
            text = self.texts[at].upper()
            if text == f"END_{word}":
                return at
            if self.kinds[at] == token.NAME and text == "TEST" and self.kinds[at + 1] in TEXTS:
                return None
        return None

    def _use_of_tests(self, front: tuple[str, ...]) -> tree.Use:
        """Read USES 'pid.st'."""
        at = self.i
        self.i += 1
        use = tree.Use(self.quoted("a file"), position=self.positions[at])
        self.accept(";")
        self._decorate_part(use, front, at)
        return use

    def _rig_of_tests(self, front: tuple[str, ...] = ()) -> tree.RigUse:
        """Read RIG 'feeder.yaml' AFTER T#10s."""
        at = self.i
        self.i += 1
        use = tree.RigUse(self.quoted("a rig file"), position=self.positions[at])
        if self.accept_word("AFTER"):
            use.delay = self.expression()
        self.accept(";")
        self._decorate_part(use, front, at)
        return use

    def _decorate_part(self, part: tree.Statement, front: tuple[str, ...], at: int) -> None:
        """Give a part its comments: those in front, those inside, and one behind."""
        self.gather_from(at + 1)
        part.comments, part.remark = front + self.taken(), self.remark()

    def _block_of_tests(self, word: tree.TestWord, front: tuple[str, ...], spelled: str = "") -> None:
        opening = self.i
        end = self._end_of_block(spelled or word.value)
        if end is not None:
            self.kinds[end] = f"END_{word.value}"
        self.i += 1
        test = tree.Test(word, "", (), tree.StBody(()), position=self.positions[opening], comments=front)
        test.spelled = spelled
        self.tests.append(test)
        if spelled:
            test.name = self.texts[self.i]
            self.i += 1
            self.accept(";")
        elif word is tree.TestWord.TEST:
            test.name = self.quoted("the name of the test")
            self.accept(";")
            self._options_of_test(test)
            if end is not None and self._has_inner_block(end):
                self.i = end + 1
                self.accept(";")
                return
        test.blocks = self.blocks()
        if word is tree.TestWord.TEST:
            self._options_of_test(test)
            test.blocks += self.blocks()
        body = self.body("ST")
        test.body = body
        self.gather()
        test.after = self.taken()
        if end is None or self.kinds[self.i] != f"END_{word.value}":
            line = self.positions[opening].line
            opened = spelled or word.value
            self.say(self.i, f"got {self.shown(self.i)}", f"END_{opened} for the {opened} in line {line}")
            raise UnexpectedError
        self.i += 1
        self.accept(";")
        test.remark = self.remark()

    def _has_inner_block(self, end: int) -> bool:
        """True, with a message, for a TEST with SETUP or TEARDOWN within it, where other tools may have them."""
        words = [text.upper() for text in self.texts[self.i : end]]
        for word in ("SETUP", "TEARDOWN"):
            if word in words and f"END_{word}" in words:
                where = f"{word} beside the TEST blocks of the file; it runs for each of them"
                self.say(self.i + words.index(word), f"{word} within a TEST", where)
                return True
        return False

    def _options_of_test(self, test: tree.Test) -> None:
        """Read RIG and SKIP behind the name of a test, in any order."""
        while self.kinds[self.i] == token.NAME and self.kinds[self.i + 1] in TEXTS:
            self.gather()
            if self.is_word("RIG"):
                test.rig = self._rig_of_tests(self.taken())
            elif self.accept_word("SKIP"):
                test.skip = self.quoted("the reason")
                self.accept(";")
            else:
                return
