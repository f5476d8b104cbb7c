"""Templates of exported files as JavaScript, for the page: what jinja2 parses is written as functions of a context."""

from __future__ import annotations

import json
from pathlib import Path

import jinja2
from jinja2 import nodes

TEMPLATES = Path(__file__).parents[2] / "src" / "dehyst" / "export" / "templates"
ENVIRONMENT = jinja2.Environment(trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True)
COMPARE = {"eq": "eq", "ne": "ne", "lt": "lt", "lteq": "le", "gt": "gt", "gteq": "ge"}
TOP = (nodes.Macro, nodes.Import, nodes.Assign)  # what the blocks of a template see
BINARY = {"Add": "add", "Sub": "sub", "Mul": "mul", "Div": "div", "FloorDiv": "fdiv", "Mod": "mod"}


class Writer:
    """One template; `locals` are names that are variables of JavaScript where something is written."""

    def __init__(self) -> None:
        self.locals: list[set[str]] = [set()]
        self.counter = 0

    def fresh(self) -> str:
        """A name that nothing else has."""
        self.counter += 1
        return f"$v{self.counter}"

    def template(self, name: str) -> str:
        """A call that makes the template known."""
        tree = ENVIRONMENT.parse((TEMPLATES / name).read_text(encoding="utf-8"))
        parent, blocks = "null", []
        for node in tree.find_all(nodes.Extends):
            parent = self.e(node.template)
        for node in tree.find_all(nodes.Block):
            blocks.append(
                f"{json.dumps(node.name)}: ($c, $b, $super) => {{ let $o = ''; {self.body(node.body)} return $o; }}"
            )
        macros = [n for n in tree.body if isinstance(n, nodes.Macro)]
        names = {n.name for n in macros} | {n.target for n in tree.find_all(nodes.Import)}
        self.locals.append(names)
        head = f"let {', '.join(sorted('m_' + n for n in names))};" if names else ""
        body = self.body(tree.body) if parent == "null" else self.body([n for n in tree.body if isinstance(n, TOP)])
        made = ", ".join(f"{json.dumps(n.name)}: m_{n.name}" for n in macros)
        text = f"($c, $b) => {{ let $o = ''; {head} {body} return [$o, {{{made}}}]; }}"
        # blocks see macros and imports of their template: they are written inside it
        return (
            f"template({json.dumps(name)}, {{ parent: ($c) => {parent}, make: ($c) => {{ {head} let $o = ''; "
            f"{self.body([n for n in tree.body if isinstance(n, TOP)])} "
            f"return {{ context: $c, blocks: {{ {', '.join(blocks)} }}, root: {text} }}; }} }});\n"
        )

    def body(self, body: list[nodes.Node]) -> str:
        """Statements that add to $o."""
        return " ".join(getattr(self, "s_" + type(n).__name__)(n) for n in body)

    def s_Output(self, node: nodes.Output) -> str:
        return " ".join(
            f"$o += {json.dumps(n.data)};" if isinstance(n, nodes.TemplateData) else f"$o += $.b.str({self.e(n)});"
            for n in node.nodes
        )

    def s_If(self, node: nodes.If) -> str:
        text = f"if ($.t({self.e(node.test)})) {{ {self.body(node.body)} }}"
        for each in node.elif_:
            text += f" else if ($.t({self.e(each.test)})) {{ {self.body(each.body)} }}"
        return text + (f" else {{ {self.body(node.else_)} }}" if node.else_ else "")

    def targets(self, target: nodes.Node) -> list[str]:
        return [target.name] if isinstance(target, nodes.Name) else [t.name for t in target.items]

    def s_For(self, node: nodes.For) -> str:
        names, held, all_ = self.targets(node.target), self.fresh(), self.fresh()
        bound = f"[{', '.join('m_' + n for n in names)}]" if isinstance(node.target, nodes.Tuple) else "m_" + names[0]
        source = f"[...$.it({self.e(node.iter)})]"
        self.locals.append({*names, "loop"})
        if node.test:
            source += f".filter(({bound}) => $.t({self.e(node.test)}))"
        text = (
            f"const {all_} = {source}; for (let {held} = 0; {held} < {all_}.length; {held}++) {{ const {bound} = {all_}[{held}]; "
            f"const m_loop = {{ index: {held} + 1, index0: {held}, first: {held} === 0, last: {held} === {all_}.length - 1, "
            f"length: {all_}.length }}; {self.body(node.body)} }}"
        )
        self.locals.pop()
        return text

    def s_Assign(self, node: nodes.Assign) -> str:
        value, names = self.e(node.node), self.targets(node.target)
        self.locals[-1] |= set(names)
        bound = f"[{', '.join('m_' + n for n in names)}]" if isinstance(node.target, nodes.Tuple) else "m_" + names[0]
        kept = ", ".join(f"{json.dumps(n)}: m_{n}" for n in names)
        return f"var {bound} = {value}; $c = {{ ...$c, {kept} }};"

    def s_Macro(self, node: nodes.Macro) -> str:
        names = [a.name for a in node.args]
        first = len(names) - len(node.defaults)
        listed = [
            f"m_{n}" + (f" = {self.e(node.defaults[k - first])}" if k >= first else "") for k, n in enumerate(names)
        ]
        self.locals.append({*names})
        body = self.body(node.body)
        self.locals.pop()
        told = f"{{p: {json.dumps(names)}}}"
        return f"m_{node.name} = $.def(({', '.join(listed)}) => {{ let $o = ''; {body} return $o; }}, {told});"

    def s_Import(self, node: nodes.Import) -> str:
        return f"m_{node.target} = imported({self.e(node.template)});"

    def s_Include(self, node: nodes.Include) -> str:
        seen = {n for names in self.locals for n in names}
        return f"$o += rendered({self.e(node.template)}, {{ ...$c, {', '.join(f'{json.dumps(n)}: m_{n}' for n in sorted(seen))} }});"

    def s_Extends(self, node: nodes.Extends) -> str:
        return ""

    def s_Block(self, node: nodes.Block) -> str:
        return f"$o += $b({json.dumps(node.name)}, $c);"

    def e(self, node: nodes.Node) -> str:
        """An expression."""
        kind = type(node).__name__
        if kind in BINARY:
            return f"$.{BINARY[kind]}({self.e(node.left)}, {self.e(node.right)})"
        return getattr(self, "e_" + kind)(node)

    def e_Const(self, node: nodes.Const) -> str:
        return json.dumps(node.value)

    def e_TemplateData(self, node: nodes.TemplateData) -> str:
        return json.dumps(node.data)

    def e_Name(self, node: nodes.Name) -> str:
        if any(node.name in names for names in self.locals):
            return "m_" + node.name
        return "$super" if node.name == "super" else f"look($c, {json.dumps(node.name)})"

    def e_Getattr(self, node: nodes.Getattr) -> str:
        return f"member({self.e(node.node)}, {json.dumps(node.attr)})"

    def e_Getitem(self, node: nodes.Getitem) -> str:
        if isinstance(node.arg, nodes.Slice):
            parts = [self.e(p) if p is not None else "null" for p in (node.arg.start, node.arg.stop, node.arg.step)]
            return f"$.gi({self.e(node.node)}, $.slice({', '.join(parts)}))"
        return f"member({self.e(node.node)}, {self.e(node.arg)})"

    def e_Call(self, node: nodes.Call) -> str:
        args = ", ".join(self.e(a) for a in node.args)
        named = "{" + ", ".join(f"{json.dumps(k.key)}: {self.e(k.value)}" for k in node.kwargs) + "}"
        if isinstance(node.node, nodes.Name) and node.node.name == "super":
            return "$super()"
        if isinstance(node.node, nodes.Name) and node.node.name == "range":
            return f"$.b.range({args})"
        return f"$.k({self.e(node.node)}, [{args}], {named})" if node.kwargs else f"{self.e(node.node)}({args})"

    def e_Filter(self, node: nodes.Filter) -> str:
        args = ", ".join([self.e(node.node), *(self.e(a) for a in node.args), *(self.e(k.value) for k in node.kwargs)])
        return f"filters.{node.name}({args})"

    def e_Concat(self, node: nodes.Concat) -> str:
        return "(" + " + ".join(f"$.b.str({self.e(n)})" for n in node.nodes) + ")"

    def e_CondExpr(self, node: nodes.CondExpr) -> str:
        other = self.e(node.expr2) if node.expr2 else '""'
        return f"($.t({self.e(node.test)}) ? {self.e(node.expr1)} : {other})"

    def e_Compare(self, node: nodes.Compare) -> str:
        op = node.ops[0]
        left, right = self.e(node.expr), self.e(op.expr)
        if op.op in ("in", "notin"):
            return f"{'!' if op.op == 'notin' else ''}$.in({left}, {right})"
        return f"$.{COMPARE[op.op]}({left}, {right})"

    def e_And(self, node: nodes.And) -> str:
        return f"$.and({self.e(node.left)}, () => {self.e(node.right)})"

    def e_Or(self, node: nodes.Or) -> str:
        return f"$.or({self.e(node.left)}, () => {self.e(node.right)})"

    def e_Not(self, node: nodes.Not) -> str:
        return f"!$.t({self.e(node.node)})"

    def e_Neg(self, node: nodes.Neg) -> str:
        return f"$.neg({self.e(node.node)})"

    def e_Tuple(self, node: nodes.Tuple) -> str:
        return f"$.tup({', '.join(self.e(n) for n in node.items)})"

    def e_List(self, node: nodes.List) -> str:
        return f"[{', '.join(self.e(n) for n in node.items)}]"


NEEDED = (
    "c/unit.h.j2 c/unit.c.j2 c/header.h.j2 c/main.c.j2 c/check.c.j2 c/checking.c.j2 c/judged.j2 c/expected.h.j2 "
    "c/block_tables.j2 c/tables.j2 c/Makefile.j2 c/CMakeLists.txt.j2 c/README.md.j2 extra/package.pc.j2 extra/library.json.j2 "
    "extra/pack.pdsc.j2 extra/module.yml.j2 extra/zephyr.cmake.j2 extra/Kconfig.j2 extra/requirements.md.j2 extra/misra.md.j2 "
    "extra/sbom.json.j2 extra/calibration.a2l.j2 extra/addresses.py.j2"
).split()


def script() -> str:
    """JavaScript of the templates that target c of a model of plays fills."""
    head = 'import { $ } from "../runtime/python.js";\nimport { filters, imported, look, member, rendered, template } from "../runtime/jinja.js";\n'
    return head + "".join(Writer().template(name) for name in NEEDED)
