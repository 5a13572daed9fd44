"""What is stored is not believed: certificates are recomputed from the model and the final state."""

from dataclasses import replace

import attrs
import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from structures import SELF_WEIGHT, box, divided, model_of, push, settings_of, single_block

NAME = "push nonassociative"


def tampered(analysis, name=NAME, *, history=None, **changes):
    """An analysis with one result changed; ``history`` is called with a copy of its history."""
    result = analysis[name]
    if history is not None:
        changed = result.history.copy(deep=True)
        history(changed)
        changes["history"] = changed
    facts = {key: changes.pop(key) for key in ("status", "load_factor") if key in changes}
    outcome = replace(result.outcome, **facts)
    return analysis.replaced(results={**analysis, name: replace(result, outcome=outcome, **changes)})


def last(variable, value):
    """Change the last iteration of a variable: to a value, or by a factor if it is a text."""

    def change(history):
        values = history[variable].to_numpy()
        values[-1] = values[-1] * float(value) if isinstance(value, str) else value

    return change


def moving(value):
    """Change the motion of the blocks in the last iteration."""

    def change(history):
        for variable in ("block_velocity", "block_angular_velocity"):
            last(variable, value)(history)

    return change


def times(variable, factor, at=slice(None)):
    """Change a variable of the history by a factor, everywhere or at one place."""
    return lambda _: {"history": lambda history: history[variable].to_numpy()[at].__imul__(factor)}


def certificate(analysis, **changes):
    return {"certificate": replace(analysis[NAME].certificate, **changes)}


LIES = {
    "a load factor times ten": (lambda a: {"load_factor": 10 * a[NAME].load_factor}, "load factor is"),
    "a load factor times ten in the history too": (
        lambda a: {"load_factor": 10 * a[NAME].load_factor, "history": last("load_factor", "10")},
        "equilibrium residual",
    ),
    "final forces all zero": (lambda a: {"history": last("contact_force", 0.0)}, "equilibrium residual"),
    "yield excess of a billion": (lambda a: certificate(a, yield_excess=1e9), "yield excess of the certificate"),
    "yield excess in the history": (lambda a: {"history": last("yield_excess", 1e9)}, "yield excess of the history"),
    "a residual of nan": (lambda a: certificate(a, equilibrium_residual=np.nan), "residual of the certificate is nan"),
    "a gap below zero": (lambda a: certificate(a, flow_rule_gap=-1.0), "flow rule gap"),
    "a certificate that does not hold": (lambda a: certificate(a, holds=False), "the stored certificate"),
    "no certificate": (lambda _: {"certificate": None}, "no certificate"),
    "velocities all zero": (lambda _: {"history": moving(0.0)}, "does not hold"),
    "other relative velocities": (lambda a: {"history": last("relative_velocity", "1.1")}, "relative velocities"),
    "other relative velocities before": (times("relative_velocity", 1.1, at=1), "relative velocities of iteration 1"),
    "another mechanism before": (times("block_velocity", 1.1, at=1), "relative velocities of iteration 1"),
    "velocities turned round": (lambda _: {"history": moving("-1")}, "flow rule gap"),
    "unbounded": (lambda _: {"status": bs.Status.UNBOUNDED}, "unbounded, but its load factor"),
    "unbounded and infinite": (
        lambda _: {"status": bs.Status.UNBOUNDED, "load_factor": np.inf, "certificate": None}, "in the last iteration",
    ),
    "not converged": (lambda _: {"status": bs.Status.NOT_CONVERGED}, "not converged, but its load factor"),
    "unstable": (lambda _: {"status": bs.Status.UNSTABLE, "load_factor": np.nan}, "not a dead-load program"),
    "a negative load factor": (lambda _: {"load_factor": -0.5}, "converged, but its load factor is -0.5"),
    "another friction": (times("friction_coefficient", 2.0), "friction_coefficient of the history"),
    "contacts elsewhere": (times("contact_point_position", 2.0), "contact_point_position of the history"),
    "other loads": (
        lambda a: {"case": attrs.evolve(a[NAME].case, variable=bs.LoadPattern("push", [bs.BodyForce("+x", 2)]))},
        "equilibrium residual",
    ),
}  # fmt: skip


@pytest.mark.parametrize("lie", LIES)
def test_a_result_that_contradicts_its_state_is_found(small_analysis, tmp_path, lie):
    changes, words = LIES[lie]
    lying = tampered(small_analysis, **changes(small_analysis))
    found = bs.results.contradictions(lying)
    assert {name for name, _ in found} == {NAME}
    assert any(words in what for _, what in found), found
    with pytest.raises(bs.errors.CertificateError, match="push nonassociative"):
        bs.save_analysis(lying, tmp_path / "lie.h5")
    assert not list(tmp_path.iterdir())


def test_changed_cells_are_found():
    """A wider lever, and the strength of the middle at the edges: neither is a division of the joint."""

    def wider(history):
        positions, centre = history.contact_point_position.to_numpy(), history.interface_position.to_numpy()
        positions += 0.05 * (positions - centre)

    def stronger(history):
        strength = history.cell_strength.to_numpy()
        strength[:] = np.sort(strength)

    blocks, _ = single_block(0.5, 1.0)
    model = divided(model_of(blocks, bs.JointMaterial("soft", 0.9, compressive_strength="100 kPa")))
    analysis = bs.AnalysisManager(model).run([bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0))])
    for lie, name in ((wider, "contact_point_position"), (stronger, "cell_strength")):
        found = bs.results.contradictions(tampered(analysis, "push", history=lie))
        assert any(case == "push" and what.startswith(f"{name} of the history") for case, what in found)


FEW_PROGRAMS = {"procedure": "fictitious", "max_programs": 4, "gap_tolerance": 0.0}


def falling_block():
    blocks = [box("ground", [0, 0, -1], [0.4, 1, 1], fixed=True), box("block", [0, 0, 0])]
    return model_of(blocks, bs.JointMaterial("joint", 0.65))


@pytest.mark.parametrize("flow", list(bs.Flow))
@pytest.mark.parametrize(
    ("model", "direction", "status", "settings"),
    [
        (model_of(*single_block(0.5, 1.0)), (1, 0, 0), "converged", {}),
        (model_of(*single_block(2.0, 1.0, mu=0.3)), (0.6, 0.8, 0), "converged", {}),
        (model_of(*single_block(2.0, 1.0, mu=0.0)), (1, 0, 0), "converged", {}),
        (model_of(*single_block(2.0, 1.0)), (0, 0, -1), "unbounded", {}),
        (falling_block(), (1, 0, 0), "unstable_under_dead_load", {}),
        (model_of(*single_block(0.5, 1.0)), (1, 0, 0), "not_converged", FEW_PROGRAMS),
    ],
)
def test_honest_results_of_every_status_pass(model, direction, status, settings, flow, tmp_path):
    manager = bs.AnalysisManager(model, tmp_path / "a.h5", settings=settings_of(**settings))
    analysis = manager.run([bs.LimitCase("case", SELF_WEIGHT, push(*direction), flow)])
    assert analysis["case"].status == status
    assert bs.results.contradictions(analysis) == []
    stored = bs.open_analysis(tmp_path / "a.h5")
    assert bs.results.contradictions(stored) == []
    again = bs.results.recomputed_certificate(stored, "case")
    assert (again is None) == (status == "unbounded")


@pytest.mark.parametrize("crushing", ["conic", "linearised"])
def test_crushing_is_recomputed(crushing):
    joint = bs.JointMaterial("mortar", 0.65, compressive_strength="0.2 MPa", dilatancy_angle="5 deg")
    model = model_of(single_block(0.5, 1.0)[0], joint)
    case = bs.LimitCase("case", SELF_WEIGHT, push(1, 0, 0))
    analysis = bs.AnalysisManager(model, settings=bs.ProcedureSettings(crushing=crushing)).run([case])
    assert analysis["case"].status == "converged"
    assert bs.results.contradictions(analysis) == []
    again = bs.results.recomputed_certificate(analysis, "case")
    assert again.holds
    assert again.flow_rule_gap == pytest.approx(analysis["case"].certificate.flow_rule_gap, rel=1e-6, abs=1e-12)


def test_forces_alone_make_a_difference(small_analysis):
    lying = tampered(small_analysis, history=last("contact_force", "1.1"))
    found = bs.results.compare(small_analysis, lying)
    assert found.cases.loc[NAME, "force_difference"] == pytest.approx(0.1 / 1.1)
    assert not found.agrees()
    assert found.agrees(state_rtol=np.inf)


def test_another_model_is_found(small_analysis, small_cases):
    other = bs.AnalysisManager(model_of(*single_block(0.5, 1.0))).run(
        [attrs.evolve(case, variable=push(1, 0, 0)) for case in small_cases]
    )
    mixed = small_analysis.replaced(results=dict(other))
    assert {name for name, _ in bs.results.contradictions(mixed)} == set(other)


RESPONSE_LIES = {
    "velocity": "the kinetic energy is not that of its velocities",
    "angular_velocity": "the kinetic energy is not that of its velocities",
    "kinetic_energy": "its energies do not balance",
    "dissipated_energy": "its energies do not balance",
    "peak_displacement": "displaced by more than its peak",
}


def test_lies_of_a_response_are_found():
    model = model_of(*single_block(0.3, 1.5))
    t = np.arange(0, 1, 0.01)
    case = bs.RecordCase("r", SELF_WEIGHT, Q_(0.4 * np.sin(2 * np.pi * t), "g_0"), "10 ms", "+x", interval="50 ms")
    analysis = bs.run(model, case)
    result = analysis["r"]
    assert result.status is bs.Status.COLLAPSES
    for name, words in RESPONSE_LIES.items():
        response = result.response.copy(deep=True)
        response[name][{"time": -2}] *= 0.9
        found = bs.results.contradictions(analysis.replaced(results={"r": result.changed(response=response)}))
        assert any(words in what for _, what in found), name
    stands = result.changed(outcome=replace(result.outcome, status=bs.Status.STANDS))
    (_, what), *_ = bs.results.contradictions(analysis.replaced(results={"r": stands}))
    assert what == "stands, but in the last state block has fallen"
