"""Select rows of a table by a condition, which is parsed and never run as code."""

import ast
import operator
import re
import warnings
from collections.abc import Callable
from functools import reduce
from typing import Any

import pandas as pd

from blockstruct.errors import StorageError, shown

#: Characters of a condition, at most: longer texts can exhaust the stack of Python's parser.
_LONGEST = 10_000
_COMPARISONS: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}


def rows_where(table: pd.DataFrame, where: str) -> pd.DataFrame:
    """Return the rows of a table for which a condition holds.

    Parameters
    ----------
    table
        The table.
    where
        Comparisons of a column with numbers or texts, joined by ``and``, ``or`` and ``not``. A column may be ``in`` a
        list, and a text ``in`` a column of texts or tags. Other characters of a name than letters and digits are
        written as ``_``. A missing value differs from every other, and is neither less nor greater.

    Raises
    ------
    StorageError
        If the condition is anything else, names no column, or compares one with a value of another kind.
    """
    try:
        if not isinstance(where, str) or len(where) > _LONGEST:
            msg = f"it is not a text of at most {_LONGEST} characters"
            raise TypeError(msg)
        with warnings.catch_warnings(action="error"):
            return table[_mask(ast.parse(where.strip(), mode="eval").body, table)]
    except (ArithmeticError, MemoryError, RecursionError, SyntaxError, TypeError, ValueError, Warning) as error:
        example = "\"status == 'converged' and load_factor < 0.3\", \"case in ['push +x']\" or \"'north' in tags\""
        msg = f"where {shown(where)}: {error}; compare columns with numbers or texts, as in {example}"
        raise StorageError(msg) from error


def _mask(node: ast.expr, table: pd.DataFrame) -> "pd.Series[bool]":
    match node:
        case ast.BoolOp(op=op, values=values):
            join = operator.and_ if isinstance(op, ast.And) else operator.or_
            return reduce(join, [_mask(value, table) for value in values])
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            return ~_mask(operand, table)
        case ast.Compare(left=left, ops=ops, comparators=comparators):
            sides = [_side(side, table) for side in (left, *comparators)]
            return reduce(operator.and_, map(_compared, sides, ops, sides[1:]))
    msg = f"{type(node).__name__} is no comparison"
    raise ValueError(msg)


def _side(node: ast.expr, table: pd.DataFrame) -> Any:
    """Return the column, number, text or list that a side of a comparison stands for."""
    if isinstance(node, ast.Name):
        columns = [name for name in table.columns if re.sub(r"\W", "_", name) == node.id]
        if len(columns) == 1:
            return table[columns[0]]
        msg = f"{len(columns)} columns are named {node.id!r}, those of the table are {', '.join(table.columns)}"
        raise ValueError(msg)
    value = ast.literal_eval(node)
    return [_plain(each) for each in value] if isinstance(value, list | tuple | set) else _plain(value)


def _plain(value: Any) -> str | float:
    if isinstance(value, str):
        return value
    if isinstance(value, int | float):
        return float(value)
    msg = f"{shown(value)} is neither a number nor a text"
    raise TypeError(msg)


def _compared(one: Any, op: ast.cmpop, other: Any) -> "pd.Series[bool]":
    if isinstance(op, ast.NotIn):
        return ~_compared(one, ast.In(), other)
    compare = _COMPARISONS.get(type(op))
    match one, other:
        case pd.Series(), list() if isinstance(op, ast.In):
            nowhere = pd.Series(False, index=one.index)
            return reduce(operator.or_, [_compared(one, ast.Eq(), value) for value in other], nowhere)
        case str(), pd.Series() if isinstance(op, ast.In):
            return other.map(lambda cell: isinstance(cell, str | tuple) and one in cell).astype(bool)
        case (pd.Series() as column, str() | float() as value) | (str() | float() as value, pd.Series() as column) if (
            compare
        ):
            present = column.dropna()
            mask = pd.Series(isinstance(op, ast.NotEq), index=column.index)
            if not present.empty:
                _check_kind(present, value)
                mask[present.index] = compare(present, value) if column is one else compare(value, present)
            return mask
    msg = "a comparison needs a column on one side, and a number, a text or for 'in' a list on the other"
    raise TypeError(msg)


def _check_kind(column: "pd.Series[Any]", value: str | float) -> None:
    """Refuse a value of another kind: pandas finds it equal to nothing, in silence."""
    try:
        operator.lt(column, value)
    except TypeError as error:
        msg = f"column {column.name!r} holds no values that could be compared with {shown(value)}"
        raise TypeError(msg) from error
