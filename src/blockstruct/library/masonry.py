"""Masonry of existing buildings: Table C8.5.I of the Italian Circolare 7/2019."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from blockstruct.errors import ModelError
from blockstruct.library.entry import Entry, Range, looked_up
from blockstruct.model import JointMaterial, Material

_SOURCE = "Circolare 21 January 2019 n. 7 C.S.LL.PP. (Italy), Table C8.5.I"
_VERIFIED = "three public transcriptions of the table; one includes the page of the official text (261)"
_BASIS = (
    "The table holds for mortar of poor quality, without levelling courses, with leaves that are poorly connected and "
    "masonry that was not strengthened; Table C8.5.II has the factors for better states."
)
_WEDGES = (
    "(*) Strengths × 1.2, without a closer evaluation, where deep wedges of stone systematically improve the contacts."
)
_LITHOLOGY = "(**) The unit weight of soft stone varies much and is easily measured."
_THICK = "(***) Where joints are thicker than 13 mm, without a closer evaluation: strengths × 0.7, moduli × 0.8."
_MEANING = {
    "f": "mean compressive strength",
    "tau0": "mean shear strength without normal stress, diagonal cracking (irregular masonry)",
    "fv0": "mean shear strength without normal stress, sliding on bed joints (regular masonry)",
    "E": "mean modulus of elasticity",
    "G": "mean shear modulus",
    "w": "mean unit weight",
}
_UNITS = dict.fromkeys(_MEANING, ("MPa", "stress")) | {"w": ("kN/m^3", "force/volume")}


@dataclass(frozen=True, slots=True, kw_only=True)
class Masonry(Entry):
    """A kind of masonry, with the unit weight of its blocks and the strengths of its joints."""

    def material(self, name: str | None = None, *, unit_weight: Any) -> Material:
        """Return the material of blocks.

        Parameters
        ----------
        name
            Name of the material; the name of the entry by default.
        unit_weight
            ``"min"``, ``"mean"`` or ``"max"`` of w, or a quantity within its range.
        """
        value, words = self.choose("w", unit_weight)
        return Material(name or self.name, value, source=self.cited([words]))

    def joint_material(
        self,
        name: str | None = None,
        *,
        friction_coefficient: Any,
        compressive_strength: Any = None,
        cohesion: Any = None,
        friction_source: str = "given by the author of the model",
    ) -> JointMaterial:
        """Return the material of the joints between blocks of this masonry.

        Parameters
        ----------
        name
            Name of the material; the name of the entry by default.
        friction_coefficient : float
            From a test, a code or :func:`joint`. The table does not contain it.
        compressive_strength
            ``"min"``, ``"mean"`` or ``"max"`` of f, or a quantity within its range. None means unlimited.
        cohesion
            The same for fv0, which irregular masonry does not have. None means no cohesion.
        friction_source
            Source of the friction coefficient.
        """
        if friction_coefficient is None:
            msg = f"library: {self.name!r}: friction_coefficient is missing; give one, Table C8.5.I does not contain it"
            raise ModelError(msg)
        values, words = {}, []
        for attribute, symbol, choice in (
            ("compressive_strength", "f", compressive_strength),
            ("cohesion", "fv0", cohesion),
        ):
            if choice is not None:
                values[attribute], text = self.choose(symbol, choice)
                words.append(f"{attribute.replace('_', ' ')} {text}")
        cited = self.cited(words) if words else ""
        source = "; ".join(filter(None, (cited, f"friction coefficient {friction_source}")))
        return JointMaterial(name or self.name, friction_coefficient, **values, source=source)


#: Names of the kinds in the source.
_ORIGINAL = {
    "irregular rubble": "Muratura in pietrame disordinata",
    "roughly cut stone": "Muratura a conci sbozzati, con paramenti di spessore disomogeneo",
    "split stone, well laid": "Muratura in pietre a spacco con buona tessitura",
    "irregular soft stone": "Muratura irregolare di pietra tenera",
    "regular soft stone": "Muratura a conci regolari di pietra tenera",
    "squared stone blocks": "Muratura a blocchi lapidei squadrati",
    "solid brick and lime mortar": "Muratura in mattoni pieni e malta di calce",
    "semi-solid brick and cement mortar": "Muratura in mattoni semipieni con malta cementizia",
}
#: Lowest and highest f, tau0, fv0, E and G in MPa, and w in kN/m³.
_VALUES = """
irregular rubble                   | 1.0 2.0 | 0.018 0.032 |           |  690 1050 | 230  350 | 19 19
roughly cut stone                  | 2.0 2.0 | 0.035 0.051 |           | 1020 1440 | 340  480 | 20 20
split stone, well laid             | 2.6 3.8 | 0.056 0.074 |           | 1500 1980 | 500  660 | 21 21
irregular soft stone               | 1.4 2.2 | 0.028 0.042 |           |  900 1260 | 300  420 | 13 16
regular soft stone                 | 2.0 3.2 | 0.040 0.080 | 0.10 0.19 | 1200 1620 | 400  500 | 13 16
squared stone blocks               | 5.8 8.2 | 0.090 0.120 | 0.18 0.28 | 2400 3300 | 800 1100 | 22 22
solid brick and lime mortar        | 2.6 4.3 | 0.050 0.130 | 0.13 0.27 | 1200 1800 | 400  600 | 18 18
semi-solid brick and cement mortar | 5.0 8.0 | 0.080 0.170 | 0.20 0.36 | 3500 5600 | 875 1400 | 15 15
"""
_NOTES = {
    "roughly cut stone": _WEDGES,
    "split stone, well laid": (
        "Of the three transcriptions one has 0.071 MPa as the greatest tau0, the two others 0.074 MPa."
    ),
    **dict.fromkeys(("irregular soft stone", "regular soft stone"), _LITHOLOGY),
    "solid brick and lime mortar": _THICK,
}


def _masonry(row: str) -> Masonry:
    name, *cells = (cell.strip() for cell in row.split("|"))
    ends = {symbol: cell.split() for symbol, cell in zip(_MEANING, cells, strict=True) if cell}
    ranges = {s: Range(float(low), float(high), *_UNITS[s], _MEANING[s]) for s, (low, high) in ends.items()}
    notes = (_BASIS, _NOTES[name]) if name in _NOTES else (_BASIS,)
    return Masonry(name=name, original=_ORIGINAL[name], ranges=ranges, source=_SOURCE, verified=_VERIFIED, notes=notes)


_TABLE = [_masonry(row) for row in _VALUES.strip().splitlines()]
#: All kinds of masonry, by name.
MASONRY: Mapping[str, Masonry] = MappingProxyType({entry.name: entry for entry in _TABLE})


def masonry(name: str) -> Masonry:
    """Return the kind of masonry with a name, in English or in Italian.

    Raises
    ------
    UnknownNameError
        If no kind has this name.

    Examples
    --------
    >>> brick = masonry("solid brick and lime mortar")
    >>> print(brick.ranges["f"])
    2.6 to 4.3 MPa
    >>> brick.material("brick", unit_weight="mean").unit_weight
    18000.0
    """
    return looked_up(name, MASONRY, "masonry")
