"""Names of statuses, dimensions and variables for code, files and users."""

from collections.abc import Callable, Sequence
from enum import StrEnum
from unicodedata import category

COMPONENTS = ("n", "s", "t")
AXES = ("x", "y", "z")
#: Motions of a block: along the global axes, and about them through its centroid.
MOTIONS = ("x", "y", "z", "rx", "ry", "rz")

FORMAT = "blockstruct-analysis"
FORMAT_VERSION = "2.0"


def in_words(name: str) -> str:
    """Return a name of this vocabulary as words.

    >>> in_words("unstable_under_dead_load")
    'unstable under dead load'
    """
    return name.replace("_", " ")


def printable(text: str) -> str:
    r"""Return a text with the unsafe characters for a terminal escaped.

    These are control characters, direction marks and halves of surrogate pairs. Line breaks and tabs are unchanged.

    >>> printable("fine \x1b[2K"), printable("wall\u202e")
    ('fine \\x1b[2K', 'wall\\u202e')
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in "\n\t" or category(c) == "Zs" else ascii(c)[1:-1] for c in text)


def counted(number: int, noun: str, plural: str = "") -> str:
    """Return a number with its noun; the default plural adds an s.

    >>> counted(1, "block"), counted(2, "block"), counted(0, "body", "bodies")
    ('1 block', '2 blocks', '0 bodies')
    """
    return f"{number} {noun if number == 1 else plural or f'{noun}s'}"


def coordinate(value: float, digits: int = 3) -> str:
    """Return a coordinate as text.

    Below 10, ``digits`` counts significant digits. From 10 on, there are at most ``digits - 1`` decimals.

    >>> coordinate(0.19732), coordinate(312.7482), coordinate(312.7482, 4), coordinate(15.0)
    ('0.197', '312.75', '312.748', '15')
    """
    return f"{value:.{digits}g}" if abs(value) < 10 else f"{round(value, digits - 1):.15g}"


def axis_text(direction: Sequence[float]) -> str:
    """Return a direction as an axis, or as its three components.

    >>> axis_text((0, 0, -1)), axis_text((0.6, 0.8, 0))
    ('-z', '(0.6, 0.8, 0)')
    """
    rounded = [round(value, 4) + 0.0 for value in direction]
    named = [f"{'-' if value < 0 else '+'}{axis}" for axis, value in zip(AXES, rounded, strict=True) if value]
    return named[0] if len(named) == 1 else f"({', '.join(f'{value:.3g}' for value in rounded)})"


#: Items that a sentence lists, and that a list has, before it counts the others.
FEW, LISTED = 3, 10


def listed(names: Sequence[str], most: int = LISTED, noun: str = "") -> str:
    """Return the first names, and the number of the others, which may have a noun."""
    rest = len(names) - most
    others = counted(rest, f"more {noun}") if noun else f"{rest} more"
    return ", ".join(names[:most]) + (f" and {others}" if rest > 0 else "")


def shortened(lines: Sequence[str], others: Callable[[int], str] = "and {} more".format) -> list[str]:
    """Return the first lines of a list, and a line on the number of the others."""
    rest = len(lines) - LISTED
    return [*lines[:LISTED], *([others(rest)] if rest > 0 else [])]


class Flow(StrEnum):
    """Flow rule of sliding."""

    ASSOCIATIVE = "associative"
    NONASSOCIATIVE = "nonassociative"


class Status(StrEnum):
    """How a limit case ended. A status is a result, not an error."""

    CONVERGED = "converged"
    UNSTABLE = "unstable_under_dead_load"
    SELF_STRESS = "depends_on_self_stress"
    UNBOUNDED = "unbounded"
    NOT_CONVERGED = "not_converged"
    INTERRUPTED = "interrupted"
    #: Of the response to a record.
    STANDS = "stands"
    COLLAPSES = "collapses"
    UNDECIDED = "undecided"

    @property
    def is_answer(self) -> bool:
        """Whether the case has an answer: a load factor, or the end of a response to a record."""
        return self in (Status.CONVERGED, Status.STANDS, Status.COLLAPSES)

    @property
    def is_of_dead_load(self) -> bool:
        """Whether the last iteration shows how the structure falls under its dead load."""
        return self in (Status.UNSTABLE, Status.SELF_STRESS)

    @property
    def words(self) -> str:
        """The status in words; underscores are for files and programs."""
        return in_words(self.value)

    @property
    def predicate(self) -> str:
        """The status as a predicate.

        >>> Status.UNBOUNDED.predicate, Status.SELF_STRESS.predicate
        ('is unbounded', 'depends on self stress')
        """
        as_verb = (Status.SELF_STRESS, Status.STANDS, Status.COLLAPSES)
        return self.words if self in as_verb else f"is {self.words}"


class Procedure(StrEnum):
    """Method that finds a load factor."""

    LOADING_PATH = "loading path"
    FICTITIOUS = "fictitious"
    SHIFTED = "shifted"
    ASSOCIATIVE = "associative"


class Reason(StrEnum):
    """Reason for the status of a case."""

    #: A collapse state is certified.
    CERTIFIED = "certified"
    #: The joints carry less than the dead load.
    DEAD_LOAD_NOT_CARRIED = "dead_load_not_carried"
    #: The dead load alone has a collapse state without dilatancy.
    DEAD_LOAD_COLLAPSES = "dead_load_collapses"
    #: The solver found neither forces that carry the dead load nor a mechanism.
    DEAD_LOAD_UNDECIDED = "dead_load_undecided"
    #: With associative flow no multiple of the load causes collapse.
    NEVER_COLLAPSES = "never_collapses"
    #: Forces carry any multiple of the load. Without dilatancy this does not exclude collapse.
    CARRIES_ANY_LOAD = "carries_any_load"
    #: Load factors of successive programs grow without limit.
    GROWS_WITHOUT_LIMIT = "grows_without_limit"
    #: The load factor still varies at the end of the loading path.
    NEVER_SETTLES = "never_settles"
    #: The load factor still varies there, and with associative flow it has no bound.
    JAMS = "jams"
    #: The solver failed on a program that all others need.
    PROGRAM_NOT_SOLVED = "program_not_solved"
    #: No state met the tolerances of the certificate.
    NO_CERTIFICATE = "no_certificate"
    #: The certified state has a negative load factor.
    NEGATIVE_LOAD_FACTOR = "negative_load_factor"
    #: After the record, the structure is at rest.
    AT_REST = "at_rest"
    #: A block has fallen during the record, or after it.
    BLOCKS_FALLEN = "blocks_fallen"
    #: Blocks still move at the end of the longest response.
    STILL_MOVING = "still_moving"
    #: A step of the response was not solved.
    STEP_NOT_SOLVED = "step_not_solved"
    #: The user stopped the run.
    INTERRUPTED = "interrupted"
    #: The process ended before the case did.
    KILLED = "killed"
    #: No program of the case was solved.
    NOT_BEGUN = "not_begun"


class PathEnd(StrEnum):
    """How a loading path ended."""

    #: A collapse state is certified at its end.
    CLOSED = "closed"
    #: No state under dead load was found at the start.
    NO_DEAD_LOAD_STATE = "no_dead_load_state"
    #: A step was not solved.
    STEP_NOT_SOLVED = "step_not_solved"
    #: The largest displacement or number of iterations was reached.
    LIMIT_REACHED = "limit_reached"
    #: No state at its end met the tolerances of the certificate.
    NOT_CERTIFIED = "not_certified"


class CurveEnd(StrEnum):
    """How a capacity curve ended, or why it is missing."""

    #: The load factor is zero.
    ZERO = "zero"
    #: A block falls by more than a mean block size.
    FALLS = "falls"
    #: The push, or a support that settles, meets blocks that it cannot move.
    JAMS = "jams"
    #: No forces are found that hold the blocks.
    NOT_SOLVED = "not_solved"
    #: The supports have reached the displacement of their case.
    DISPLACEMENT_REACHED = "displacement_reached"
    #: The push has moved a block further than the structure is large.
    CARRIED_AWAY = "carried_away"
    #: The largest number of states was reached.
    LIMIT_REACHED = "limit_reached"
    #: The control point does not move in the collapse mechanism.
    RESTS = "rests"
    #: The file is of an earlier version, which found its curve in another way.
    EARLIER_VERSION = "earlier_version"
    #: Blocks touch beyond the interfaces of the model, and would carry more.
    BEGINS_ABOVE = "begins_above"


class CurveDoubt(StrEnum):
    """Reason to doubt a part of a capacity curve."""

    #: The curve begins above the load factor of the collapse state.
    BEGINS_ABOVE = "begins_above"
    #: The load factor rises above its first value.
    RISES = "rises"
    #: The load factor jumps where blocks slip and catch.
    SLIPS = "slips"
    #: The load factor jumps where another mechanism takes over.
    LEAPS = "leaps"
    #: Blocks slide before a long step and rock after it.
    ROCKS = "rocks"
    #: Blocks slide before a long step, and rock and slide after it.
    ROCKS_AND_SLIDES = "rocks_and_slides"
    #: The control point goes back.
    GOES_BACK = "goes_back"
    #: The forces do not balance the energy of a step.
    MISSES_WORK = "misses_work"
    #: The certificates of some states in which no blocks fall do not hold.
    NOT_CERTIFIED = "not_certified"


class Stage(StrEnum):
    """Program, or step, of the procedure that an iteration solved."""

    DEAD_LOAD = "dead_load"
    #: A collapse state of the dead load without dilatancy.
    DEAD_LOAD_COLLAPSE = "dead_load_collapse"
    LARGEST_REACTION = "largest_reaction"
    ASSOCIATIVE = "associative"
    NONASSOCIATIVE = "nonassociative"
    ADMISSIBLE = "admissible"
    SHIFTED = "shifted"
    LOADING_PATH = "loading_path"

    @property
    def is_of_dead_load(self) -> bool:
        """Whether the program has no variable load."""
        return self in (Stage.DEAD_LOAD, Stage.DEAD_LOAD_COLLAPSE)


class SolverStatus(StrEnum):
    """Status from a conic solver for one program.

    It is a claim to be checked, never a result.
    """

    SOLVED = "solved"
    ALMOST_SOLVED = "almost_solved"
    INFEASIBLE = "infeasible"
    UNBOUNDED = "unbounded"
    FAILED = "failed"


class ContactState(StrEnum):
    """State of an interface in one iteration.

    Hinge, sliding, twisting and crushing combine: ``"hinge + sliding"``.
    """

    OPEN = "open"
    STICKING = "sticking"
    SLIDING = "sliding"
    HINGE = "hinge"
    TWISTING = "twisting"
    CRUSHING = "crushing"
    UNKNOWN = "unknown"


class TieState(StrEnum):
    """State of a tie, or of a stretch of a bonded bar, in one iteration."""

    #: Without force.
    SLACK = "slack"
    #: Force between zero and the largest one.
    STRESSED = "stressed"
    #: At its largest force: limited by the bar or strip, by the masonry under its plate, or by its bond.
    YIELDING = "yielding"
    PUNCHING = "punching"
    SLIPPING = "slipping"
    #: Beyond its elongation limit, in a pushover.
    BROKEN = "broken"
    UNKNOWN = "unknown"


class Torsion(StrEnum):
    """Limit of torsion of an interface about its normal."""

    #: Limited by friction at contact points, as all other shear.
    CORNERS = "corners"
    #: Limited by friction under uniform pressure.
    UNIFORM_PRESSURE = "uniform pressure"


class JointOrientation(StrEnum):
    """Orientation of a joint, by the angle of its normal to the vertical."""

    #: Up to 30 degrees: under the courses of a wall.
    BED = "bed"
    #: Between the two: most joints of an arch.
    INCLINED = "inclined"
    #: 60 degrees and more: between units within a course.
    HEAD = "head"

    @classmethod
    def of(cls, vertical: float) -> "JointOrientation":
        """Return the orientation from the vertical component of the normal.

        The normal has unit length.
        """
        if abs(vertical) > 0.5 * 3**0.5 - 1e-9:
            return cls.BED
        return cls.HEAD if abs(vertical) < 0.5 + 1e-9 else cls.INCLINED


class Way(StrEnum):
    """A way to find capacity over demand of a local mechanism."""

    COLLAPSE = "collapse mechanism"
    WITHOUT_SMALL = "without bodies that move far less"
    OTHER_MOTION = "another motion"
    LOWER_END = "lower end of the range"
    UPPER_END = "upper end of the range"
    UNIFORM_TORSION = "torsion of uniform pressure"
    LOWERED_FRICTION = "friction without excess of torsion"
    BIAXIAL = "crushing about both axes"
    OTHER_PROCEDURE = "another procedure"
    WEIGHTS = "displacement of the weights"
    ALONE = "a body that overturns alone"
