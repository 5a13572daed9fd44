"""The loading path: from the state under dead load, with joints that are a little elastic, to collapse."""

from collections.abc import Generator

import numpy as np

from blockstruct.limit.iteration import Found, Iteration
from blockstruct.limit.program import ConicProgram, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.closing import CLOSED, close_path
from blockstruct.procedures.interior_point_path import InteriorPointPath
from blockstruct.procedures.path import Path, gap_of
from blockstruct.procedures.splitting_path import SplittingPath
from blockstruct.vocabulary import PathEnd, Procedure

#: Attempts at a closed state.
ATTEMPTS = 8


def path_of(program: ConicProgram, settings: ProcedureSettings) -> Path:
    """The path of the settings, at its beginning, for a program with the exact cones of crushing."""
    steps = InteriorPointPath if settings.path_steps == "interior point" else SplittingPath
    return steps(program, settings)


def loading_path(
    path: Path, bound: float, settings: ProcedureSettings, solver: Solver
) -> Generator[Iteration, None, tuple[PathEnd, Found | None]]:
    """Follow the loading path to its end, and close it with an exact collapse state.

    A collapse state without dilatancy is not unique: what a structure does is decided by how it is loaded. Each step
    prescribes the displacement of the variable load and finds forces, displacements and load factor
    (:class:`~blockstruct.procedures.path.Path`), the contacts remembering openings and friction forces. Compare
    A. Orduña, P. B. Lourenço, "Three-dimensional limit analysis of rigid blocks assemblages. Part II", Int. J. Solids
    Struct. 42 (2005) 5161–5180, doi:10.1016/j.ijsolstr.2005.02.011.

    At its end the displacements still hold some elastic strain, which no rigid mechanism has. So it is
    closed by the mechanism of the largest load with friction frozen at ``μ n`` of the path, and forces that miss its
    flow rule least (:func:`~blockstruct.procedures.closing.close_path`). Measured on walls, façades and domes of 33 to
    2,430 blocks: the load factor moves by less than the gap of the path, and the gap falls by two orders and more.

    Parameters
    ----------
    path
        The path, at its beginning.
    bound
        A load factor that the path hardly passes, infinite without one; it gives the scale of a first guess.
    settings, solver
        Tolerances of the certificate, and the solver of programs that close the path.

    Yields
    ------
    Iteration
        The state under dead load, each step with its displacement, and what closes the path.

    Returns
    -------
    PathEnd, Found or None
        How the path ended; and the certified state, None if the path did not finish.
    """
    last = path.dead_load
    if last is None:
        return PathEnd.NO_DEAD_LOAD_STATE, None
    yield last
    best: Iteration | None = None
    closed: Iteration | None = None
    going, early, attempts = True, False, 0
    while going and attempts < ATTEMPTS and (best is None or gap_of(best) > CLOSED):
        step = path.advance(bound)
        going = step is not None
        if step is not None:
            last, closed = step, None
            yield last
        if closed is not None or last.displacement == 0 or not path.may_close(last, ended=not going):
            continue
        near, missed, again = path.forces(last), np.inf, True
        while again and attempts < ATTEMPTS:
            closed = yield from close_path(path, near, settings, solver)
            attempts += 1
            gap = gap_of(closed)
            if closed.certificate.holds and (best is None or gap < gap_of(best)):
                best, early = closed, not (path.at_its_end(last) or _is_nothing(path, last, closed))
            # Closed again from its own forces, a state comes nearer to one that they belong to. Fallen once more by as
            # much as this time, the gap should do.
            again = gap > CLOSED and gap / missed * gap <= CLOSED
            near, missed = closed.x, gap
        path.refine()
    if best is None:
        return path.end, None
    if best is not closed:
        # The last iteration of a history is the certified one.
        yield best
    ends = (last.load_factor, best.load_factor)
    passed = path.peak > best.load_factor + path.blur * abs(best.load_factor) and not _is_nothing(path, last, best)
    # Closed too early, a path certifies whatever load factor it has reached.
    return PathEnd.CLOSED, Found(
        best,
        Procedure.LOADING_PATH,
        settled=not early,
        drift=(min(ends), max(ends)),
        peak=path.peak if passed else np.nan,
    )


def _is_nothing(path: Path, last: Iteration, closed: Iteration) -> bool:
    """Whether the load factor at the end of a path, and where it is closed, is none beside its dead load."""
    scale = closed.certificate.flow_rule_gap_limit / closed.certificate.settings.numerics.gap_tolerance
    return max(abs(last.load_factor), abs(closed.load_factor)) <= path.blur * scale
