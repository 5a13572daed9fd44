"""The loading path: from the state under dead load, with joints that are a little elastic, to collapse."""

from collections.abc import Generator
from dataclasses import replace

import numpy as np

from blockstruct.limit.crushing import bearing
from blockstruct.limit.iteration import Found, Iteration
from blockstruct.limit.program import ConicProgram, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.closing import CLOSED, close_path
from blockstruct.procedures.interior_point_path import InteriorPointPath
from blockstruct.procedures.path import SETTLED, Path
from blockstruct.procedures.splitting_path import SplittingPath
from blockstruct.vocabulary import PathEnd, Procedure

#: Attempts at a closed state.
ATTEMPTS = 8


def path_of(program: ConicProgram, settings: ProcedureSettings) -> Path:
    """Return the path of the settings, at its beginning, for a program of steps without dilatancy."""
    return _KINDS[settings.path_steps](program, settings)


_KINDS: dict[str, type[Path]] = {"splitting": SplittingPath, "interior point": InteriorPointPath}


def loading_path(
    path: Path, exact: ConicProgram, bound: float, settings: ProcedureSettings, solver: Solver
) -> Generator[Iteration, None, tuple[PathEnd, Found | None]]:
    """Follow the loading path to its end, and close it with an exact collapse state.

    A collapse state without dilatancy is not unique: it depends on how the structure is loaded. Each step prescribes
    the displacement of the variable load and finds forces, displacements and load factor
    (:class:`~blockstruct.procedures.path.Path`). The contacts remember openings and friction forces. Compare
    A. Orduña, P. B. Lourenço, "Three-dimensional limit analysis of rigid blocks assemblages. Part II", Int. J. Solids
    Struct. 42 (2005) 5161–5180, doi:10.1016/j.ijsolstr.2005.02.011.

    The path ends where the load factor has hardly moved while the displacement grew tenfold. Its displacements still
    contain some elastic strain, which no rigid mechanism has. So it is closed by the mechanism of the largest load with
    friction frozen at ``μ n`` of the path, and forces that miss its flow rule least
    (:func:`~blockstruct.procedures.closing.close_path`). If its load factor is not that of the path, the path
    continues.

    A path that does not finish, or whose closed state has another load factor, is followed again in half steps, and
    then in steps of the other kind.

    Parameters
    ----------
    path
        The path, at its beginning.
    exact
        The program with the exact cones of crushing.
    bound
        A load factor that the path hardly passes, infinite without one. It gives the scale of a first guess.
    settings, solver
        Tolerances of the certificate, and the solver of programs that close the path.

    Yields
    ------
    Iteration
        The state under dead load, each step with its displacement, and the programs that close the path.

    Returns
    -------
    PathEnd, Found or None
        How the path ended, and the certified state. If the load factor never settles, the last step. None if no path
        began or a step was not solved.
    """
    end, found = yield from _followed(path, exact, bound, settings, solver)
    (other,) = _KINDS.keys() - {settings.path_steps}
    half_steps = (type(path), settings, 2)
    other_kind = (_KINDS[other], replace(settings, path_steps=other), 1)
    last = found
    for kind, changed, divided in (half_steps, other_kind):
        if end is PathEnd.CLOSED and found is not None and found.settled:
            break
        again, last = yield from _followed(kind(path.program, changed, divided), exact, bound, changed, solver)
        if again is PathEnd.CLOSED and last is not None and (end is not PathEnd.CLOSED or last.settled):
            end, found = again, last
    if end is PathEnd.CLOSED and found is not None and found is not last:
        # The last iteration of a history is the certified one.
        yield found.state
    return end, found


def _followed(
    path: Path, program: ConicProgram, bound: float, settings: ProcedureSettings, solver: Solver
) -> Generator[Iteration, None, tuple[PathEnd, Found | None]]:
    """Follow one path, and close it by a program with the exact cones of crushing."""
    last = path.dead_load
    if last is None:
        return PathEnd.NO_DEAD_LOAD_STATE, None
    yield last
    best: Found | None = None
    closed, exact, attempts = last, False, 0
    while not exact and attempts < ATTEMPTS:
        step = path.advance(bound)
        if step is None:
            break
        yield step
        last = step
        if not path.has_settled(last):
            continue
        near, lengths, missed, again = path.forces(last), path.bearing, np.inf, True
        while again and attempts < ATTEMPTS:
            closed = yield from close_path(path, program, near, lengths, settings, solver)
            attempts += 1
            gap = path.gap(closed)
            if closed.certificate.holds:
                found = _found(path, closed)
                if best is None or (found.settled, -gap) > (best.settled, -path.gap(best.state)):
                    best = found
            # Closed again from its own forces, a state comes nearer to one that they belong to. Fallen once more by as
            # much as this time, the gap should do.
            again = gap > CLOSED and gap / missed * gap <= CLOSED
            near, missed = closed.x, gap
            lengths = bearing(path.program.problem, near[:, 0], lengths)
        exact = best is not None and best.settled and path.gap(best.state) <= CLOSED
        path.refine()
    if best is not None:
        if best.state is not closed:
            # The last iteration of a history is the certified one.
            yield best.state
        return PathEnd.CLOSED, best
    if attempts:
        return PathEnd.NOT_CERTIFIED, None
    if path.end is PathEnd.LIMIT_REACHED:
        return path.end, Found(last, Procedure.LOADING_PATH, settled=False, drift=path.drift)
    return path.end, None


def _found(path: Path, closed: Iteration) -> Found:
    """Return the closed state of a path, settled if its load factor is that of the path."""
    low, high = path.drift
    around = SETTLED * path.scale(closed)
    return Found(
        closed,
        Procedure.LOADING_PATH,
        settled=low - around <= closed.load_factor <= high + around,
        drift=(min(low, closed.load_factor), max(high, closed.load_factor)),
        peak=path.peak if path.peak > max(high, closed.load_factor) + around else np.nan,
    )
