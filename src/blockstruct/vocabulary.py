"""Names of statuses, dimensions and stored variables: one spelling for code, files and users."""

from collections.abc import Sequence
from enum import StrEnum

COMPONENTS = ("n", "s", "t")
AXES = ("x", "y", "z")

#: In the message of a case whose load factor had not settled when its iteration was stopped.
DRIFTING = "still drifting"
#: In the message of a case that ended along its loading path.
ALONG_PATH = "along the loading path"
#: In the message of a pushover, before what it tells of the curve, or of why there is none.
OF_CURVE = "; pushover: "

#: In the message of a case, before the blocks whose dead load, or whose variable load, self-stress decides on.
OF_HUNG, OF_JAMMED = "; hung by friction between supports: ", "; jammed: "
#: In the message of a loading path that could not begin, before what took its place.
NO_STATE = "the loading path found no state under dead load"

FORMAT = "blockstruct-analysis"
FORMAT_VERSION = "1.0"


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


class Stage(StrEnum):
    """Which program, or step, of the procedure an iteration solved."""

    DEAD_LOAD = "dead_load"
    LARGEST_REACTION = "largest_reaction"
    ASSOCIATIVE = "associative"
    NONASSOCIATIVE = "nonassociative"
    ADMISSIBLE = "admissible"
    SHIFTED = "shifted"
    LOADING_PATH = "loading_path"


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
