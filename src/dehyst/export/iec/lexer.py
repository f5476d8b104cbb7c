"""Text to words: comments are skipped, letters of keywords may be of either case."""

from __future__ import annotations

import re

from dehyst.export.iec.tree import TextError, Token

LONGEST_NAME = 32  # of older tools

_WORDS = re.compile(
    r"""(?P<skip>\s+|\(\*.*?\*\))
      | (?P<real>\d+\.\d+(?:[eE][+-]?\d+)?)
      | (?P<integer>\d+(?![A-Za-z_]))
      | (?P<name>\#?[A-Za-z_][A-Za-z0-9_]*|"[A-Za-z_][A-Za-z0-9_]*")
      | (?P<pragma>\{[^{}]*\})
      | (?P<sign>:=|<=|>=|<>|\.\.|[-+*/()\[\],;:=<>.])""",
    re.VERBOSE | re.DOTALL,
)


def words(text: str) -> list[Token]:
    """Split a text into tokens and end them with one of kind ``end``.

    Examples
    --------
    >>> [token.text for token in words("z[i] := 1.5E-3; (* a comment *)")][:-1]
    ['z', '[', 'i', ']', ':=', '1.5E-3', ';']
    """
    found: list[Token] = []
    position, line = 0, 1
    while position < len(text):
        match = _WORDS.match(text, position)
        if match is None or not match.group().isascii():
            raise TextError(f"{text[position : position + 20]!r} is no word of the language", line)
        kind, word = str(match.lastgroup), match.group()
        plain = word.strip('#"') if kind == "name" else word
        if kind == "name":
            _check_name(plain, line)
        if kind in ("integer", "real") and len(word) > LONGEST_NAME:
            raise TextError(f"{word[:20]}... has {len(word)} characters", line)
        if kind != "skip":
            found.append(Token(kind, plain, line, word[0] if plain != word else ""))
        line += word.count("\n")
        position = match.end()
    return [*found, Token("end", "end of the text", line)]


def _check_name(name: str, line: int) -> None:
    """Refuse what the standard or an older tool does not take as an identifier."""
    if len(name) > LONGEST_NAME:
        raise TextError(f"{name!r} has {len(name)} characters, older tools take {LONGEST_NAME}", line)
    if "__" in name or name.startswith("_") or name.endswith("_"):
        raise TextError(f"{name!r}: underscores must stand alone between letters or digits", line)


_STANDARD = """
ABS ABSTRACT ACOS ACTION ADD AND ANY ANY_BIT ANY_DATE ANY_INT ANY_NUM ANY_REAL ARRAY ASIN AT ATAN ATAN2 BOOL BY BYTE CAL
CALC CALCN CASE CHAR CLASS CONCAT CONFIGURATION CONSTANT CONTINUE COS CTD CTU CTUD CD CU CV DATE DATE_AND_TIME DELETE
DINT DIV DO DS DT DWORD ELSE ELSIF EN END_ACTION END_CASE END_CLASS END_CONFIGURATION END_FOR END_FUNCTION
END_FUNCTION_BLOCK END_IF END_INTERFACE END_METHOD END_NAMESPACE END_PROGRAM END_REPEAT END_RESOURCE END_STEP END_STRUCT
END_TRANSITION END_TYPE END_VAR END_WHILE ENO EQ ET EXIT EXP EXPT EXTENDS F_EDGE F_TRIG FALSE FINAL FIND FOR FROM
FUNCTION FUNCTION_BLOCK GE GT IF IMPLEMENTS INITIAL_STEP INSERT INT INTERFACE INTERNAL INTERVAL JMP JMPC JMPCN LD LDATE
LDN LDT LE LEFT LEN LIMIT LINT LN LOG LREAL LT LTIME LTOD LWORD MAX METHOD MID MIN MOD MOVE MUL MUX NAMESPACE NE NEG
NON_RETAIN NOT NULL OF ON OR ORN OVERLAP OVERRIDE PRIORITY PRIVATE PROGRAM PROTECTED PT PUBLIC PV Q Q1 QD QU R R1 R_EDGE
R_TRIG READ_ONLY READ_WRITE REAL REF REF_TO REPEAT REPLACE RESOURCE RET RETAIN RETC RETCN RETURN RIGHT ROL ROR RS S S1
SEL SEMA SHL SHR SIN SINGLE SINT SQRT SR ST STEP STN STRING STRUCT SUB SUPER TAN TASK THEN THIS TIME TIME_OF_DAY TO TOD
TOF TON TP TRANSITION TRUE TRUNC TYPE UDINT UINT ULINT UNTIL USING USINT VAR VAR_ACCESS VAR_CONFIG VAR_EXTERNAL
VAR_GLOBAL VAR_IN_OUT VAR_INPUT VAR_OUTPUT VAR_TEMP WCHAR WHILE WITH WORD WSTRING XOR XORN
"""
_VENDORS = """
ADR AND_THEN ANDN BEGIN BIT BITADR BLOCK_DB BLOCK_FB BLOCK_FC BLOCK_OB BLOCK_SDB BLOCK_SFB BLOCK_SFC
COUNTER DATA_BLOCK DATABLOCK END_DATA_BLOCK END_LABEL END_ORGANIZATION_BLOCK END_PROPERTY END_REGION GET GOTO INDEXOF
INI INPUT INSTANCE LABEL LOWER_BOUND NIL OK OR_ELSE ORGANIZATION_BLOCK OUTPUT PARAMS POINTER PROPERTY PVOID REFERENCE
REGION RESET S5TIME SCL SET SIZEOF STATE TIMER TITLE UNION UPPER_BOUND UXINT VARIANT VERSION VOID XADD
XINT XSIZEOF XWORD CALL CEIL DECO ENCO FILL_BLK FLOOR FRAC GATHER NORM_X PEEK POKE READ RND ROUND RUNTIME SCALE SCALE_X
SCATTER SERIALIZE SQR SWAP UNSCALE WRITE
"""
RESERVED = frozenset((_STANDARD + _VENDORS).split())
