"""Façades with piers and spandrels."""

from blockstruct.errors import ModelError
from blockstruct.model import Block, Material
from blockstruct.model.checks import check_total, checked_count
from blockstruct.structures.builder import builder, lengths
from blockstruct.structures.openings import Opening
from blockstruct.structures.wall import wall
from blockstruct.units import QuantityLike, to_quantity


@builder
def pier_spandrel(
    *,
    bays: int,
    storeys: int,
    pier_width: QuantityLike,
    opening_width: QuantityLike,
    opening_height: QuantityLike,
    spandrel_height: QuantityLike,
    unit_length: QuantityLike,
    unit_height: QuantityLike,
    thickness: QuantityLike,
    material: Material,
    base: bool = True,
    prefix: str = "",
) -> list[Block]:
    """Return the blocks of a façade with equal openings between piers, storey on storey, in running bond.

    Parameters
    ----------
    bays, storeys
        Number of openings along x and along z. There are ``bays + 1`` piers.
    pier_width, opening_width : quantity, length
        Widths along x.
    opening_height, spandrel_height : quantity, length
        Heights along z, multiples of the course height. The lowest openings begin on the ground. Lintels extend half a
        unit into the piers, or half of a pier that is narrower than a unit.
    unit_length, unit_height, thickness, material, base, prefix
        As for :func:`wall`.

    Raises
    ------
    ModelError
        If a height is not a multiple of the course height.

    Examples
    --------
    >>> tuff = Material("tuff", "12 kN/m^3")
    >>> blocks = pier_spandrel(
    ...     bays=2, storeys=2, pier_width="1 m", opening_width="1 m", opening_height="1.2 m", spandrel_height="0.6 m",
    ...     unit_length="0.5 m", unit_height="0.2 m", thickness="0.25 m", material=tuff,
    ... )
    >>> [b.name for b in blocks if "lintel" in b.name]
    ['7.lintel1', '7.lintel2', '16.lintel1', '16.lintel2']
    """
    n, m = checked_count(bays, 1, "pier_spandrel: bays"), checked_count(storeys, 1, "pier_spandrel: storeys")
    pier, clear = lengths("pier_spandrel", pier_width=pier_width, opening_width=opening_width)
    heights = {"opening_height": opening_height, "spandrel_height": spandrel_height, "unit_height": unit_height}
    opening, spandrel, course = lengths("pier_spandrel", **heights)
    (unit,) = lengths("pier_spandrel", unit_length=unit_length)
    for what, value in (("opening_height", opening), ("spandrel_height", spandrel)):
        if abs(value / course - round(value / course)) > 1e-6:
            msg = (
                f"pier_spandrel: {what} {value:.6g} m is not a multiple of the course height {course:.6g} m; change one"
            )
            raise ModelError(msg)
    check_total(n * m, "pier_spandrel")
    size = clear, opening, min(unit, pier) / 2
    openings = [
        Opening(*(to_quantity(v, "length") for v in (pier + k * (pier + clear), j * (opening + spandrel), *size)))
        for j in range(m)
        for k in range(n)
    ]
    return wall(
        length=to_quantity((n + 1) * pier + n * clear, "length"),
        courses=m * round((opening + spandrel) / course),
        unit_length=unit_length,
        unit_height=unit_height,
        thickness=thickness,
        material=material,
        openings=openings,
        base=base,
        prefix=prefix,
    )
