"""Names of statuses, dimensions and stored variables: one spelling for code, files and users."""

from collections.abc import Sequence
from enum import StrEnum

COMPONENTS = ("n", "s", "t")
AXES = ("x", "y", "z")

FORMAT = "blockstruct-analysis"
FORMAT_VERSION = "2.0"


def in_words(name: str) -> str:
    """A name of this vocabulary as a sentence says it.

    >>> in_words("unstable_under_dead_load")
    'unstable under dead load'
    """
    return name.replace("_", " ")


def counted(number: int, noun: str, plural: str = "") -> str:
    """A number of things; their plural, if it is not that with an s.

    >>> counted(1, "block"), counted(2, "block"), counted(0, "body", "bodies")
    ('1 block', '2 blocks', '0 bodies')
    """
    return f"{number} {noun if number == 1 else plural or f'{noun}s'}"


def coordinate(value: float, digits: int = 3) -> str:
    """A coordinate to so many digits, and however far from the origin to as many decimals as one of a few metres has.

    >>> coordinate(0.19732), coordinate(312.7482), coordinate(312.7482, 4), coordinate(15.0)
    ('0.197', '312.75', '312.748', '15')
    """
    return f"{value:.{digits}g}" if abs(value) < 10 else f"{round(value, digits - 1):.15g}"


def listed(names: Sequence[str], most: int = 10) -> str:
    """The first names, and how many more there are."""
    rest = len(names) - most
    return ", ".join(names[:most]) + (f" and {rest} more" if rest > 0 else "")


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

    @property
    def words(self) -> str:
        """As a sentence says it: a name with underscores is for files and programs."""
        return in_words(self.value)

    @property
    def predicate(self) -> str:
        """What a sentence says of a case: all but one are adjectives.

        >>> Status.UNBOUNDED.predicate, Status.SELF_STRESS.predicate
        ('is unbounded', 'depends on self stress')
        """
        return self.words if self is Status.SELF_STRESS else f"is {self.words}"


class Procedure(StrEnum):
    """How a load factor is found."""

    LOADING_PATH = "loading path"
    FICTITIOUS = "fictitious"
    SHIFTED = "shifted"
    ASSOCIATIVE = "associative"


class Reason(StrEnum):
    """Why a case ended with its status."""

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
    #: The load factors of successive programs grow without limit.
    GROWS_WITHOUT_LIMIT = "grows_without_limit"
    #: The loading path ends without a load factor that stays.
    NEVER_SETTLES = "never_settles"
    #: The solver did not solve a program that all others need.
    PROGRAM_NOT_SOLVED = "program_not_solved"
    #: No state met the tolerances of the certificate.
    NO_CERTIFICATE = "no_certificate"
    #: The state that was found has a negative load factor.
    NEGATIVE_LOAD_FACTOR = "negative_load_factor"
    #: The user stopped the run.
    INTERRUPTED = "interrupted"
    #: The process of the run ended before the case did.
    KILLED = "killed"
    #: No program of the case was solved.
    NOT_BEGUN = "not_begun"


class PathEnd(StrEnum):
    """How a loading path ended."""

    #: A collapse state is certified at its end.
    CLOSED = "closed"
    #: No state under dead load was found to begin with.
    NO_DEAD_LOAD_STATE = "no_dead_load_state"
    #: A step was not solved.
    STEP_NOT_SOLVED = "step_not_solved"
    #: The largest displacement or number of iterations was reached.
    LIMIT_REACHED = "limit_reached"
    #: No state at its end met the tolerances of the certificate.
    NOT_CERTIFIED = "not_certified"


class CurveEnd(StrEnum):
    """How a capacity curve ended, or why there is none."""

    #: The load factor is zero.
    ZERO = "zero"
    #: A block falls by more than a mean block size.
    FALLS = "falls"
    #: No forces are found that hold the blocks, or the push meets what it cannot move.
    NOT_SOLVED = "not_solved"
    #: The largest number of states was reached.
    LIMIT_REACHED = "limit_reached"
    #: The control point does not move in the collapse mechanism.
    RESTS = "rests"
    #: The file is of an earlier version, which found its curve in another way.
    EARLIER_VERSION = "earlier_version"
    #: Blocks touch beyond the interfaces of the model, and would carry more.
    BEGINS_ABOVE = "begins_above"


class Stage(StrEnum):
    """Which program, or step, of the procedure an iteration solved."""

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
    """What a conic solver says of one program: a claim to be checked, never a result."""

    SOLVED = "solved"
    ALMOST_SOLVED = "almost_solved"
    INFEASIBLE = "infeasible"
    UNBOUNDED = "unbounded"
    FAILED = "failed"


class ContactState(StrEnum):
    """State of an interface in one iteration. Hinge, sliding, twisting and crushing combine: ``"hinge + sliding"``."""

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
    #: Between none and its largest force.
    STRESSED = "stressed"
    #: At its largest force: by the bar or strip itself, by the masonry under its plate, by its bond.
    YIELDING = "yielding"
    PUNCHING = "punching"
    SLIPPING = "slipping"
    #: Beyond its elongation limit, in a pushover.
    BROKEN = "broken"
    UNKNOWN = "unknown"


class Torsion(StrEnum):
    """How an interface resists torsion about its normal."""

    #: By friction at its contact points, as all other shear.
    CORNERS = "corners"
    #: By no more than friction under uniform pressure does.
    UNIFORM_PRESSURE = "uniform pressure"


class JointOrientation(StrEnum):
    """How a joint lies, by the angle of its normal to the vertical."""

    #: Up to 30 degrees: under the courses of a wall.
    BED = "bed"
    #: Between the two: most joints of an arch.
    INCLINED = "inclined"
    #: 60 degrees and more: between the units of a course.
    HEAD = "head"

    @classmethod
    def of(cls, vertical: float) -> "JointOrientation":
        """Orientation of a joint by the vertical component of its unit normal."""
        if abs(vertical) > 0.5 * 3**0.5 - 1e-9:
            return cls.BED
        return cls.HEAD if abs(vertical) < 0.5 + 1e-9 else cls.INCLINED
