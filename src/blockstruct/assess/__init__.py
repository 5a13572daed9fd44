"""Verification of local mechanisms, Circolare 21/01/2019 n. 7, C8.7.1.2.1.

>>> import blockstruct as bs
>>> stone, dry = bs.Material("stone", "18 kN/m^3"), bs.JointMaterial("dry", 0.7)
>>> ground = bs.Block.box("ground", "[-1, -1, -0.5] m", "[7, 3, 0.5] m", stone, fixed=True)
>>> wall = bs.Block.box("façade", "[0, 0, 0] m", "[5, 0.6, 6] m", stone)
>>> model = bs.Model("façade", [ground, wall], bs.detect_interfaces([ground, wall], joint_material=dry))
>>> push = bs.LoadPattern("push", [bs.BodyForce("-y")])
>>> case = bs.LimitCase("out of plane", bs.LoadPattern("dead", [bs.SelfWeight()]), push)
>>> result = bs.AnalysisManager(model).run([case])["out of plane"]
>>> site = bs.assess.ntc_spectrum(ag="0.15 g_0", F0=2.4, Tc="0.3 s", soil="B")
>>> check = bs.assess.local_mechanism(result, confidence_factor=1.35, spectrum=site)
>>> round(check.e_star, 6), round(check.a0_star, 4), round(check.ratio, 4)
(1.0, 0.7264, 0.823)
"""

from blockstruct.assess.building import DIRECTIONS, Building, building
from blockstruct.assess.capacity import CapacityCurve
from blockstruct.assess.check import LocalMechanismCheck, Verdict, WayOfChecking
from blockstruct.assess.floor_spectrum import FloorSpectrum, Mode, Spectrum, floor_spectrum
from blockstruct.assess.limit_states import KNOWLEDGE_LEVELS, Coefficients, LimitState
from blockstruct.assess.lines import Line, Section
from blockstruct.assess.local_mechanism import local_mechanism
from blockstruct.assess.overturning import Overturning, overturning
from blockstruct.assess.participation import Participation
from blockstruct.assess.spectrum import NtcSpectrum, TableSpectrum, ntc_spectrum, table_spectrum
from blockstruct.assess.unit_sizes import UnitSizes, unit_sizes
from blockstruct.model import STANDARD_GRAVITY
from blockstruct.vocabulary import Way

__all__ = ["DIRECTIONS", "Building", "building", "UnitSizes", "unit_sizes"]
__all__ += ["LocalMechanismCheck", "LimitState", "Verdict", "Way", "WayOfChecking", "local_mechanism"]
__all__ += ["Coefficients", "KNOWLEDGE_LEVELS", "CapacityCurve", "Participation", "Overturning", "overturning"]
__all__ += ["FloorSpectrum", "Mode", "NtcSpectrum", "Spectrum", "TableSpectrum"]
__all__ += ["floor_spectrum", "ntc_spectrum", "table_spectrum", "STANDARD_GRAVITY", "Line", "Section"]
