"""Rewrite the branches and loops of ordinary functions, so that running a function once emits all of its code (see `ir`).

An `if` becomes `for taken in branch(test)`, a `while` becomes `for one in loop()`, a `for` runs over `iterate`, `and`, `or`
and `not` become calls. Variables that branches or loops assign become attributes of a frame. All else runs as it is
written, so that the tracebacks of errors show the lines of the source.
"""

import ast
import inspect
import linecache
import textwrap
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from types import CodeType
from typing import Any

from gnomon.harness.kernels.ir import Subset

HELPERS, FRAME, RESULT, EXIT = "_ir", "_v", "_result", "_exit"
Path = tuple[tuple[int, int], ...]
"""The branches and loops around a statement, from the outermost: each by its identity and the number of the suite."""


@cache
def source_of(function: Callable[..., Any]) -> str:
    """The source of a function, faster than by inspect.getsource, which tokenizes the file and searches all modules.

    It is read once, so that the key of kept code names the text that was compiled, also if the file is edited meanwhile.
    """
    code = function.__code__
    linecache.checkcache(code.co_filename)  # the module may have been edited and loaded again
    lines = linecache.getlines(code.co_filename, function.__globals__)
    if not lines:
        return inspect.getsource(function)
    first, last = code.co_firstlineno - 1, max(line for _, _, line in code.co_lines() if line)
    margin = lines[first][: -len(lines[first].lstrip())]
    while last < len(lines) and lines[last].startswith((f"{margin} ", f"{margin})")):
        last += 1
    return "".join(lines[first:last])


@cache
def rewritten(function: Callable[..., Any]) -> CodeType:
    """The code of a module that defines the rewritten function. Raises Subset for code that cannot be emitted."""
    if function.__name__ == "<lambda>":
        raise Subset(f"{function.__qualname__} is a lambda; write it as a function")
    file, above = function.__code__.co_filename, function.__code__.co_firstlineno - 1
    (definition,) = ast.parse("\n" * above + textwrap.dedent(source_of(function))).body
    if not isinstance(definition, ast.FunctionDef):
        raise Subset(f"{function.__qualname__} is no plain function")
    try:
        new = _rewritten(definition)
    except Refusal as refusal:
        error = Subset(f"{file}, line {refusal.line}: {refusal}")
        error.placed = True
        raise error from None
    return compile(ast.fix_missing_locations(ast.Module([new], [])), file, "exec")


class Refusal(Exception):  # noqa: N818 - `Subset` is the error
    """Code outside the subset, at a line."""

    def __init__(self, node: ast.AST, why: str) -> None:
        super().__init__(why)
        self.line = getattr(node, "lineno", 0)


REFUSED = {
    ast.Try: "try", ast.With: "with", ast.Raise: "raise; let the function give nan instead", ast.Lambda: "a lambda",
    ast.Yield: "yield", ast.Global: "global", ast.Nonlocal: "nonlocal", ast.Delete: "del", ast.Await: "await",
    ast.ClassDef: "a class", ast.NamedExpr: ":=", ast.Match: "match", ast.Import: "import", ast.ImportFrom: "import",
}  # fmt: skip


def _rewritten(definition: ast.FunctionDef) -> ast.FunctionDef:
    for node in ast.walk(definition):
        if type(node) in REFUSED:
            raise Refusal(node, f"compiled code cannot have {REFUSED[type(node)]}")
        if isinstance(node, ast.FunctionDef) and node is not definition:
            raise Refusal(node, "compiled code cannot have a function inside a function")
    body = [x for x in definition.body if not (isinstance(x, ast.Expr) and isinstance(x.value, ast.Constant))]
    loops = [x for x in _statements(body) if isinstance(x, ast.For | ast.While)]
    jumps = any(_has_return(x.body) for x in loops)
    if not jumps and _has_return(body[:-1] if body and isinstance(body[-1], ast.Return) else body):
        body = [*_fold_returns(body), ast.Return(ast.Name(RESULT, ast.Load()))]
    arguments = [argument.arg for argument in definition.args.args]
    slots = _in_slots(body, arguments)
    rewrite = Rewrite(slots, jumps)
    new = rewrite.suite(body)
    if jumps:
        around = ast.For(ast.Name(EXIT, ast.Store()), rewrite.helper("leaving"), new, [])
        values = any(isinstance(x, ast.Return) and x.value is not None for x in _statements(body))
        new = [around, *([ast.Return(_frame(RESULT, ast.Load()))] if values else [])]
    start: list[ast.stmt] = []
    if slots or jumps:
        start = ast.parse(f"{FRAME} = {HELPERS}.Frame()\n").body
        start += [
            ast.Assign([_frame(name, ast.Store())], ast.Name(name, ast.Load())) for name in arguments if name in slots
        ]
    plain = ast.arguments(
        [],
        [ast.arg(x.arg) for x in definition.args.args],
        None,
        [],
        [],
        None,
        [ast.Constant(None) for _ in definition.args.defaults],
    )
    rewritten = ast.FunctionDef(definition.name, plain, [*start, *new] or [ast.Pass()], [], None, None)
    rewritten.type_params = []  # type: ignore[attr-defined]  # which Python 3.12 requires
    return ast.copy_location(rewritten, definition)


def _frame(name: str, context: ast.expr_context) -> ast.Attribute:
    return ast.Attribute(ast.Name(FRAME, ast.Load()), name, context)


def _fold_returns(statements: Sequence[ast.stmt]) -> list[ast.stmt]:
    """Replace each `return` by an assignment to the result, and move the statements after a branch that returns into `else`."""
    for n, statement in enumerate(statements):
        if isinstance(statement, ast.Return):
            value = statement.value or ast.Constant(None)
            return [*statements[:n], ast.copy_location(ast.Assign([ast.Name(RESULT, ast.Store())], value), statement)]
        if isinstance(statement, ast.If) and _has_return([statement]):
            rest = list(statements[n + 1 :])
            if not _returns(statement.body) and not _returns(statement.orelse) and rest:
                raise Refusal(statement, "a branch that returns in some cases only; let each branch return or none")
            then = _fold_returns([*statement.body, *([] if _returns(statement.body) else rest)])
            other = _fold_returns([*statement.orelse, *([] if _returns(statement.orelse) else rest)])
            return [*statements[:n], ast.copy_location(ast.If(statement.test, then, other), statement)]
    return [*statements, ast.Assign([ast.Name(RESULT, ast.Store())], ast.Constant(None))]


def _returns(statements: Sequence[ast.stmt]) -> bool:
    """Whether the statements return in all cases."""
    if not statements:
        return False
    last = statements[-1]
    return isinstance(last, ast.Return) or (isinstance(last, ast.If) and _returns(last.body) and _returns(last.orelse))


def _in_slots(body: Sequence[ast.stmt], arguments: Sequence[str]) -> set[str]:
    """The variables that need a slot: they are assigned in a branch or loop, and read outside it or in its next turn."""
    stores: dict[str, list[tuple[Path, int]]] = {name: [((), 0)] for name in arguments}
    loads: dict[str, list[tuple[Path, int]]] = {}
    targets: dict[str, list[Path]] = {}
    clock = 0

    def note(accesses: dict[str, list[tuple[Path, int]]], name: str, path: Path) -> None:
        nonlocal clock
        clock += 1
        accesses.setdefault(name, []).append((path, clock))

    def expression(node: ast.AST, path: Path, hidden: frozenset[str] = frozenset()) -> None:
        if isinstance(node, ast.GeneratorExp | ast.ListComp):
            hidden |= {x.id for loop in node.generators for x in ast.walk(loop.target) if isinstance(x, ast.Name)}
        if isinstance(node, ast.Name) and node.id not in hidden:
            note(stores if isinstance(node.ctx, ast.Store) else loads, node.id, path)
        for child in ast.iter_child_nodes(node):
            expression(child, path, hidden)

    def suite(statements: Sequence[ast.stmt], path: Path) -> None:
        for statement in statements:
            inner, other = (*path, (id(statement), 0)), (*path, (id(statement), 1))
            if isinstance(statement, ast.For):
                expression(statement.iter, path)
                for name in (x.id for x in ast.walk(statement.target) if isinstance(x, ast.Name)):
                    targets.setdefault(name, []).append(inner)
            elif isinstance(statement, ast.If | ast.While):
                expression(statement.test, inner if isinstance(statement, ast.While) else path)
            if isinstance(statement, ast.For | ast.While | ast.If):
                suite(statement.body, inner)
                suite(statement.orelse, other)
            elif isinstance(statement, ast.Assign | ast.AnnAssign | ast.AugAssign):
                if statement.value is not None:
                    expression(statement.value, path)
                for target in statement.targets if isinstance(statement, ast.Assign) else [statement.target]:
                    if isinstance(statement, ast.AugAssign) and isinstance(target, ast.Name):
                        note(loads, target.id, path)
                    expression(target, path)
            else:
                expression(statement, path)

    suite(body, ())
    for name, loops in targets.items():
        for path, _ in (*stores.get(name, []), *loads.get(name, [])):
            if not any(path[: len(inner)] == inner for inner in loops):
                raise Refusal(body[0], f"{name} is the variable of a loop and is used outside it")
        if any(path for path, _ in stores.get(name, [])):
            raise Refusal(body[0], f"{name} is the variable of a loop and is assigned in it")
    slots = set()
    for name, places in stores.items():
        first, at = places[0]
        read = loads.get(name, [])
        straight = all(path == () for path, _ in places)
        once = len(places) == 1 and all(path[: len(first)] == first and when > at for path, when in read)
        if not (straight or once or name in targets):
            slots.add(name)
    return slots


class Rewrite(ast.NodeTransformer):
    def __init__(self, slots: set[str], jumps: bool) -> None:
        self.slots, self.jumps, self.count = slots, jumps, 0
        self.loops: list[str | None] = []
        self.depth = 0
        """The depth of the nested `for` loops that were visited in the present loop."""

    def helper(self, name: str, *arguments: ast.expr) -> ast.Call:
        return ast.Call(ast.Attribute(ast.Name(HELPERS, ast.Load()), name, ast.Load()), list(arguments), [])

    def suite(self, statements: Sequence[ast.stmt]) -> list[ast.stmt]:
        rewritten: list[ast.stmt] = []
        for statement in statements:
            new = self.visit(statement)
            for x in new if isinstance(new, list) else [new]:
                rewritten.append(ast.copy_location(x, statement))
        return rewritten or [ast.Pass()]

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return ast.copy_location(_frame(node.id, node.ctx), node) if node.id in self.slots else node

    def visit_BoolOp(self, node: ast.BoolOp) -> ast.expr:
        combined: ast.expr
        combined, *rest = [self.visit(value) for value in node.values]
        for value, original in zip(rest, node.values[1:], strict=True):
            both = ast.Constant(isinstance(node.op, ast.And))
            combined = self.helper("either", combined, _later(value), both, ast.Constant(_is_guarded(original)))
        return ast.copy_location(combined, node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.expr:
        self.generic_visit(node)
        return self.helper("negate", node.operand) if isinstance(node.op, ast.Not) else node

    def visit_Compare(self, node: ast.Compare) -> ast.expr:
        if len(node.ops) > 1:
            sides = [node.left, *node.comparators]
            each = [ast.Compare(a, [op], [b]) for a, op, b in zip(sides, node.ops, sides[1:], strict=False)]
            return ast.copy_location(self.visit_BoolOp(ast.BoolOp(ast.And(), list(each))), node)
        self.generic_visit(node)
        return node

    def visit_IfExp(self, node: ast.IfExp) -> ast.expr:
        guarded = ast.Constant(_is_guarded(node.body) or _is_guarded(node.orelse))
        self.generic_visit(node)
        return self.helper("choose", node.test, _later(node.body), _later(node.orelse), guarded)

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.stmt:
        if isinstance(node.target, ast.Name):
            load = ast.Name(node.target.id, ast.Load())
            new = ast.Assign([node.target], ast.BinOp(load, node.op, node.value))
            return ast.copy_location(self.visit_Assign(new), node)
        self.generic_visit(node)
        return node

    def visit_Assign(self, node: ast.Assign) -> ast.Assign:
        self.generic_visit(node)
        return node

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.stmt:
        if node.value is None:
            return ast.Pass()
        return self.visit_Assign(ast.Assign([node.target], node.value))

    def visit_If(self, node: ast.If) -> ast.stmt:
        self.count += 1
        name = f"_taken{self.count}"
        test = self.visit(node.test)
        inner = ast.If(ast.Name(name, ast.Load()), self.suite(node.body), self.suite(node.orelse))
        return ast.For(ast.Name(name, ast.Store()), self.helper("branch", test), [ast.copy_location(inner, node)], [])

    def visit_While(self, node: ast.While) -> ast.stmt:
        if node.orelse:
            raise Refusal(node, "compiled code cannot have `else` at a loop")
        name = self._loop()
        check = ast.Expr(_method(name, "check", self.visit(node.test)))
        body = [ast.copy_location(check, node), *self.suite(node.body)]
        self.loops.pop()
        return ast.For(ast.Name(name, ast.Store()), self.helper("loop"), body, [])

    def visit_For(self, node: ast.For) -> ast.stmt:
        if node.orelse:
            raise Refusal(node, "compiled code cannot have `else` at a loop")
        values = self.visit(node.iter)
        beside, self.depth = self.depth, 0
        if not any(isinstance(x, ast.Break | ast.Continue) for x in _statements(node.body, loops=False)):
            self.loops.append(None)
            body = self.suite(node.body)
            new = ast.For(node.target, self.helper("iterate", values, ast.Constant(self.depth + 1)), body, [])
        else:
            target = ast.Tuple([ast.Name(self._loop(), ast.Store()), node.target], ast.Store())
            new = ast.For(target, self.helper("count_loop", values), self.suite(node.body), [])
        self.depth = max(beside, self.depth + 1)
        self.loops.pop()
        return new

    def _loop(self) -> str:
        self.count += 1
        name = f"_loop{self.count}"
        self.loops.append(name)
        return name

    def visit_Return(self, node: ast.Return) -> Any:
        self.generic_visit(node)
        if not self.jumps:
            return node
        leave = ast.Expr(_method(EXIT, "leave"))
        assignments = [ast.Assign([_frame(RESULT, ast.Store())], node.value)] if node.value is not None else []
        return [*assignments, leave]

    def visit_Break(self, node: ast.Break) -> ast.stmt:
        return ast.Expr(_method(self.loops[-1] or "", "leave"))

    def visit_Continue(self, node: ast.Continue) -> ast.stmt:
        return ast.Expr(_method(self.loops[-1] or "", "repeat"))


def _method(name: str, method: str, *arguments: ast.expr) -> ast.Call:
    return ast.Call(ast.Attribute(ast.Name(name, ast.Load()), method, ast.Load()), list(arguments), [])


def _later(node: ast.expr) -> ast.Lambda:
    return ast.Lambda(ast.arguments([], [], None, [], [], None, []), node)


def _is_guarded(node: ast.expr) -> bool:
    """Whether an expression may be costly or invalid where its value does not count."""
    return any(isinstance(x, ast.Subscript | ast.Call) for x in ast.walk(node))


def _statements(suite: Sequence[ast.stmt], loops: bool = True) -> Iterator[ast.stmt]:
    """The statements of a suite and all nested statements; without `loops` not the statements inside loops."""
    for statement in suite:
        yield statement
        if isinstance(statement, ast.If) or (loops and isinstance(statement, ast.For | ast.While)):
            yield from _statements([*statement.body, *statement.orelse], loops)


def _has_return(suite: Sequence[ast.stmt]) -> bool:
    return any(isinstance(x, ast.Return) for x in _statements(suite))
