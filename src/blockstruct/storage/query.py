"""Expressions that select rows of a table: parsed, never evaluated.

The text may come from anywhere. It is read as a tree of Python expressions, of which comparisons of columns with
literals, ``and``, ``or``, ``not`` and ``in`` are understood; each becomes a mask of the rows, and whatever else is
refused. A dotted name, or a text where a column is due, is looked up among the parameters of studies, and nowhere else.
"""

import ast
import operator
import reprlib
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from blockstruct.errors import StorageError

Mask = NDArray[np.bool_]

#: How the columns of parameters begin.
_PARAMETER = "parameter_"

#: Length of an expression and depth of its tree, beyond which nobody wrote it by hand.
MOST_CHARACTERS, MOST_LEVELS = 10_000, 50
_COMPARISONS: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
#: What stands for a column, quoted names apart, and what a column can be in.
_NAMES, _LISTS = (ast.Name, ast.Attribute), (ast.List, ast.Tuple, ast.Set)
#: The comparison that says the same with its sides exchanged.
_MIRRORED: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Eq: ast.Eq,
    ast.NotEq: ast.NotEq,
    ast.Lt: ast.Gt,
    ast.LtE: ast.GtE,
    ast.Gt: ast.Lt,
    ast.GtE: ast.LtE,
}
_ALLOWED = (
    "write comparisons of columns with numbers or texts, joined by and, or, not, as in "
    "\"status == 'converged' and load_factor < 0.3\", \"case in ['push +x', 'push -x']\" or \"'north' in tags\"; "
    "parameters go by their names or the ends of them, quoted where they have spaces or begin with a number"
)


def selected(table: pd.DataFrame, expression: str) -> pd.DataFrame:
    """Rows of a table that an expression selects.

    Parameters
    ----------
    table
        Its columns are the names that the expression may use; of a parameter, its own name or an end of it that no
        other one has, too: ``friction_coefficient`` for ``parameter_joint_materials.lime.friction_coefficient``.
    expression
        Comparisons (``==``, ``!=``, ``<``, ``<=``, ``>``, ``>=``, ``in``, ``not in``) of a column with a literal: a
        number, a text, True or False, or for ``in`` a list of them; joined by ``and``, ``or`` and ``not``. A literal
        is ``in`` a column where the text, or the tags, of the row contain it. Names of parameters may be quoted.

    Raises
    ------
    StorageError
        If the expression is any other, names a column that the table does not have, or compares one with a literal of
        another kind.
    """
    try:
        if not isinstance(expression, str) or len(expression) > MOST_CHARACTERS:
            msg = f"no text of at most {MOST_CHARACTERS} characters"
            raise _RefusedError(msg)
        return table[_mask(_tree(expression), table, 0)]
    except _RefusedError as error:
        known = ", ".join(c for c in table.columns if not c.startswith("settings_"))
        shown = repr(expression) if len(str(expression)) <= 200 else reprlib.repr(expression)
        msg = f"query {shown}: {error}; {_ALLOWED}; columns are {known} and settings_…"
        raise StorageError(msg) from error


class _RefusedError(Exception):
    """What is wrong with an expression."""


def _tree(expression: str) -> ast.expr:
    try:
        with warnings.catch_warnings():
            # Of a backslash that escapes nothing, for instance: it would not mean what it says.
            warnings.simplefilter("error")
            return ast.parse(expression.strip(), mode="eval").body
    except SyntaxError as error:
        msg = f"no expression ({error.msg})"
        raise _RefusedError(msg) from error
    except (ValueError, RecursionError, MemoryError, Warning) as error:
        msg = f"no expression ({error or type(error).__name__})"
        raise _RefusedError(msg) from error


def _mask(node: ast.expr, table: pd.DataFrame, level: int) -> Mask:
    """Which rows a part of the expression selects."""
    if level > MOST_LEVELS:
        msg = f"nested more than {MOST_LEVELS} deep"
        raise _RefusedError(msg)
    match node:
        case ast.BoolOp(op=op, values=values):
            join = np.logical_and if isinstance(op, ast.And) else np.logical_or
            joined: Mask = join.reduce([_mask(value, table, level + 1) for value in values])
            return joined
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            return ~_mask(operand, table, level + 1)
        case ast.Compare(left=left, ops=ops, comparators=comparators):
            # a < b < c compares b twice.
            sides = [left, *comparators]
            masks = [_compared(a, op, b, table) for a, op, b in zip(sides, ops, sides[1:], strict=False)]
            every: Mask = np.logical_and.reduce(masks)
            return every
        case ast.Name(id=name) if name in table:
            msg = f"column {name!r} is compared with nothing"
            raise _RefusedError(msg)
        case _:
            raise _RefusedError(_not_understood(node))


def _compared(left: ast.expr, op: ast.cmpop, right: ast.expr, table: pd.DataFrame) -> Mask:
    """Rows in which a comparison of a column with a literal, on either side, holds."""
    if isinstance(op, ast.Is | ast.IsNot):
        msg = "'is' is not a comparison of values, write == or !="
        raise _RefusedError(msg)
    if isinstance(op, ast.In | ast.NotIn):
        found = _contained(left, right, table)
        return found if isinstance(op, ast.In) else ~found
    kind = type(op)
    if not isinstance(left, _NAMES) and isinstance(right, _NAMES):
        left, right, kind = right, left, _MIRRORED[kind]
    column = _column(left, table)
    value = _fitting(_literal(right), column)
    # A value that is missing differs from every other, and is neither below nor above it.
    present = column.notna().to_numpy()
    values = column[present]
    mask = np.full(len(column), kind is ast.NotEq)
    if not values.empty:
        # A column without values has no kind that a literal could fail to be of, and yet a type that may refuse it.
        held = values if isinstance(value, str | pd.Timestamp) else values.astype(float)
        mask[present] = _COMPARISONS[kind](held, value)
    return mask


def _contained(left: ast.expr, right: ast.expr, table: pd.DataFrame) -> Mask:
    """Rows in which a column is one of several literals, or contains a literal."""
    if isinstance(left, _NAMES) or isinstance(right, _LISTS):
        column = _column(left, table)
        if not isinstance(right, _LISTS):
            msg = f"column {column.name!r} can only be in a list"
            raise _RefusedError(msg)
        values = [_fitting(_literal(element), column) for element in right.elts]
        return np.asarray(column.isin(values), dtype=bool)
    text, column = _literal(left), _column(right, table)
    kinds = _kinds(column)
    if not isinstance(text, str) or not kinds <= {str, tuple}:
        msg = f"only a text can be in a column, and only in one of texts or tags, not in {column.name!r}"
        raise _RefusedError(msg)
    return np.array([isinstance(cell, str | tuple) and text in cell for cell in column], dtype=bool)


def _column(node: ast.expr, table: pd.DataFrame) -> "pd.Series[Any]":
    match node:
        case ast.Name(id=name) if name in table:
            return table[name]
        case ast.Name(id=name) | ast.Constant(value=str() as name):
            return table[_parameter(name, table)]
        case ast.Attribute() if dotted := _dotted(node):
            return table[_parameter(dotted, table)]
        case ast.Constant():
            msg = f"{reprlib.repr(node.value)} stands where a column is needed"
        case _:
            msg = _not_understood(node)
    raise _RefusedError(msg)


def _dotted(node: ast.expr) -> str:
    """Names with dots between them; empty if anything else is among them."""
    parts = []
    while isinstance(node, ast.Attribute):
        parts.append(node.attr)
        node = node.value
    return ".".join([node.id, *reversed(parts)]) if isinstance(node, ast.Name) else ""


def _parameter(name: str, table: pd.DataFrame) -> str:
    """Column of a parameter by its name, or by an end of it that is that of no other one."""
    known = [c.removeprefix(_PARAMETER) for c in table.columns if c.startswith(_PARAMETER)]
    plain = name.removeprefix(_PARAMETER)
    found = [plain] if plain in known else [one for one in known if one.endswith(f".{plain}")]
    if len(found) == 1:
        return f"{_PARAMETER}{found[0]}"
    said = reprlib.repr(name)
    several = f"{said} is the end of several parameters: {', '.join(found)}"
    raise _RefusedError(several if found else f"no column {said}")


def _literal(node: ast.expr) -> bool | float | str:
    """Number, text, True or False; numbers as floats, which no size of theirs can overwhelm."""
    match node:
        case ast.UnaryOp(op=ast.USub() | ast.UAdd() as sign, operand=ast.Constant(value=int() | float() as number)) if (
            not isinstance(number, bool)
        ):
            return _float(number) if isinstance(sign, ast.UAdd) else -_float(number)
        case ast.Constant(value=bool() | str() as value):
            return value
        case ast.Constant(value=int() | float() as number):
            return _float(number)
        case ast.Name(id=name):
            msg = f"{name!r} stands where a number or a text is needed (texts are quoted)"
        case _:
            msg = _not_understood(node)
    raise _RefusedError(msg)


def _float(number: float) -> float:
    try:
        return float(number)
    except OverflowError:
        msg = f"{reprlib.repr(number)} is too large a number"
        raise _RefusedError(msg) from None


def _fitting(value: bool | float | str, column: "pd.Series[Any]") -> Any:
    """The literal as the column is compared with it, if it is of its kind: else no row would ever be found."""
    if isinstance(column.dtype, pd.DatetimeTZDtype):
        try:
            return pd.to_datetime(str(value), utc=True, format="ISO8601")
        except (ValueError, OverflowError):
            msg = f"{reprlib.repr(value)} is not a date, write '2026-01-31' or '2026-01-31T12:00'"
            raise _RefusedError(msg) from None
    kinds = _kinds(column)
    if kinds - {str if isinstance(value, str) else float}:
        holds = {str: "texts", float: "numbers", tuple: "tags, which a text can be in"}
        held = " and ".join(sorted(holds.get(kind, kind.__name__) for kind in kinds))
        msg = f"{reprlib.repr(value)} cannot be compared with column {column.name!r}, which holds {held}"
        raise _RefusedError(msg)
    return value


def _kinds(column: "pd.Series[Any]") -> set[type]:
    """Kinds of the values that a column holds, all numbers being one; none of a column without values."""
    return {float if isinstance(v, float | int | np.number | np.bool_) else type(v) for v in column.dropna()}


def _not_understood(node: ast.expr) -> str:
    text = reprlib.repr(ast.unparse(node)) if isinstance(node, ast.Name | ast.Constant) else type(node).__name__
    return f"{text} is not understood"
