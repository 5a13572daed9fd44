"""Types of arrays in annotations; what counts as equal and as zero in them."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]

#: Relative difference of numbers that are equal up to rounding, and cosine or sine of an angle that is zero.
ROUNDING = 1e-9
#: Share of a whole that counts as zero: solvers are no more exact, and files of other programs have fewer digits.
NEGLIGIBLE = 1e-6
#: Share of a whole that does not matter to a structure: rounding of numbers that users type, slivers of areas, the
#: accuracy of a certified collapse state, work that a step of a motion may miss.
SLIGHT = 1e-3
#: Share of a whole that is most of it.
MOSTLY = 0.5
#: Number of values that are computed at once, which limits the memory.
CHUNK = 2_000_000
