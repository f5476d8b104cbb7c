"""A second way to run Structured Text: parsed by the grammar of others (tree-sitter), written as C, compiled.

It shares nothing with the own checker: neither the parser nor the arithmetic, which is that of the processor. It knows
one function block without instances in it, which is what is exported.
"""

import ctypes
import subprocess

TYPES = {
    "LREAL": "double",
    "REAL": "float",
    "DINT": "int32_t",
    "UDINT": "uint32_t",
    "BOOL": "unsigned char",
}
CTYPES = {
    "LREAL": ctypes.c_double,
    "REAL": ctypes.c_float,
    "DINT": ctypes.c_int32,
    "UDINT": ctypes.c_uint32,
    "BOOL": ctypes.c_ubyte,
}
SIGNS = {"=": "==", "<>": "!=", "AND": "&", "OR": "|", "NOT": "!"}


def fields(node, name):
    return [
        child
        for child in node.children_by_field_name(name)
        if child.is_named and child.type != "comment"
    ]


def field(node, name):
    (found,) = fields(node, name)
    return found


class Writer:
    """Writes a tree as C and refuses every kind of node that it does not know."""

    def __init__(self):
        self.variables = {}  # name -> type

    def program(self, block):
        sections = [child for child in block.children if child.type.startswith("var_")]
        declared = "\n".join(
            self.declaration(child)
            for s in sections
            for child in s.children
            if child.type == "variable_declaration"
        )
        body = self.statements(fields(block, "body"))
        return f"#include <stdint.h>\n{declared}\nvoid run(void)\n{{\n{body}\n}}\n"

    def declaration(self, node):
        name, type_ = field(node, "names").text.decode(), field(node, "type")
        values = [value.text.decode() for value in fields(node, "initial_value")]
        size = ""
        if type_.type == "array_type":
            bounds = field(type_, "range")
            assert field(bounds, "lower").text == b"0"
            size = f"[{int(field(bounds, 'upper').text) + 1}]"
            type_ = field(type_, "element_type")
        kind = type_.text.decode()
        assert name.lower() not in {known.lower() for known in self.variables}
        self.variables[name] = kind
        words = [
            {"TRUE": "1", "FALSE": "0"}.get(v, v + ("f" if kind == "REAL" else "")) for v in values
        ]
        initial = (f" = {{{', '.join(words)}}}" if size else f" = {words[0]}") if words else ""
        return f"{TYPES[kind]} v_{name}{size}{initial};"

    def statements(self, nodes):
        return "\n".join(
            self.statement(node)
            for node in nodes
            if node.type not in ("empty_statement", "comment")
        )

    def statement(self, node):
        return getattr(self, node.type)(node)

    def assignment_statement(self, node):
        return f"{self.of(field(node, 'left'))} = {self.of(field(node, 'right'))};"

    def exit_statement(self, node):
        return "break;"

    def if_statement(self, node):
        text = f"if ({self.of(field(node, 'condition'))}) {{ {self.statements(fields(node, 'consequence'))} }}"
        for child in node.children:
            if child.type == "elsif_clause":
                condition = self.of(field(child, "condition"))
                text += f" else if ({condition}) {{ {self.statements(fields(child, 'body'))} }}"
            elif child.type == "else_clause":
                text += f" else {{ {self.statements(fields(child, 'body'))} }}"
        return text

    def while_statement(self, node):
        return f"while ({self.of(field(node, 'condition'))}) {{ {self.statements(fields(node, 'body'))} }}"

    def of(self, node):
        text = node.text.decode()
        if node.type == "identifier":
            assert text in self.variables, text
            return f"v_{text}"
        if node.type == "integer_literal":
            return text
        if node.type == "boolean_literal":
            return {"TRUE": "1", "FALSE": "0"}[text]
        if node.type == "parenthesized_expression":
            (inside,) = [child for child in node.children if child.is_named]
            return f"({self.of(inside)})"
        if node.type == "index_expression":
            return f"{self.of(field(node, 'object'))}[{self.of(field(node, 'index'))}]"
        if node.type == "unary_expression":
            sign = node.child_by_field_name("operator").text.decode()
            return f"({SIGNS.get(sign, sign)}{self.of(field(node, 'operand'))})"
        assert node.type == "binary_expression", node.type
        sign = node.child_by_field_name("operator").text.decode()
        return f"({self.of(field(node, 'left'))} {SIGNS.get(sign, sign)} {self.of(field(node, 'right'))})"


class Compiled:
    """A function block as a shared library."""

    def __init__(self, text, folder):
        import tree_sitter
        import tree_sitter_iec61131_3_st

        parser = tree_sitter.Parser(tree_sitter.Language(tree_sitter_iec61131_3_st.language()))
        root = parser.parse(text.encode()).root_node
        assert not root.has_error
        (block,) = [child for child in root.children if child.type == "function_block_declaration"]
        writer = Writer()
        source = folder / "unit.c"
        source.write_text(writer.program(block))
        command = [
            "gcc",
            "-O1",
            "-w",
            "-ffp-contract=off",
            "-shared",
            "-fPIC",
            "-o",
            str(folder / "unit.so"),
            str(source),
        ]
        subprocess.run(command, check=True)
        self.library = ctypes.CDLL(str(folder / "unit.so"))
        self.variables = writer.variables

    def variable(self, name):
        return CTYPES[self.variables[name]].in_dll(self.library, f"v_{name}")

    def call(self, outputs, **inputs):
        for name, value in inputs.items():
            self.variable(name).value = value
        self.library.run()
        return {name: self.variable(name).value for name in outputs}
