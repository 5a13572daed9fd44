"""Numbers of a result or a curve that contradict each other."""

import re
from dataclasses import replace

import attrs
import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from structures import (
    SELF_WEIGHT,
    beam_on_ledges,
    block_on_a_bar,
    box,
    divided,
    edited,
    model_of,
    push,
    settings_of,
    single_block,
    slipping_units,
)

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


@pytest.fixture(scope="module")
def tied():
    """A block on a bar that yields and breaks, and turns over."""
    model = block_on_a_bar()
    return bs.run(model, bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=("block", (1, 0, 0)), steps=6))


@pytest.fixture(scope="module")
def wall():
    """Ten units with rounded corners, which slip and rock."""
    model = slipping_units()
    control = (model.blocks[-1].name, (1, 0, 0))
    case = bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=control, steps=6, corner_rounding="5 mm")
    return bs.run(model, case)


@pytest.fixture(scope="module")
def stored(tied, wall, tmp_path_factory):
    """Files of them, and of a block with the report of its detection, of which tests change copies."""
    blocks, joint = tied.model.blocks, tied.model.interfaces[0].joint_material
    detected = bs.Model("detected", blocks, bs.detect_interfaces(blocks, joint_material=joint))
    case = bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0))
    analyses = {"tied": tied, "wall": wall, "detected": bs.run(detected, case)}
    folder = tmp_path_factory.mktemp("stored")
    return {name: bs.save_analysis(analysis, folder / f"{name}.h5") for name, analysis in analyses.items()}


def changed(analysis, name, at, by=1.01):
    """An analysis whose curve has one value times a factor."""
    curve = analysis["push"].capacity.copy(deep=True)
    values = curve[name].to_numpy().copy()
    values[at] *= by
    stored = curve[name].dims, values, curve[name].attrs
    curve = curve.assign_coords({name: stored}) if name in curve.coords else curve.assign({name: stored})
    return analysis.replaced(results={"push": replace(analysis["push"], capacity=curve)})


def largest(analysis, name, state):
    """Where the largest value of a state is."""
    curve = analysis["push"].capacity
    values = np.abs(curve[name].to_numpy())
    if "contact" in curve[name].dims:
        values = np.where((curve["step_of_contact"] == state).to_numpy()[:, None], values, -1.0)
    else:
        values = np.where((np.arange(len(values)) == state).reshape(-1, *[1] * (values.ndim - 1)), values, -1.0)
    return np.unravel_index(values.argmax(), values.shape)


LIES_OF_CURVES = {
    "load_factor": "equilibrium residual",
    "displacement": "displacement is",
    "position": "off the way that the motion before leads",
    "rotation": "off the way that the motion before leads",
    "velocity": "W of variable load",
    "angular_velocity": "off the way that the motion before leads",
    "force_of_contact": "equilibrium residual",
    "normal_of_contact": "the normal of one of its contacts",
    "dissipation": "dissipation is",
    "tie_force": "equilibrium residual",
    "tie_elongation": "tie elongation is",
}


@pytest.mark.parametrize("name", LIES_OF_CURVES)
def test_one_hundredth_is_found(tied, wall, name):
    # The bar has not broken yet; units that slide hardly turn.
    alone = name.startswith("tie_") or name in ("rotation", "angular_velocity")
    for analysis, state in ((tied, 13),) if alone else ((tied, 13), (wall, 13)):
        found = [what for _, what in bs.results.contradictions(changed(analysis, name, largest(analysis, name, state)))]
        at = state + 1 if name == "angular_velocity" else state
        words = LIES_OF_CURVES[name]
        assert any(what.startswith(f"state {at} ") and words in what for what in found), found


@pytest.mark.parametrize(
    ("name", "state", "by", "words"),
    [
        ("position", 0, 1.01, "off its place in the model"),
        ("load_factor", 4, 0.9, "equilibrium residual"),
        ("energy_error", None, 2.0, "energy error"),
        ("equilibrium_residual", 2, np.nan, "equilibrium residual is nan"),
    ],
)
def test_other_lies(wall, name, state, by, words):
    """In a state, or in the one with the largest value."""
    state = int(wall["push"].capacity[name].to_numpy().argmax()) if state is None else state
    found = bs.results.contradictions(changed(wall, name, largest(wall, name, state), by))
    assert any(what.startswith(f"state {state} ") and words in what for _, what in found), found


def test_forces_beyond_friction_are_found(wall):
    """And joints that are pulled."""
    curve = wall["push"].capacity.copy(deep=True)
    curve["force_of_contact"][0] *= -1
    found = bs.results.contradictions(wall.replaced(results={"push": replace(wall["push"], capacity=curve)}))
    assert any("yield excess is" in what for _, what in found)


@pytest.mark.parametrize("structure", ["tied", "wall", "detected"])
def test_validate_accepts_honest_results(stored, done, structure):
    done("validate", stored[structure])


def test_a_curve_without_its_pushover_is_refused(stored, tmp_path, call):
    path = tmp_path / "x.h5"
    with edited(stored["tied"], path) as file:
        del file["cases/push"].attrs["pushover"]
    with pytest.raises(bs.errors.FormatError, match="there is a capacity curve, but no attribute pushover"):
        bs.open_analysis(path)
    with edited(stored["wall"], path) as file:
        file["cases/push/capacity/load_factor"][3] *= 1.01
    code, out, _ = call("validate", path)
    assert (code, "case 'push': state 3 of the capacity curve: its" in out) == (4, True)


def test_validate_finds_another_reaction(tmp_path, call, done):
    path = tmp_path / "beam.h5"
    bs.run(beam_on_ledges(), bs.SettlementCase("down", SELF_WEIGHT, "left", "-z"), path)
    done("validate", path)
    for place, words in (
        ("cases/down/reaction", "/cases/down/reaction: the reaction is"),
        ("cases/down/history/reaction", "case 'down': the reaction of iteration"),
    ):
        with edited(path, tmp_path / "other.h5") as file:
            reaction = file[place]
            reaction[-1 if reaction.shape else ()] *= 1.01
        code, out, _ = call("validate", tmp_path / "other.h5")
        assert (code, words in out) == (4, True)


REDUNDANT = [
    ("detected", "model/floating", 0, 1, "/model/floating: that of '.*' is 1, and 0 by the rest"),
    ("detected", "model/plus_of_contact", 1, 1, "that of contact 1 of .ground. and .post. is .ground.block."),
    ("detected", "model/area_of_contact", 0, -1.0, "/model/area_of_contact: there is a negative number"),
    ("detected", "model/volume", 1, 99.0, "/model/volume: that of .* is 99, and .* by the rest"),
    ("detected", "model/centroid", 1, np.nan, "/model/centroid: that of .* is nan, and .* by the rest"),
    ("detected", "model/area", 0, 99.0, "/model/area: that of .* is 99, and .* by the rest"),
    ("wall", "cases/push/history/iteration", -1, 0, "/history/iteration: the numbers are not 0, 1, …"),
    ("wall", "cases/push/history/load_factor", 1, 9.0, "iteration 1 miss equilibrium by"),
    ("wall", "cases/push/history/interface_corner_position", (0, 0), 50.0, "interface_corner_position of the history"),
    ("wall", "cases/push/capacity/holds", 2, 0, "state 2 of the .*: its certificate does not hold, by its forces"),
    ("wall", "cases/push/capacity/flow_rule_gap", 2, 9.0, "state 2 .*: its (flow rule gap|interpenetration) is"),
    ("wall", "cases/push/capacity/flow_rule_gap", -1, np.nan, "state .*: its flow rule gap is nan"),
    ("wall", "cases/push/capacity/falls", 1, -1, "/capacity/falls: there is other than 0 and 1"),
    ("wall", "cases/push/capacity/interpenetration", 2, 0.2, "state 2 .*: its (flow rule gap|interpenetration) is"),
    ("tied", "cases/push/capacity/tie_elongation_limit", 0, 3.0, "tie_elongation_limit of tie 'bar' .* is 3 m"),
    ("tied", "cases/push/capacity/tie_break_displacement", 0, 5.0, "tie_break_displacement of tie 'bar' .* is 5 m"),
]  # fmt: skip


@pytest.mark.parametrize(("structure", "place", "at", "value", "words"), REDUNDANT, ids=[row[1] for row in REDUNDANT])
def test_validate_compares_derived_variables(stored, tmp_path, call, structure, place, at, value, words):
    with edited(stored[structure], tmp_path / "x.h5") as file:
        assert not np.array_equal(file[place][at], value)
        file[place][at] = value
    code, out, _ = call("validate", tmp_path / "x.h5")
    assert code == 4
    assert re.search(words, out), out


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
