"""Values of masonry and of joints with their sources. The user chooses every value; there are no defaults.

>>> print(masonry("regular soft stone"))
regular soft stone (Muratura a conci regolari di pietra tenera)
  f: 2 to 3.2 MPa – mean compressive strength
  tau0: 0.04 to 0.08 MPa – mean shear strength without normal stress, diagonal cracking (irregular masonry)
  fv0: 0.1 to 0.19 MPa – mean shear strength without normal stress, sliding on bed joints (regular masonry)
  E: 1200 to 1620 MPa – mean modulus of elasticity
  G: 400 to 500 MPa – mean shear modulus
  w: 13 to 16 kN/m³ – mean unit weight
  source: Circolare 21 January 2019 n. 7 C.S.LL.PP. (Italy), Table C8.5.I
  read in: three public transcriptions of the table; one includes the page of the official text (261)
  note: The table holds for mortar of poor quality, ...
  note: (**) The unit weight of soft stone varies much and is easily measured.
>>> print(masonry("regular soft stone").material("tuff", unit_weight="mean").source)
regular soft stone: w = 14.5 kN/m³, mean of 13 to 16 kN/m³ (Circolare 21 January 2019 n. 7 ..., Table C8.5.I)
"""

from blockstruct.library.entry import Entry, Range
from blockstruct.library.joints import JOINTS, DryJoint, joint
from blockstruct.library.masonry import MASONRY, Masonry, masonry

__all__ = ["JOINTS", "MASONRY", "DryJoint", "Entry", "Masonry", "Range", "joint", "masonry"]
