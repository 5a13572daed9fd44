"""Cost of crushing in the paper's iteration: programs, interior-point iterations and time, as ratios.

Walls with openings (1, 3 and 4 of Ferris & Tin-Loi, depth 0.1 m), with infinite strength and with f_c of 20 and 10
times unit weight × 1 m, crushing as cones of the effective rectangle (biaxial) and of its edges (uniaxial), and
linearised in the loop of friction. Every ratio is to the friction-only loop of the same wall in the same run; times are
the least of three. Run it with ``make bench``.
"""

import blockstruct as bs
from blockstruct import Q_

PLAIN, BROKEN = [0.5, 1, 1, 1, 1, 0.5], [1, 1, 1, 1, 1]
FULL, HALVES = [1, 1, 1, 1], [0.5, 1, 1, 1, 0.5]
JAMB_A, JAMB_B = [0.5, 1, -1, 1, 0.5], [1, 0.5, -1, 0.5, 1]
PIERS_A, PIERS_B = [1, -1, 1, -1, 1], [0.5, 0.5, -1, 0.5, 0.5, -1, 0.5, 0.5]
CRUSHING = {
    "biaxial": bs.ProcedureSettings(procedure="fictitious"),
    "uniaxial": bs.ProcedureSettings(procedure="fictitious", crushing_interaction="uniaxial"),
    "linearised": bs.ProcedureSettings(procedure="fictitious", crushing="linearised"),
}
WALLS = {
    1: [PLAIN, BROKEN] * 3,
    3: [FULL, HALVES, FULL, JAMB_A, JAMB_B, JAMB_A, JAMB_B, JAMB_A, FULL, HALVES, FULL],
    4: [PLAIN, BROKEN, PLAIN, PIERS_A, PIERS_B, PIERS_A, PIERS_B, PIERS_A, PLAIN, BROKEN, PLAIN],
}
TUFF = bs.Material("tuff", unit_weight="12 kN/m^3")


def solved(rows: list[list[float]], fc: int | None, settings: bs.ProcedureSettings) -> bs.CaseResult:
    strength = None if fc is None else Q_(12e3 * fc, "Pa")
    joint = bs.JointMaterial("joint", 0.65, compressive_strength=strength)
    blocks = bs.courses(rows, unit_length="0.4 m", unit_height="0.175 m", thickness="0.1 m", material=TUFF)
    model = bs.Model("wall", blocks, bs.detect_interfaces(blocks, joint_material=joint).interfaces)
    dead, push = bs.LoadPattern("dead", [bs.SelfWeight()]), bs.LoadPattern("push", [bs.BodyForce((1, 0, 0))])
    manager = bs.AnalysisManager(model, settings=settings)
    runs = [manager.run([bs.LimitCase("push", dead, push)])["push"] for _ in range(3)]
    return min(runs, key=lambda r: float(r.history.solver_time.sum()))


def main() -> None:
    print(
        f"{'wall':<6}{'f_c':>5}  {'crushing':<12}{'load factor':>12}{'programs':>10}{'interior':>10}{'time ratio':>12}"
    )
    for wall, rows in WALLS.items():
        plain = solved(rows, None, CRUSHING["biaxial"])
        runs = {(None, "none"): plain}
        runs |= {(fc, name): solved(rows, fc, settings) for fc in (20, 10) for name, settings in CRUSHING.items()}
        for (fc, crushing), r in runs.items():
            ratio = float(r.history.solver_time.sum() / plain.history.solver_time.sum())
            # The dead-load program is solved too, but is not part of the history.
            numbers = f"{r.load_factor:12.6f}{r.n_iterations + 1:10d}{int(r.history.solver_iterations.sum()):10d}"
            print(f"{wall:<6}{fc or 'inf':>5}  {crushing:<12}{numbers}{ratio:12.2f}   {r.status}")


if __name__ == "__main__":
    main()
