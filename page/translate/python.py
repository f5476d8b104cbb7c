"""Python of the package as JavaScript, for the page: what it says is the package's own, and nothing is written twice.

Only the part of the language that the rooms below use is known, and anything else ends the build. Names keep their
names. What Python does at run time is in runtime/python.js, numpy in runtime/numpy.js.

    f(a, k=b)   $.k(f, [a], {k: b})     reordered by the names that a function carries
    a + b       $.add(a, b)             numbers at once, arrays element by element
    C(...)      C(...)                  a class is a function that makes its instance
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Callable
from pathlib import Path

SOURCE = Path(__file__).parents[2] / "src" / "dehyst"
RESERVED = set(
    "arguments await case catch const debugger default delete do enum eval export extends function implements in "
    "instanceof interface let new package private protected public static super switch this throw typeof var void "
    "null true false undefined Object Array String Number Math JSON Map Set Error Symbol".split()
)
BUILTIN_METHODS = set(
    "append extend insert pop index count sort reverse copy clear remove strip lstrip rstrip split rsplit splitlines "
    "join replace startswith endswith lower upper casefold title isdigit isalpha isalnum isspace isascii isdecimal "
    "isupper islower isprintable isidentifier find rfind rindex partition rpartition format encode decode zfill ljust "
    "rjust "
    "capitalize removeprefix removesuffix translate expandtabs get items keys values setdefault update add discard "
    "union difference intersection isdisjoint issubset issuperset hex is_integer bit_length "
    "as_integer_ratio most_common "
    "__getitem__ __len__ send close conjugate".split()
)
BINARY = {
    ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul", ast.Div: "div", ast.FloorDiv: "fdiv", ast.Mod: "mod",
    ast.Pow: "pow", ast.MatMult: "mm", ast.BitAnd: "band", ast.BitOr: "bor", ast.BitXor: "bxor", ast.LShift: "shl",
    ast.RShift: "shr",
}  # fmt: skip
COMPARE = {
    ast.Eq: "eq", ast.NotEq: "ne", ast.Lt: "lt", ast.LtE: "le", ast.Gt: "gt", ast.GtE: "ge",
}  # fmt: skip
DROPPED_DECORATORS = {"takes_recordings", "abstractmethod", "overload", "final", "runtime_checkable"}


def name_of(name: str) -> str:
    """Name as JavaScript allows it."""
    return name + "_" if name in RESERVED else name


class Scope(ast.NodeVisitor):
    """Names that a function binds."""

    def __init__(self, body: list[ast.stmt]) -> None:
        self.names: dict[str, None] = {}
        self.outer: set[str] = set()
        self.yields = False
        for statement in body:
            self.visit(statement)

    def visit_Name(self, node: ast.Name) -> None:
        if isinstance(node.ctx, (ast.Store, ast.Del)):
            self.names[node.id] = None

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        self.names[node.name] = None

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        self.names[node.name] = None

    def visit_Lambda(self, node: ast.Lambda) -> None:
        pass

    def _comprehension(self, node: ast.AST) -> None:
        for inner in ast.walk(node):
            if isinstance(inner, ast.NamedExpr):
                self.names[inner.target.id] = None

    visit_ListComp = visit_SetComp = visit_DictComp = visit_GeneratorExp = _comprehension

    def visit_Nonlocal(self, node: ast.Nonlocal) -> None:
        self.outer.update(node.names)

    visit_Global = visit_Nonlocal  # type: ignore[assignment]

    def visit_Import(self, node: ast.Import | ast.ImportFrom) -> None:
        for alias in node.names:
            self.names[(alias.asname or alias.name).split(".")[0]] = None

    visit_ImportFrom = visit_Import

    def visit_ExceptHandler(self, node: ast.ExceptHandler) -> None:
        if node.name:
            self.names[node.name] = None
        self.generic_visit(node)

    def visit_Yield(self, node: ast.AST) -> None:
        self.yields = True
        self.generic_visit(node)

    visit_YieldFrom = visit_Yield

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.generic_visit(node)


class Writer:
    """One module."""

    def __init__(self, module: str, tree: ast.Module, outside: set[str]) -> None:
        self.module, self.tree, self.outside = module, tree, outside
        self.classes: list[str] = []
        self.counter = 0
        self.bound: list[set[str]] = []  # names of the scopes around, outermost first

    def fresh(self) -> str:
        self.counter += 1
        return f"$v{self.counter}"

    # ---- module
    def write(self) -> str:
        body = [s for s in self.tree.body if not _is_typing(s)]
        scope = Scope(body)
        names = [name_of(n) for n in scope.names]
        self.bound.append(set(scope.names))
        lines = [f"let {', '.join(names)};"] if names else []
        lines += [self.statement(s) for s in body]
        shown = [f"{json.dumps(n)}: {name_of(n)}" for n in scope.names if n in self.outside]
        lines.append(f"Object.assign($m, {{{', '.join(shown)}}});")
        place = json.dumps(self.module.replace(".", "/") + ".py")
        return (
            f"$.module({json.dumps(self.module)}, ($m) => {{\nconst __file__ = {place};\n"
            + "\n".join(filter(None, lines))
            + "\n});\n"
        )

    # ---- statements
    def block(self, body: list[ast.stmt]) -> str:
        return "{" + "\n".join(filter(None, (self.statement(s) for s in body))) + "}"

    def statement(self, node: ast.stmt) -> str:
        method = getattr(self, "s_" + type(node).__name__, None)
        if method is None:
            raise SyntaxError(
                f"{self.module}:{node.lineno}: {type(node).__name__} is not known to page/translate/python.py"
            )
        return method(node)

    def s_Expr(self, node: ast.Expr) -> str:
        if isinstance(node.value, ast.Constant):
            return ""
        return self.e(node.value) + ";"

    def s_Pass(self, node: ast.Pass) -> str:
        return ""

    def s_Break(self, node: ast.Break) -> str:
        return "break;"

    def s_Continue(self, node: ast.Continue) -> str:
        return "continue;"

    def s_Global(self, node: ast.Global) -> str:
        return ""

    s_Nonlocal = s_Global  # type: ignore[assignment]

    def s_Return(self, node: ast.Return) -> str:
        return f"return {self.e(node.value)};" if node.value else "return null;"

    def s_Import(self, node: ast.Import) -> str:
        lines = []
        for alias in node.names:
            target = alias.asname or alias.name.split(".")[0]
            lines.append(f"{name_of(target)} = $.imp({json.dumps(alias.name if alias.asname else target)});")
        return "".join(lines)

    def s_ImportFrom(self, node: ast.ImportFrom) -> str:
        if node.module == "__future__":
            return ""
        lines = []
        for alias in node.names:
            module = home_of(node.module or "", alias.name)
            lines.append(
                f"{name_of(alias.asname or alias.name)} = $.from({json.dumps(module)}, {json.dumps(alias.name)});"
            )
        return "".join(lines)

    def s_If(self, node: ast.If) -> str:
        if _is_typing(node):
            return ""
        text = f"if ({self.test(node.test)}) {self.block(node.body)}"
        return text + (f" else {self.block(node.orelse)}" if node.orelse else "")

    def s_While(self, node: ast.While) -> str:
        return f"while ({self.test(node.test)}) {self.block(node.body)}"

    def s_For(self, node: ast.For) -> str:
        each = self.fresh()
        head = f"for (const {each} of $.it({self.e(node.iter)}))"
        inner = self.assign(node.target, each) + "\n" + self.block(node.body)
        if node.orelse:
            done = self.fresh()
            if not any(isinstance(n, ast.Break) for n in ast.walk(node)):
                raise SyntaxError("for-else without break")
            text = f"let {done} = true; {head} {{ {inner} }} if ({done}) {self.block(node.orelse)}"
            return "{" + text.replace("break;", f"{{ {done} = false; break; }}") + "}"
        return f"{head} {{ {inner} }}"

    def s_Assign(self, node: ast.Assign) -> str:
        value = self.e(node.value)
        if len(node.targets) == 1:
            return self.assign(node.targets[0], value)
        held = self.fresh()
        return f"{{ const {held} = {value}; " + " ".join(self.assign(t, held) for t in node.targets) + "}"

    def s_AnnAssign(self, node: ast.AnnAssign) -> str:
        return self.assign(node.target, self.e(node.value)) if node.value is not None else ""

    def s_AugAssign(self, node: ast.AugAssign) -> str:
        op, value = "i" + BINARY[type(node.op)], self.e(node.value)
        if isinstance(node.target, ast.Name):
            name = name_of(node.target.id)
            return f"{name} = $.{op}({name}, {value});"
        if isinstance(node.target, ast.Attribute):
            return f"$.ia({self.e(node.target.value)}, {json.dumps(node.target.attr)}, $.{op}, {value});"
        if isinstance(node.target, ast.Subscript):
            return f"$.isi({self.e(node.target.value)}, {self.index(node.target.slice)}, $.{op}, {value});"
        raise SyntaxError("augmented")

    def assign(self, target: ast.expr, value: str) -> str:
        if isinstance(target, ast.Name):
            return f"{name_of(target.id)} = {value};"
        if isinstance(target, ast.Attribute):
            return f"{self.e(target.value)}.{target.attr} = {value};"
        if isinstance(target, ast.Subscript):
            return f"$.si({self.e(target.value)}, {self.index(target.slice)}, {value});"
        if isinstance(target, (ast.Tuple, ast.List)):
            held = self.fresh()
            stars = [k for k, t in enumerate(target.elts) if isinstance(t, ast.Starred)]
            star = stars[0] if stars else -1
            text = f"const {held} = $.unpack({value}, {len(target.elts)}, {star});"
            for k, t in enumerate(target.elts):
                text += self.assign(t.value if isinstance(t, ast.Starred) else t, f"{held}[{k}]")
            return "{" + text + "}"
        raise SyntaxError(f"target {type(target).__name__}")

    def s_Delete(self, node: ast.Delete) -> str:
        return "".join(
            f"$.di({self.e(t.value)}, {self.index(t.slice)});" for t in node.targets if isinstance(t, ast.Subscript)
        )

    def s_Assert(self, node: ast.Assert) -> str:
        return ""

    def s_Raise(self, node: ast.Raise) -> str:
        return f"throw $.exc({self.e(node.exc)});" if node.exc else "throw $e;"

    def s_Try(self, node: ast.Try) -> str:
        text = "try " + self.block([*node.body, *node.orelse])
        if node.handlers:
            text += " catch ($e) { $e = $.caught($e); "
            for k, handler in enumerate(node.handlers):
                test = f"$.isinst($e, {self.e(handler.type)})" if handler.type else "true"
                bound = f"{name_of(handler.name)} = $e;" if handler.name else ""
                text += ("else " if k else "") + f"if ({test}) {{ {bound} {self.block(handler.body)} }} "
            text += "else throw $e; }"
        if node.finalbody:
            text += " finally " + self.block(node.finalbody)
        return text

    def s_With(self, node: ast.With) -> str:
        text = self.block(node.body)
        for item in reversed(node.items):
            held = self.fresh()
            bound = self.assign(item.optional_vars, f"$.enter({held})") if item.optional_vars else f"$.enter({held});"
            text = (
                f"{{ const {held} = {self.e(item.context_expr)}; {bound} try {text} "
                f"catch ($e) {{ if (!$.exit({held}, $.caught($e))) throw $e; }} }}"
            )
        return text

    def s_FunctionDef(self, node: ast.FunctionDef) -> str:
        if any(ast.unparse(d) == "overload" for d in node.decorator_list):
            return ""
        text = self.function(node)
        for decorator in reversed(node.decorator_list):
            said = ast.unparse(decorator)
            if said in DROPPED_DECORATORS:
                continue
            kept = said.startswith(("lru_cache", "cache"))
            text = f"{'$.memo' if kept else self.e(decorator)}({text})"
        return f"{name_of(node.name)} = {text};"

    # ---- functions
    def parameters(self, args: ast.arguments, skip: int = 0) -> tuple[str, str, str]:
        """List of parameters, first lines of the body, and what a call by name has to know."""
        positional = [*args.posonlyargs, *args.args]
        first = len(positional) - len(args.defaults)
        listed, names = [], []
        for k, arg in enumerate(positional):
            if k < skip:
                continue
            default = f" = {self.e(args.defaults[k - first])}" if k >= first else ""
            listed.append(name_of(arg.arg) + default)
            names.append(arg.arg)
        head = ""
        if args.vararg:
            listed.append(f"...{name_of(args.vararg.arg)}")
            if args.kwonlyargs or args.kwarg:
                head += f"const $kw = $.popkw({name_of(args.vararg.arg)});"
                for arg, default in zip(args.kwonlyargs, args.kw_defaults, strict=True):
                    other = self.e(default) if default is not None else "undefined"
                    head += f"let {name_of(arg.arg)} = $kw.take({json.dumps(arg.arg)}, () => {other});"
                if args.kwarg:
                    head += f"let {name_of(args.kwarg.arg)} = $kw.rest();"
            return ", ".join(listed), head, f"{{p: {json.dumps(names)}, va: true}}"
        for arg, default in zip(args.kwonlyargs, args.kw_defaults, strict=True):
            listed.append(name_of(arg.arg) + (f" = {self.e(default)}" if default is not None else ""))
            names.append(arg.arg)
        rest = ""
        if args.kwarg:
            listed.append(f"{name_of(args.kwarg.arg)} = $.dict()")
            rest = ", ks: true"
        return ", ".join(listed), head, f"{{p: {json.dumps(names)}{rest}}}"

    def function(self, node: ast.FunctionDef, method: str = "") -> str:
        """`method`: "" for a function, "self" if the first parameter is what it belongs to, "cls" for its class."""
        skip = 1 if method else 0
        listed, head, told = self.parameters(node.args, skip)
        scope = Scope(node.body)
        given = {a.arg for a in [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]}
        given |= {a.arg for a in (node.args.vararg, node.args.kwarg) if a}
        local = [name_of(n) for n in scope.names if n not in given and n not in scope.outer]
        if method:
            own = [*node.args.posonlyargs, *node.args.args][0].arg
            head = f"const {name_of(own)} = this;" + head
        if local:
            head += f"let {', '.join(local)};"
        star = "*" if scope.yields else ""
        self.bound.append(given | set(scope.names))
        body = "\n".join(filter(None, (self.statement(s) for s in node.body)))
        self.bound.pop()
        return f"$.def(function{star} ({listed}) {{ {head}\n{body} }}, {told})"

    # ---- classes
    def s_ClassDef(self, node: ast.ClassDef) -> str:
        self.classes.append(name_of(node.name))
        bases, kind = [], ""
        for base in node.bases:
            said = ast.unparse(base)
            if said.startswith(("Protocol", "Generic", "ABC", "Mapping", "Sequence")):
                continue
            if said in ("NamedTuple", "IntEnum", "Enum"):
                kind = said
            else:
                bases.append(self.e(base))
        data = next((d for d in node.decorator_list if ast.unparse(d).startswith("dataclass")), None)
        fields, members, statics = [], [], []
        for statement in node.body:
            if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name):
                static = "ClassVar" in ast.unparse(statement.annotation)
                if (data is not None or kind == "NamedTuple") and not static:
                    fields.append(self.field(statement))
                elif statement.value is not None:
                    statics.append((statement.target.id, self.e(statement.value)))
            elif isinstance(statement, ast.Assign) and isinstance(statement.targets[0], ast.Name):
                if statement.targets[0].id != "__slots__":
                    statics.append((statement.targets[0].id, self.e(statement.value)))
            elif isinstance(statement, ast.FunctionDef):
                members.append(self.member(statement))
        self.classes.pop()
        text = f"$.cls({json.dumps(node.name)}, [{', '.join(bases)}], {json.dumps(kind)}, "
        text += f"[{', '.join(fields)}], {'true' if data is not None else 'false'}, "
        text += f"{'false' if data is not None and 'eq=False' in ast.unparse(data) else 'true'}, ($c) => {{ "
        name = name_of(node.name)
        text += f"{name} = $c; " + "".join(f"$.static($c, {json.dumps(n)}, {v});" for n, v in statics)
        text += "\n".join(filter(None, members)) + "});"
        return f"{name} = {text}"

    def field(self, node: ast.AnnAssign) -> str:
        name, default = json.dumps(node.target.id), "null"  # type: ignore[union-attr]
        if isinstance(node.value, ast.Call) and ast.unparse(node.value.func) == "field":
            given = {k.arg: k.value for k in node.value.keywords}
            if "default_factory" in given:
                default = f"() => {self.e(given['default_factory'])}()"
            elif "default" in given:
                default = f"() => {self.e(given['default'])}"
        elif node.value is not None:
            default = f"() => {self.e(node.value)}"
        return f"[{name}, {default}]"

    def member(self, node: ast.FunctionDef) -> str:
        said = [ast.unparse(d) for d in node.decorator_list]
        if "overload" in said:
            return ""
        name = json.dumps(node.name)
        if "property" in said:
            return f"$.prop($c, {name}, {self.function(node, 'self')});"
        if "cached_property" in said or "functools.cached_property" in said:
            return f"$.cached($c, {name}, {self.function(node, 'self')});"
        if "staticmethod" in said:
            return f"$.smeth($c, {name}, {self.function(node)});"
        if "classmethod" in said:
            return f"$.cmeth($c, {name}, {self.function(node, 'cls')});"
        return f"$.meth($c, {name}, {self.function(node, 'self')});"

    # ---- expressions
    def e(self, node: ast.expr) -> str:
        method = getattr(self, "e_" + type(node).__name__, None)
        if method is None:
            raise SyntaxError(
                f"{self.module}:{node.lineno}: {type(node).__name__} is not known to page/translate/python.py"
            )
        return method(node)

    def test(self, node: ast.expr) -> str:
        if isinstance(node, ast.BoolOp):
            sign = " && " if isinstance(node.op, ast.And) else " || "
            return "(" + sign.join(self.test(v) for v in node.values) + ")"
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return f"!{self.test(node.operand)}"
        return f"$.t({self.e(node)})"

    def e_Constant(self, node: ast.Constant) -> str:
        value = node.value
        if value is None:
            return "null"
        if value is True or value is False:
            return str(value).lower()
        if value is Ellipsis:
            return "$.ellipsis"
        if isinstance(value, bytes):
            return f"$.bytes({json.dumps(list(value))})"
        if isinstance(value, float):
            return "Infinity" if value == float("inf") else repr(value)
        return json.dumps(value)

    def e_Name(self, node: ast.Name) -> str:
        return name_of(node.id) if node.id not in BUILTINS or self.shadowed(node.id) else f"$.b.{node.id}"

    def shadowed(self, name: str) -> bool:
        return any(name in bound for bound in self.bound)

    def e_Attribute(self, node: ast.Attribute) -> str:
        return f"$.ga({self.e(node.value)}, {json.dumps(node.attr)})"

    def e_Subscript(self, node: ast.Subscript) -> str:
        return f"$.gi({self.e(node.value)}, {self.index(node.slice)})"

    def index(self, node: ast.expr) -> str:
        if isinstance(node, ast.Slice):
            parts = [self.e(p) if p is not None else "null" for p in (node.lower, node.upper, node.step)]
            return f"$.slice({', '.join(parts)})"
        if isinstance(node, ast.Tuple):
            return "$.tup(" + ", ".join(self.index(p) for p in node.elts) + ")"
        return self.e(node)

    def e_Slice(self, node: ast.Slice) -> str:
        return self.index(node)

    def e_BinOp(self, node: ast.BinOp) -> str:
        return f"$.{BINARY[type(node.op)]}({self.e(node.left)}, {self.e(node.right)})"

    def e_UnaryOp(self, node: ast.UnaryOp) -> str:
        if isinstance(node.op, ast.Not):
            return f"!{self.test(node.operand)}"
        name = {ast.USub: "neg", ast.UAdd: "pos", ast.Invert: "inv"}[type(node.op)]
        if name == "neg" and isinstance(node.operand, ast.Constant) and isinstance(node.operand.value, (int, float)):
            return f"(-{self.e(node.operand)})"
        return f"$.{name}({self.e(node.operand)})"

    def e_BoolOp(self, node: ast.BoolOp) -> str:
        name = "and" if isinstance(node.op, ast.And) else "or"
        text = self.e(node.values[-1])
        for value in reversed(node.values[:-1]):
            text = f"$.{name}({self.e(value)}, () => {text})"
        return text

    def e_Compare(self, node: ast.Compare) -> str:
        parts, left = [], node.left
        if len(node.ops) == 1:
            return self.compare(node.ops[0], self.e(left), self.e(node.comparators[0]), node.comparators[0])
        said = self.e(left)
        for k, (op, right) in enumerate(zip(node.ops, node.comparators, strict=True)):
            last = k == len(node.ops) - 1
            held = self.e(right)
            if not last and not isinstance(right, (ast.Name, ast.Constant)):
                held = f"($t{k} = {held})"
                parts.append(self.compare(op, said, held, right))
                said = f"$t{k}"
            else:
                parts.append(self.compare(op, said, held, right))
                said = held
        temps = [f"$t{k}" for k in range(len(node.ops))]
        return f"(({', '.join(temps)}) => {' && '.join(f'$.t({p})' for p in parts)})()"

    def compare(self, op: ast.cmpop, left: str, right: str, node: ast.expr) -> str:
        if isinstance(op, (ast.Is, ast.IsNot)):
            none = isinstance(node, ast.Constant) and node.value is None
            sign = ("==" if none else "===") if isinstance(op, ast.Is) else ("!=" if none else "!==")
            return f"({left} {sign} {right})"
        if isinstance(op, ast.In):
            return f"$.in({left}, {right})"
        if isinstance(op, ast.NotIn):
            return f"!$.in({left}, {right})"
        return f"$.{COMPARE[type(op)]}({left}, {right})"

    def e_IfExp(self, node: ast.IfExp) -> str:
        return f"({self.test(node.test)} ? {self.e(node.body)} : {self.e(node.orelse)})"

    def e_Tuple(self, node: ast.Tuple) -> str:
        if any(isinstance(n, ast.Starred) for n in node.elts):
            return f"$.tuple([{self.elements(node.elts)}])"  # maybe as long as a log: no arguments of a call
        return f"$.tup({self.elements(node.elts)})"

    def e_List(self, node: ast.List) -> str:
        return f"[{self.elements(node.elts)}]"

    def e_Set(self, node: ast.Set) -> str:
        return f"$.b.set([{self.elements(node.elts)}])"

    def elements(self, nodes: list[ast.expr]) -> str:
        return ", ".join(f"...$.it({self.e(n.value)})" if isinstance(n, ast.Starred) else self.e(n) for n in nodes)

    def e_Dict(self, node: ast.Dict) -> str:
        parts = [
            f"[{self.e(k)}, {self.e(v)}]" if k is not None else f"...$.pairs({self.e(v)})"
            for k, v in zip(node.keys, node.values, strict=True)
        ]
        return f"$.dict([{', '.join(parts)}])"

    def e_Lambda(self, node: ast.Lambda) -> str:
        listed, head, told = self.parameters(node.args)
        self.bound.append({a.arg for a in node.args.args})
        body = self.e(node.body)
        self.bound.pop()
        return f"$.def(({listed}) => {{ {head} return {body}; }}, {told})"

    def e_NamedExpr(self, node: ast.NamedExpr) -> str:
        return f"({name_of(node.target.id)} = {self.e(node.value)})"

    def e_Starred(self, node: ast.Starred) -> str:
        return f"...$.it({self.e(node.value)})"

    def e_Yield(self, node: ast.Yield) -> str:
        return f"(yield {self.e(node.value) if node.value else 'null'})"

    def e_YieldFrom(self, node: ast.YieldFrom) -> str:
        return f"(yield* $.it({self.e(node.value)}))"

    def loops(self, generators: list[ast.comprehension], inner: str) -> str:
        text = inner
        for each in reversed(generators):
            for condition in reversed(each.ifs):
                text = f"if ({self.test(condition)}) {{ {text} }}"
            held = self.fresh()
            names = Scope([ast.Assign(targets=[each.target], value=ast.Constant(0))]).names
            bound = f"let {', '.join(map(name_of, names))};" if names else ""
            inner = f"{bound} {self.assign(each.target, held)} {text}"
            text = f"for (const {held} of $.it({self.e(each.iter)})) {{ {inner} }}"
        return text

    def inside(self, generators: list[ast.comprehension], write: Callable[[], str]) -> str:
        """Text written where the targets of a comprehension are bound."""
        self.bound.append({n for each in generators for n in Scope([ast.Assign([each.target], ast.Constant(0))]).names})
        text = write()
        self.bound.pop()
        return text

    def e_ListComp(self, node: ast.ListComp) -> str:
        return self.inside(node.generators, lambda: self._list(node))

    def _list(self, node: ast.ListComp) -> str:
        inner = self.loops(node.generators, f"$r.push({self.e(node.elt)});")
        return f"(() => {{ const $r = []; {inner} return $r; }})()"

    def e_SetComp(self, node: ast.SetComp) -> str:
        return f"$.b.set({self.e_ListComp(node)})"  # type: ignore[arg-type]

    def e_DictComp(self, node: ast.DictComp) -> str:
        return self.inside(node.generators, lambda: self._dict(node))

    def _dict(self, node: ast.DictComp) -> str:
        inner = f"$r.push([{self.e(node.key)}, {self.e(node.value)}]);"
        return f"$.dict((() => {{ const $r = []; {self.loops(node.generators, inner)} return $r; }})())"

    def e_GeneratorExp(self, node: ast.GeneratorExp) -> str:
        return self.inside(node.generators, lambda: self._generator(node))

    def _generator(self, node: ast.GeneratorExp) -> str:
        return f"(function* () {{ {self.loops(node.generators, f'yield {self.e(node.elt)};')} }})()"

    def e_JoinedStr(self, node: ast.JoinedStr) -> str:
        parts = []
        for value in node.values:
            if isinstance(value, ast.Constant):
                parts.append(json.dumps(value.value))
            else:
                spec = self.e(value.format_spec) if value.format_spec else '""'
                parts.append(f"$.f({self.e(value.value)}, {spec}, {value.conversion})")
        return "(" + " + ".join(['""', *parts]) + ")"

    def e_FormattedValue(self, node: ast.FormattedValue) -> str:
        return self.e_JoinedStr(ast.JoinedStr(values=[node]))

    def e_Call(self, node: ast.Call) -> str:
        said = node.func.id if isinstance(node.func, ast.Name) else ""
        if said == "cast":
            return self.e(node.args[1])
        if said == "super":
            return f"$.sup({self.classes[-1]}, this)"
        arguments = self.elements(node.args)
        named = ""
        if node.keywords:
            parts = [
                f"...$.obj({self.e(k.value)})" if k.arg is None else f"{json.dumps(k.arg)}: {self.e(k.value)}"
                for k in node.keywords
            ]
            named = "{" + ", ".join(parts) + "}"
        if isinstance(node.func, ast.Attribute):
            holder, attribute = node.func.value, node.func.attr
            if ast.unparse(holder) == "object" and attribute == "__setattr__":
                return f"$.seta({arguments})"
            if isinstance(holder, ast.Call) and isinstance(holder.func, ast.Name) and holder.func.id == "super":
                # the instance of the method around it, also inside a function of its own
                call = f"[{arguments}]" + (f", {named}" if named else "")
                return f"$.supcall({self.classes[-1]}, {self.own()}, {json.dumps(attribute)}, {call})"
            target = self.e(holder)
            if attribute in BUILTIN_METHODS:
                return f"$.cm({target}, {json.dumps(attribute)}, [{arguments}]{', ' + named if named else ''})"
            if named:
                return f"$.km({target}, {json.dumps(attribute)}, [{arguments}], {named})"
            return f"{target}.{attribute}({arguments})"
        function = self.e(node.func)
        if named:
            return f"$.k({function}, [{arguments}], {named})"
        starred = any(isinstance(n, ast.Starred) for n in node.args)
        return f"$.star({function}, [{arguments}])" if starred else f"{function}({arguments})"

    def own(self) -> str:
        return "this"


BUILTINS = set(
    "abs all any bool bytes bytearray callable chr dict divmod enumerate filter float frozenset getattr "
    "hasattr hash id "
    "int isinstance issubclass iter len list map max min next object open ord pow print range repr reversed round set "
    "setattr slice sorted str sum tuple type vars zip Exception BaseException ValueError TypeError KeyError IndexError "
    "RuntimeError OSError AttributeError AssertionError NotImplementedError OverflowError "
    "ZeroDivisionError StopIteration "
    "UnicodeDecodeError UnicodeError ArithmeticError LookupError MemoryError FileNotFoundError UserWarning Warning "
    "ImportError ModuleNotFoundError PermissionError IsADirectoryError NotImplemented complex property "
    "DeprecationWarning".split()
)


def _is_typing(node: ast.stmt) -> bool:
    return isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"


def home_of(module: str, name: str) -> str:
    """Module in which a name of a package is defined: packages themselves are not carried over."""
    if not module.startswith("dehyst"):
        return module
    folder = SOURCE.parent / module.replace(".", "/")
    if not (folder / "__init__.py").is_file() or (folder / f"{name}.py").is_file():
        return module
    for node in ast.parse((folder / "__init__.py").read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ImportFrom) and any((a.asname or a.name) == name for a in node.names):
            return home_of(node.module or "", name)
    return module


WORD = re.compile(r"[A-Za-z_]\w*")


def _words(*pieces: ast.AST) -> set[str]:
    """Names that code mentions, in text too: some are asked for by getattr. Imports, types and docstrings use nothing."""
    words: set[str] = set()
    open_ = list(pieces)
    while open_:
        node = open_.pop()
        if isinstance(node, ast.Name):
            words.add(node.id)
        elif isinstance(node, ast.Attribute):
            words.add(node.attr)
        elif isinstance(node, ast.keyword) and node.arg:
            words.add(node.arg)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and len(node.value) < 40:
            words.update(WORD.findall(node.value))
        elif isinstance(node, ast.alias) and node.asname:
            words.add(node.name)
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            continue
        for field, value in ast.iter_fields(node):
            if field not in ("annotation", "returns"):
                open_ += [part for part in (value if isinstance(value, list) else [value]) if isinstance(part, ast.AST)]
    return words


def _defined(node: ast.stmt) -> str:
    """Name of a function, a class or a constant; "" for a statement that is carried as it is."""
    if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
        return node.name
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    return targets[0].id if len(targets) == 1 and isinstance(targets[0], ast.Name) else ""


def _class_words(node: ast.ClassDef) -> set[str]:
    """Names that a class mentions outside its methods."""
    fields = [statement for statement in node.body if not isinstance(statement, ast.FunctionDef)]
    return _words(*node.bases, *node.decorator_list, *fields)


def pruned(trees: dict[str, ast.Module], asked: str) -> None:
    """Take away what is mentioned nowhere that is reached from `asked`: functions, methods, classes, constants, imports."""
    mentioned: dict[str, list[set[str]]] = {}
    open_ = set(WORD.findall(asked))
    for tree in trees.values():
        for node in tree.body:
            if isinstance(node, ast.ClassDef):
                mentioned.setdefault(node.name, []).append(_class_words(node))
                for method in node.body:
                    if isinstance(method, ast.FunctionDef):
                        mentioned.setdefault(method.name, []).append(_words(method))
            elif name := _defined(node):
                mentioned.setdefault(name, []).append(_words(node))
            elif not _is_typing(node):
                open_ |= _words(node)
    open_ |= {name for name in mentioned if name.startswith("__")}
    reached: set[str] = set()
    while open_:
        name = open_.pop()
        reached.add(name)
        for words in mentioned.get(name, ()):
            open_ |= words - reached
    for tree in trees.values():
        tree.body = [n for n in tree.body if not _defined(n) or _defined(n) in reached]
        for node in tree.body:
            if isinstance(node, ast.ClassDef):
                node.body = [n for n in node.body if not isinstance(n, ast.FunctionDef) or n.name in reached]
    outside = _asked_of_modules(trees) | set(WORD.findall(asked))
    for tree in trees.values():
        inside = _words(*tree.body)
        for node in tree.body:
            if isinstance(node, (ast.Import, ast.ImportFrom)):
                names = {a: (a.asname or a.name).split(".")[0] for a in node.names}
                node.names = [a for a in node.names if names[a] in inside | outside]
        tree.body = [n for n in tree.body if not isinstance(n, (ast.Import, ast.ImportFrom)) or n.names]


def _asked_of_modules(trees: dict[str, ast.Module]) -> set[str]:
    """Names that a module may be asked for by another: imported from it, or members of something."""
    names: set[str] = set()
    for tree in trees.values():
        for node in ast.walk(tree):
            if isinstance(node, ast.Attribute):
                names.add(node.attr)
            elif isinstance(node, ast.Constant) and isinstance(node.value, str) and len(node.value) < 40:
                names.update(WORD.findall(node.value))
            elif isinstance(node, ast.ImportFrom):
                names.update(alias.name for alias in node.names)
    return names


def script(modules: list[str], asked: str) -> str:
    """JavaScript of modules such as "data/loops"; `asked` mentions what the page calls."""
    trees = {name: ast.parse((SOURCE / f"{name}.py").read_text(encoding="utf-8")) for name in modules}
    pruned(trees, asked)
    outside = _asked_of_modules(trees) | set(WORD.findall(asked))
    written = [Writer("dehyst." + name.replace("/", "."), tree, outside).write() for name, tree in trees.items()]
    return "".join(['import { $ } from "../runtime/python.js";\n', *written])


# What `dehyst identify LOG --family pi` and `dehyst inspect LOG` run through.
MODULES = (
    "arrays findings errors shell units data/clipping data/loops data/outliers data/ranges data/recording data/speeds identification/cautions "
    "identification/certify identification/data identification/evidence identification/facts identification/families "
    "identification/fit identification/least_squares identification/memory identification/mending "
    "identification/plays identification/procedure identification/refine identification/regressors "
    "identification/conditions identification/residual identification/scores identification/selection identification/settings identification/shear "
    "identification/short_signal identification/split identification/static_curve identification/tracking io/cells "
    "io/checks io/clean io/clocks io/columns io/dates io/delimited io/heading io/layout io/lines io/logs io/no_table io/order "
    "io/pairs io/plain io/rewrite io/select io/table io/time_units io/text "
    "io/inspect models/arrays models/base models/card models/model models/monotone models/prandtl_ishlinskii "
    "models/machine models/unknown models/offset models/parameters models/storage files version "
    "models/block export/controller export/names export/precision export/numbers export/units export/signal export/subject "
    "export/rendering export/core_files export/budget export/requirements export/calibration export/extra export/targets "
    "export/c export/folder"
).split()
