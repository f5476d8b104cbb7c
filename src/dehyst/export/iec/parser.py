"""Words to tree: recursive descent over declarations, statements and expressions."""

from __future__ import annotations

from dehyst.export.iec import tree
from dehyst.export.iec.lexer import RESERVED, words
from dehyst.export.iec.tree import TextError, Token, Type, Unit, Variable

_SECTIONS = ("VAR_INPUT", "VAR_OUTPUT", "VAR")
_DEEPEST = 12  # nested statements or brackets; no text of ours comes near
_LARGEST = 1_000_000  # elements of an array
_LEVELS = (("OR",), ("AND",), ("=", "<>", "<", ">", "<=", ">="), ("+", "-"), ("*", "/"))  # weakest first


def parse(text: str) -> list[Unit]:
    """Return the function blocks and programs of a text, in order.

    Raises
    ------
    TextError
        With the line, if the text is not in the subset.
    """
    parser = _Parser(words(text))
    units = []
    while parser.here().kind != "end":
        units.append(parser.unit())
    if not units:
        raise TextError("no FUNCTION_BLOCK and no PROGRAM in the text", 1)
    return units


class _Parser:
    def __init__(self, tokens: list[Token]) -> None:
        self.tokens = tokens
        self.at = 0
        self.depth = 0
        self.scl = False  # Siemens SCL

    # ---- words

    def here(self) -> Token:
        return self.tokens[self.at]

    def take(self) -> Token:
        self.at += 1
        return self.tokens[self.at - 1]

    def sees(self, *texts: str) -> bool:
        here = self.here()
        return here.kind in ("name", "sign") and not here.mark and here.text.upper() in texts

    def accept(self, text: str) -> bool:
        found = self.sees(text)
        self.at += found
        return found

    def expect(self, text: str) -> Token:
        if not self.sees(text):
            raise TextError(f"{text} expected, {self.here().text!r} found", self.here().line)
        return self.take()

    def name(self, mark: str = "") -> Token:
        """Take a name; in SCL, and only there, those of blocks and variables are marked."""
        token = self.take()
        if token.mark != (mark if self.scl else ""):
            raise TextError(f"{token.mark}{token.text}: SCL marks variables with # and blocks with quotes", token.line)
        if token.kind != "name" or token.text.upper() in RESERVED:
            raise TextError(f"{token.text!r} is not free as a name", token.line)
        return token

    def integer(self) -> int:
        sign = -1 if self.accept("-") else 1
        token = self.take()
        if token.kind != "integer":
            raise TextError(f"a whole number expected, {token.text!r} found", token.line)
        return sign * int(token.text)

    def deeper(self) -> None:
        self.depth += 1
        if self.depth > _DEEPEST:
            raise TextError(f"nested more than {_DEEPEST} deep", self.here().line)

    # ---- declarations

    def unit(self) -> Unit:
        kind = self.take()
        if kind.text.upper() not in ("FUNCTION_BLOCK", "PROGRAM"):
            raise TextError(f"FUNCTION_BLOCK or PROGRAM expected, {kind.text!r} found", kind.line)
        self.scl = self.here().mark == '"'
        name = self.name('"').text
        if self.scl:
            self.at += self.here().kind == "pragma"
            self.expect("VERSION")
            self.expect(":")
            self.take()
        variables: list[Variable] = []
        while self.sees(*_SECTIONS):
            variables += self.section()
        if self.scl:
            self.expect("BEGIN")
        end = f"END_{kind.text.upper()}"
        body = self.statements(end)
        self.expect(end)
        return Unit(kind.text.upper(), name, tuple(variables), body, kind.line)

    def section(self) -> list[Variable]:
        section = self.take().text.upper()
        if section == "VAR" and self.accept("CONSTANT"):
            section = "CONSTANT"
        found = []
        while not self.accept("END_VAR"):
            name = self.name()
            self.expect(":")
            type_ = self.type()
            initial = self.initial() if self.accept(":=") else ()
            self.expect(";")
            found.append(Variable(name.text, type_, section, initial, name.line))
        return found

    def type(self) -> Type:
        if not self.accept("ARRAY"):
            token = self.take()
            if token.text.upper() in tree.ELEMENTARY:
                return Type(token.text.upper())
            self.at -= 1
            return Type(self.name('"').text)
        self.expect("[")
        low = self.integer()
        self.expect("..")
        high = self.integer()
        self.expect("]")
        self.expect("OF")
        element = self.take()
        if element.text.upper() not in tree.ELEMENTARY or not low <= high < low + _LARGEST:
            raise TextError(f"ARRAY[{low}..{high}] OF {element.text} is not known", element.line)
        return Type(element.text.upper(), (low, high))

    def initial(self) -> tuple[tree.Literal, ...]:
        if not self.accept("["):
            return (self.literal(),)
        found = [self.literal()]
        while self.accept(","):
            found.append(self.literal())
        self.expect("]")
        return tuple(found)

    def literal(self) -> tree.Literal:
        sign = "-" if self.accept("-") else ""
        token = self.take()
        if token.kind in ("integer", "real"):
            return tree.Literal(sign + token.text, token.kind, token.line)
        if token.text.upper() in ("TRUE", "FALSE") and not sign:
            return tree.Literal(token.text.upper(), "bool", token.line)
        raise TextError(f"a constant expected, {token.text!r} found", token.line)

    # ---- statements

    def statements(self, *ends: str) -> tuple[tree.Statement, ...]:
        self.deeper()
        found: list[tree.Statement] = []
        while not self.sees(*ends):
            if self.here().kind == "end":
                raise TextError(f"{' or '.join(ends)} is missing", self.here().line)
            found.append(self.statement())
        self.depth -= 1
        return tuple(found)

    def statement(self) -> tree.Statement:
        line = self.here().line
        if self.sees("IF"):
            found: tree.Statement = self.condition()
        elif self.accept("FOR"):
            found = self.count(line)
        elif self.accept("WHILE"):
            condition = self.expression()
            self.expect("DO")
            found = tree.While(condition, self.statements("END_WHILE"), line)
            self.expect("END_WHILE")
        elif self.accept("EXIT"):
            found = tree.Exit(line)
        else:
            found = self.simple(line)
        self.expect(";")
        return found

    def condition(self) -> tree.If:
        line = self.here().line
        branches = []
        while self.accept("IF") or self.accept("ELSIF"):
            test = self.expression()
            self.expect("THEN")
            branches.append((test, self.statements("ELSIF", "ELSE", "END_IF")))
        otherwise = self.statements("END_IF") if self.accept("ELSE") else ()
        self.expect("END_IF")
        return tree.If(tuple(branches), otherwise, line)

    def count(self, line: int) -> tree.For:
        variable = tree.Name(self.name("#").text, line)
        self.expect(":=")
        first = self.expression()
        self.expect("TO")
        last = self.expression()
        step = self.integer() if self.accept("BY") else 1
        if step not in (1, -1):
            raise TextError(f"FOR in steps of {step}: only 1 and -1 are known", line)
        self.expect("DO")
        body = self.statements("END_FOR")
        self.expect("END_FOR")
        return tree.For(variable, first, last, step, body, line)

    def simple(self, line: int) -> tree.Statement:
        target = self.variable()
        if self.accept(":="):
            return tree.Assignment(target, self.expression(), line)
        self.expect("(")
        inputs: list[tuple[str, tree.Expression]] = []
        while not self.accept(")"):
            if inputs:
                self.expect(",")
            name = self.name().text
            self.expect(":=")
            inputs.append((name, self.expression()))
        return tree.Call(target, tuple(inputs), line)

    # ---- expressions

    def expression(self, level: int = 0) -> tree.Expression:
        if level == len(_LEVELS):
            return self.unary()
        left = self.expression(level + 1)
        while self.sees(*_LEVELS[level]):
            sign = self.take()
            left = tree.Binary(sign.text.upper(), left, self.expression(level + 1), sign.line)
        return left

    def unary(self) -> tree.Expression:
        line = self.here().line
        self.deeper()
        found = self.operand(line)
        self.depth -= 1
        return found

    def operand(self, line: int) -> tree.Expression:
        if self.sees("NOT", "-"):
            sign = self.take().text.upper()
            if sign == "-" and self.here().kind in ("integer", "real"):
                self.at -= 1
                return self.literal()
            return tree.Unary(sign, self.unary(), line)
        if self.accept("("):
            found = self.expression()
            self.expect(")")
            return found
        if self.here().kind in ("integer", "real") or self.sees("TRUE", "FALSE"):
            return self.literal()
        return self.variable()

    def variable(self) -> tree.Name:
        token = self.name("#")
        if self.accept("["):
            index = self.expression()
            self.expect("]")
            return tree.Name(token.text, token.line, index=index)
        member = self.name().text if self.accept(".") else None
        return tree.Name(token.text, token.line, member=member)
