"""Dry-joint walls of Ferris & Tin-Loi (2001), Int. J. Mech. Sci. 43: 209–224, examples 1, 3 and 4."""

import blockstruct as bs
from random_structures import STONE, Structure, joint, push

PLAIN, BROKEN = [0.5, 1, 1, 1, 1, 0.5], [1, 1, 1, 1, 1]
WALL_1 = [PLAIN, BROKEN] * 3
FULL, HALVES = [1, 1, 1, 1], [0.5, 1, 1, 1, 0.5]
JAMB_A, JAMB_B = [0.5, 1, -1, 1, 0.5], [1, 0.5, -1, 0.5, 1]
WALL_3 = [FULL, HALVES, FULL, JAMB_A, JAMB_B, JAMB_A, JAMB_B, JAMB_A, FULL, HALVES, FULL]
PIERS_A, PIERS_B = [1, -1, 1, -1, 1], [0.5, 0.5, -1, 0.5, 0.5, -1, 0.5, 0.5]
WALL_4 = [PLAIN, BROKEN, PLAIN, PIERS_A, PIERS_B, PIERS_A, PIERS_B, PIERS_A, PLAIN, BROKEN, PLAIN]
#: Rows, blocks, interfaces, associative load factor, lowest non-associative load factor known.
WALLS = {
    1: (WALL_1, 33, 83, 0.64286, 0.6398),
    3: (WALL_3, 46, 102, 0.40369, 0.3558),
    4: (WALL_4, 55, 116, 0.33195, 0.2637),
}


def blocks(number: int, depth: str = "0.1 m") -> list[bs.Block]:
    """Units of a wall, of 16 kN/m³."""
    return bs.courses(WALLS[number][0], unit_length="0.4 m", unit_height="0.175 m", thickness=depth, material=STONE)


def wall(number: int) -> Structure:
    """A wall pushed in its plane, 0.1 m deep, with friction of 0.65."""
    return Structure(f"wall {number}", "published", blocks(number), joint(0.65), push(1, 0, 0))
