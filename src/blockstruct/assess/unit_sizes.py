"""How far an answer depends on the size of the units."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from blockstruct.analysis import run
from blockstruct.errors import ModelError
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.model import LimitCase, Model
from blockstruct.results.case_result import CaseResult
from blockstruct.text import assessment
from blockstruct.text.note import Note
from blockstruct.text.numbers import LOAD_FACTOR
from blockstruct.units import QuantityLike, si


@dataclass(frozen=True, slots=True, eq=False)
class UnitSizes:
    """Answers of one structure with units of several sizes: :func:`unit_sizes`.

    Attributes
    ----------
    what : str
        Name of the answer: ``"load factor"`` or ``"capacity / demand"``.
    table : pandas.DataFrame
        A row a size, the largest first: size, blocks, answer, answer relative to the first, and whether it settled.
    fine : float
        Answer of a fine bond: the straight line through the settled answers, at size zero.
    scatter : float
        Root mean square of their distance from the line, with n − 2 degrees of freedom; NaN for two sizes.
    """

    what: str
    table: pd.DataFrame = field(repr=False)
    fine: float
    scatter: float

    @property
    def notes(self) -> tuple[Note, ...]:
        """Warning on the size with the lowest ratio, if that is below one; a load factor has none."""
        answers = zip(*(self.table[name].tolist() for name in (self.what, "size [meter]", "settled")), strict=True)
        ratio, size = min((value, size) for value, size, settled in answers if settled)
        if self.what == LOAD_FACTOR.name or ratio >= 1:
            return ()
        return (assessment.unit_size(size, ratio),)

    def __str__(self) -> str:
        sizes, values = (self.table[name].tolist() for name in ("size [meter]", self.what))
        return assessment.unit_sizes(self.what, sizes, values, self.fine, self.scatter)


def unit_sizes(
    build: Callable[[Any], tuple[Model, LimitCase]],
    sizes: Sequence[QuantityLike],
    *,
    check: Callable[[CaseResult], Any] | None = None,
    settings: ProcedureSettings | None = None,
) -> UnitSizes:
    """Run a structure with units of several sizes.

    Each crack follows the joints, so larger units leave fewer ways to crack. The answer falls with the size, nearly in
    proportion, and the line through the answers estimates the answer of a fine bond. Units far smaller than those of
    the wall do not make the model better: a bond that is known should be drawn as it is.

    Parameters
    ----------
    build : callable
        Returns model and case for a size. Keep the ratio of overlap to height of a course.
    sizes : sequence of quantities, length
        Two at least; three or more show the scatter.
    check : callable
        Returns a check of the result, whose ratio is the answer. By default the load factor is.
    settings
        Settings of the procedure.

    Raises
    ------
    ModelError
        If sizes repeat, or fewer than two answers have settled.

    Examples
    --------
    >>> import blockstruct as bs
    >>> stone, dry = bs.Material("stone", "18 kN/m^3"), bs.JointMaterial("dry", 0.6)
    >>> push = bs.LoadPattern("push", [bs.BodyForce("+x")])
    >>> case = bs.LimitCase("in plane", bs.LoadPattern("dead", [bs.SelfWeight()]), push)
    >>> def build(size):
    ...     blocks = bs.wall(
    ...         length="2.4 m", height="2.4 m", thickness="0.3 m", unit_length=size, unit_height=size / 2,
    ...         material=stone,
    ...     )
    ...     return bs.Model("wall", blocks, bs.detect_interfaces(blocks, joint_material=dry)), case
    >>> found = bs.assess.unit_sizes(build, [bs.Q_(1.2, "m"), bs.Q_(0.8, "m"), bs.Q_(0.6, "m")])
    >>> found.table["blocks"].tolist()
    [11, 22, 37]
    >>> bool(found.fine < found.table["load factor"].min())
    True
    """
    who = "unit_sizes"
    lengths = [si(size, "length", f"{who}: size") for size in sizes]
    if len(set(lengths)) < max(len(lengths), 2) or min(lengths, default=0.0) <= 0:
        msg = f"{who}: sizes {lengths} m; give two at least, each above zero and once"
        raise ModelError(msg)
    what = LOAD_FACTOR.name if check is None else "capacity / demand"
    rows = []
    for length, size in sorted(zip(lengths, sizes, strict=True), key=lambda pair: -pair[0]):
        model, case = build(size)
        result = run(model, case, settings=settings, progress=False)[case.name]
        settled = bool(result.settled and np.isfinite(result.load_factor))
        value = result.load_factor if check is None else float(check(result).ratio) if settled else np.nan
        rows.append((length, len(model.blocks), value, settled))
    table = pd.DataFrame(rows, columns=["size [meter]", "blocks", what, "settled"])
    table.insert(3, "relative to the first", table[what] / table[what].iloc[0])
    known = table[table["settled"]]
    if len(known) < 2:
        msg = f"{who}: {len(known)} of {len(table)} sizes have an answer that settled; give other sizes"
        raise ModelError(msg)
    x, y = (known[name].to_numpy(dtype=float) for name in ("size [meter]", what))
    slope, fine = np.polyfit(x, y, 1)
    off = y - (fine + slope * x)
    free = len(known) - 2
    scatter = float(np.sqrt((off**2).sum() / free)) if free else np.nan
    return UnitSizes(what, table, float(fine), scatter)
