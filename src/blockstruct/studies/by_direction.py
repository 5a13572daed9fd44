"""Load factors around the compass."""

import math
import re
import warnings
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from blockstruct.analysis import AnalysisManager, Listener
from blockstruct.arrays import NEGLIGIBLE, Array, Flags
from blockstruct.errors import ModelError, StudyWarning
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.model import LimitCase, LoadPattern, Model, direction_cases, direction_of
from blockstruct.results import LOAD_FACTOR
from blockstruct.results.analysis import Analysis
from blockstruct.results.case_result import CaseResult
from blockstruct.text import study
from blockstruct.vocabulary import Flow, Status, counted, in_words

_NONE = {"units": "dimensionless"}
#: Pattern of the case names that direction_cases makes.
_TITLE = re.compile(r"(?P<name>.*) \S+ deg(, \S+ (up|down))?", re.DOTALL)


@dataclass(frozen=True, slots=True, eq=False)
class Directions:
    """Load factors of one structure pushed in several horizontal directions.

    Attributes
    ----------
    analysis : Analysis
        One case for each direction.
    data : xarray.Dataset
        Along ``direction`` (degrees from +x towards +y): ``load_factor``; ``bound``, the associative load factor;
        ``status``; ``settled``, False if the load factor had not settled when its procedure ended; ``case``, the name
        in the analysis.
    """

    analysis: Analysis = field(repr=False)
    data: xr.Dataset

    @classmethod
    def of(cls, analysis: Analysis) -> "Directions":
        """Return the directions of an analysis, from a file for instance.

        They are its cases whose variable load is a horizontal push of the weight.

        Raises
        ------
        ModelError
            If the analysis has no such cases, or two cases with the same direction.
        """
        return cls._of(analysis, analysis.headlines)

    @classmethod
    def each_of(cls, analysis: Analysis) -> "list[tuple[str, Directions]]":
        """Return the name and the directions of each case of a document that has ``directions``.

        Raises
        ------
        ModelError
            If several cases share one name and one direction.
        """
        groups: dict[tuple[str, float, Flow], list[str]] = {}
        for name in analysis.headlines:
            case = analysis[name].case
            at, title = direction_of(case), _TITLE.fullmatch(name)
            if title and at and isinstance(case, LimitCase):
                groups.setdefault((title["name"], at[1], case.flow), []).append(name)
        return [(name, cls._of(analysis, names)) for (name, _, _), names in groups.items()]

    @classmethod
    def _of(cls, analysis: Analysis, among: Iterable[str]) -> "Directions":
        pushes = {name: direction_of(analysis[name].case) for name in among}
        pushed = {name: at for name, at in pushes.items() if at is not None}
        if not pushed or len({upwards for _, upwards in pushed.values()}) > 1:
            msg = (
                f"analysis of {analysis.model.name!r}: "
                + ("its cases have different vertical parts" if pushed else "no case pushes the weight in a direction")
                + "; run it by bs.directions, or give the document a case with directions"
            )
            raise ModelError(msg)
        names = sorted(pushed, key=lambda name: pushed[name])
        angles = [pushed[name][0] for name in names]
        if len(set(angles)) < len(angles):
            msg = f"analysis of {analysis.model.name!r}: several cases push in one direction; keep one of them"
            raise ModelError(msg)
        heads = [analysis.headlines[name] for name in names]
        data = xr.Dataset(
            {
                "load_factor": ("direction", [h.load_factor for h in heads], _NONE | {"long_name": "load factor α"}),
                "bound": ("direction", [analysis[name].associative_load_factor for name in names], _NONE),
                "status": ("direction", np.array([h.status.value for h in heads], dtype=object)),
                "settled": ("direction", [h.settled for h in heads]),
                "case": ("direction", np.array(names, dtype=object)),
            },
            coords={"direction": ("direction", angles, {"units": "degree", "long_name": "from +x towards +y"})},
            attrs={"vertical": pushed[names[0]][1], "model": analysis.model.name},
        )
        return cls(analysis, data)

    @property
    def load_factor(self) -> float:
        """The least load factor of all directions; NaN without any."""
        return math.nan if self._least is None else float(self.data["load_factor"][self._least])

    @property
    def governing(self) -> CaseResult:
        """Result of the direction with the least load factor.

        It holds the governing mechanism.

        Raises
        ------
        ModelError
            If no direction has a load factor.
        """
        if self._least is None:
            msg = (
                f"directions of {self.analysis.model.name!r}: none has a load factor ({self.endings}), so none governs"
            )
            raise ModelError(msg)
        return self.analysis[self._cases[self._least]]

    @property
    def governing_direction(self) -> float:
        """Direction with the least load factor; NaN without any.

        In degrees from +x towards +y.
        """
        return math.nan if self._least is None else float(self.data["direction"][self._least])

    @property
    def _cases(self) -> list[str]:
        return [str(name) for name in self.data["case"].to_numpy()]

    @property
    def _least(self) -> int | None:
        load_factors = self.data["load_factor"].to_numpy()
        if np.isnan(load_factors).all():
            return None
        # Load factors are never negative. Several may differ by rounding only: take the first.
        return int(np.flatnonzero(load_factors <= np.nanmin(load_factors) * (1 + NEGLIGIBLE))[0])

    @property
    def without_load_factor(self) -> list[str]:
        """Cases without a load factor; the envelope is unknown there."""
        return [name for name, alpha in zip(self._cases, self.data["load_factor"], strict=True) if np.isnan(alpha)]

    @property
    def endings(self) -> str:
        """Statuses of the cases in words, each once."""
        return ", ".join(in_words(status) for status in sorted(set(self.data["status"].to_numpy())))

    @property
    def is_convex(self) -> bool:
        """Whether the loads that the structure carries form a convex set.

        They do with associative flow and without a vertical part. Straight lines between the points of the envelope
        then belong to the set. Otherwise nothing is known between the directions that were run.
        """
        flows = {self.analysis[name].case.flow for name in self._cases}
        return flows == {Flow.ASSOCIATIVE} and not self.data.attrs["vertical"]

    @property
    def half_turns(self) -> Flags:
        """Whether the next direction is half a turn or more away.

        A convex set gives no information across such a gap. One value for each direction, in order; the first direction
        follows the last.
        """
        return np.asarray(self._gaps >= 180 * (1 - 1e-9))

    @property
    def _gaps(self) -> Array:
        """Angle from each direction to the next, degrees."""
        angles = self.data["direction"].to_numpy()
        return np.diff(np.append(angles, angles[0] + 360))

    @property
    def is_covered(self) -> bool:
        """Whether :attr:`least_between` covers the gaps between the directions that were run, or one was run."""
        return not math.isnan(self.least_between) or self.data.sizes["direction"] < 2

    @property
    def uncovered(self) -> str:
        """Clause on the directions between those that were run; empty if they are covered.

        It names the widest gap unless all are equal.
        """
        if self.is_covered:
            return ""
        gaps, angles = self._gaps, self.data["direction"].to_numpy()
        widest = int(np.argmax(gaps))
        if np.allclose(gaps, gaps[widest]):
            return study.uncovered_directions()
        return study.uncovered_directions(
            float(gaps[widest]), float(angles[widest]), float(np.roll(angles, -1)[widest])
        )

    @property
    def least_between(self) -> float:
        """Lower bound of the load factor in every direction.

        It includes the directions between those that were run. NaN if the loads are not a convex set
        (:attr:`is_convex`), a direction did not converge, or two neighbours are half a turn or more apart.
        """
        angles = np.radians(self.data["direction"].to_numpy())
        certain = (self.data["status"] == Status.CONVERGED).all() and self.is_convex
        if not certain or self.half_turns.any():
            return math.nan
        points = self.data["load_factor"].to_numpy()[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
        sides = np.roll(points, -1, axis=0) - points
        length = np.maximum((sides**2).sum(axis=1), 1e-300)
        nearest = points + np.clip(-(points * sides).sum(axis=1) / length, 0, 1)[:, None] * sides
        return float(np.linalg.norm(nearest, axis=1).min())

    def __str__(self) -> str:
        vertical = float(self.data.attrs["vertical"])
        n = self.data.sizes["direction"]
        push = f", with {abs(vertical):g} of it {'up' if vertical > 0 else 'down'}" if vertical else ""
        lines = [f"{self.analysis.model.name}: pushed in {counted(n, 'direction')}{push}"]
        for angle, alpha, status, settled in zip(
            *(self.data[name].to_numpy() for name in ("direction", "load_factor", "status", "settled")), strict=True
        ):
            drifts = status == Status.CONVERGED and not settled
            lines.append(
                f"  {angle:6g} deg  {LOAD_FACTOR.text(alpha):<10}{'NOT SETTLED' if drifts else in_words(status)}"
            )
        if not math.isnan(self.load_factor):
            lines.append(f"  {study.governing_direction(self.governing_direction, self.load_factor)}")
        if not math.isnan(self.least_between):
            lines.append(f"  {study.least_between_directions(self.least_between)}")
        if not self.is_covered:
            lines.append(f"  {study.between_directions(self.uncovered)}")
        if self.without_load_factor:
            lines.append(f"  {study.unknown_directions(self.without_load_factor)}")
        return "\n".join(lines)


def directions(  # noqa: PLR0913
    model: Model,
    dead: LoadPattern,
    directions: Any = 8,
    *,
    vertical: Any = 0.0,
    flow: Flow = Flow.NONASSOCIATIVE,
    store: str | Path | None = None,
    settings: ProcedureSettings | None = None,
    spread: bool | str | Iterable[str] = False,
    listeners: Iterable[Listener] = (),
) -> Directions:
    """Push a structure in several horizontal directions.

    The push is proportional to the weight. The result gives load factors around the compass and the governing one.

    Parameters
    ----------
    model
        The structure.
    dead
        Loads that act in full.
    directions : int, or quantity of angles
        A number of directions, evenly spaced from +x; or angles from +x towards +y, as ``Q_([0, 45], "deg")``.
    vertical : float
        Vertical part of the variable load, as a multiple of the horizontal part; positive upwards.
    flow
        As for :class:`blockstruct.LimitCase`.
    store, settings, listeners
        As for :class:`blockstruct.AnalysisManager`: all directions are cases of one analysis.
    spread
        As for :meth:`blockstruct.AnalysisManager.run`.

    Returns
    -------
    Directions

    Raises
    ------
    ModelError, UnitError
        If the directions are invalid, or a case cannot be run.

    Warns
    -----
    StudyWarning
        If a direction has no load factor. The envelope may be lower there.

    Examples
    --------
    >>> import blockstruct as bs
    >>> from blockstruct import Q_
    >>> stone, dry = bs.Material("tuff", unit_weight="12 kN/m^3"), bs.JointMaterial("dry", 0.6)
    >>> ground = bs.Block.box("ground", Q_([-1, -1, -1], "m"), Q_([3, 3, 1], "m"), stone, fixed=True)
    >>> pier = bs.Block.box("pier", Q_([0, 0, 0], "m"), Q_([0.4, 0.2, 1], "m"), stone)
    >>> model = bs.Model("pier", [ground, pier], bs.detect_interfaces([ground, pier], dry))
    >>> dead = bs.LoadPattern("dead", [bs.SelfWeight()])
    >>> around = bs.directions(model, dead, 4, flow="associative")
    >>> around.data.load_factor.round(4).values.tolist(), around.governing_direction
    ([0.4, 0.2, 0.4, 0.2], 90.0)
    """
    cases = direction_cases(dead, directions, vertical=vertical, flow=flow)
    manager = AnalysisManager(model, store, settings=settings, listeners=listeners, effects=False)
    around = Directions.of(manager.run(cases, spread=spread))
    if around.without_load_factor:
        msg = f"directions: {study.unknown_directions(around.without_load_factor)} ({around.endings})"
        warnings.warn(msg, StudyWarning, stacklevel=2)
    return around
