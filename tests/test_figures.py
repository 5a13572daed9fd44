"""Figures show the numbers of the results, with units."""

import dataclasses
import subprocess
import sys
from collections import Counter
from io import BytesIO

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.quiver import Quiver
from mpl_toolkits.mplot3d.proj3d import proj_transform

import blockstruct as bs
from blockstruct import Q_
from blockstruct.views import figures
from blockstruct.views.figures.domain import stress_blocks
from blockstruct.views.report.pictures import nearest_to_crushing, pictures
from blockstruct.views.selection import application_points
from blockstruct.views.solids import Solids, triangles
from blockstruct.views.style import STATE_COLOURS, parts
from structures import SELF_WEIGHT, model_of, push, single_block, solve

mpl.use("Agg")


@pytest.fixture(autouse=True)
def _no_figure_is_left_open():
    yield
    plt.close("all")


def axes(look: str = "y"):
    return Figure().add_subplot(projection="3d" if look == "3d" else None)


@pytest.fixture(scope="module")
def rocking():
    """A block 0.4 × 1 × 0.8 m that rocks about its edge at x = 0.4 m."""
    blocks, joint = single_block(0.4, 0.8)
    model = model_of(blocks, joint)
    return model, solve(model, push(1, 0, 0))


@pytest.fixture(scope="module")
def wall(small_analysis):
    return small_analysis.model, small_analysis["push nonassociative"]


@pytest.mark.parametrize("look", ["x", "y", "z", "3d"])
@pytest.mark.parametrize("draw", [figures.structure, figures.mechanism, figures.forces])
def test_every_figure_draws_on_the_axes_it_is_given_in_metres(wall, draw, look):
    given = axes(look)
    assert draw(*wall, look=look, ax=given) is given
    labels = [getattr(given, f"get_{c}label")() for c in ("x", "y", "z")[: 3 if look == "3d" else 2]]
    assert all(label.endswith("[m]") for label in labels)
    given.figure.savefig(BytesIO(), dpi=30)


@pytest.mark.parametrize("size", [(0.5, 0.5, 4.0), (8.0, 0.3, 0.5), (3.0, 3.0, 3.0), (2.0, 2.0, 0.1)])
def test_nothing_is_cut_off_in_space(size):
    stone = bs.Material("stone", "20 kN/m^3")
    foot = bs.Block.box("foot", Q_([0, 0, -0.1], "m"), Q_([*size[:2], 0.1], "m"), stone, fixed=True)
    blocks = [foot, bs.Block.box("block", Q_([0, 0, 0], "m"), Q_(size, "m"), stone)]
    ax = figures.structure(model_of(blocks, bs.JointMaterial("joint", 0.65)), look="3d", ax=axes("3d"))
    ax.figure.draw_without_rendering()
    points = np.concatenate([b.shape.vertices for b in blocks])
    x, y, _ = proj_transform(*points.T, ax.get_proj())
    inside = ax.patch.get_window_extent().padded(1)
    assert all(inside.contains(*pixel) for pixel in ax.transData.transform(np.column_stack([x, y])))
    # It fills them, too.
    assert max(np.ptp(x), np.ptp(y)) > 0.5 * ax.viewLim.width


def test_states_have_their_colours(wall):
    model, result = wall
    ax = figures.structure(model, result, ax=axes())
    drawn = Counter()
    for collection in ax.collections:
        if collection.get_facecolor().size == 0:
            drawn[to_rgba(collection.get_edgecolor()[0])] += len(collection.get_paths())
    states = result.states.isel(iteration=-1).to_numpy().tolist()
    expected = Counter(to_rgba(STATE_COLOURS[part]) for state in states for part in parts(state))
    assert drawn == expected
    assert len(expected) > 1
    assert {t.get_text() for t in ax.get_legend().get_texts()} == {part for state in states for part in parts(state)}


def test_an_elevation_shows_the_faces_that_look_at_the_reader(wall):
    model, _ = wall
    ax = figures.structure(model, ax=axes())
    (faces,) = [c for c in ax.collections if isinstance(c, PolyCollection)]
    assert len(faces.get_paths()) == len(model.blocks)


def test_utilisation_is_drawn_on_a_scale_from_zero_to_one(wall):
    model, result = wall
    ax = figures.structure(model, result, colour="sliding", ax=axes())
    drawn = ax.collections[-1]
    expected = bs.utilisation(result.history)["sliding"].isel(iteration=-1).to_numpy()
    np.testing.assert_allclose(drawn.get_array(), expected[np.isfinite(expected)])
    assert drawn.get_clim() == (0, 1)


def test_the_mechanism_is_drawn_to_its_amplitude(rocking):
    model, result = rocking
    ax = figures.mechanism(model, result, amplitude="10 cm", ax=axes())
    moved = np.concatenate([p.vertices[:4] for p in ax.collections[-1].get_paths()])
    # The centroid is √(0.2² + 0.4²) m from the edge it turns about: the turn is 0.1 m over that.
    turn = 0.1 / np.hypot(0.2, 0.4)
    for corner in ([0.4, 0.0], [0.4 + 0.8 * turn, 0.8], [0.0, 0.4 * turn], [0.8 * turn, 0.8 + 0.4 * turn]):
        assert np.abs(moved - corner).sum(axis=1).min() == pytest.approx(0, abs=1e-6)


def test_resultants_act_where_the_thrust_passes(rocking):
    model, result = rocking
    ax = figures.forces(model, result, ax=axes())
    (arrows,) = [c for c in ax.collections if isinstance(c, Quiver)]
    np.testing.assert_allclose(arrows.get_offsets(), [[0.4, 0]], atol=1e-6)
    # α W sideways and W upwards: α = 1/2.
    assert arrows.U[0] / arrows.V[0] == pytest.approx(-0.5, rel=1e-6)
    assert ax.get_title() == f"longest arrow {np.hypot(0.5, 1) * 0.4 * 0.8 * 20:.3g} kN"


def test_the_line_of_thrust_joins_the_two_pressed_interfaces_of_a_block():
    stone, joint = bs.Material("stone", "20 kN/m^3"), bs.JointMaterial("joint", 0.65)
    boxes = [("ground", -0.5, True), ("lower", 0.0, False), ("upper", 0.5, False)]
    blocks = [
        bs.Block.box(name, Q_([0, 0, z], "m"), Q_([0.4, 1, 0.5], "m"), stone, fixed=fixed) for name, z, fixed in boxes
    ]
    model = model_of(blocks, joint)
    result = solve(model, push(1, 0, 0))
    ax = figures.forces(model, result, ax=axes())
    (segment,) = ax.collections[-1].get_segments()
    # At α = 0.4 the thrust leaves the base at its edge, x = 0.4, and the upper joint below the upper centroid.
    np.testing.assert_allclose(segment[np.argsort(segment[:, 1])], [[0.4, 0], [0.3, 0.5]], atol=1e-6)


def test_no_thrust_passes_through_a_support():
    stone, joint = bs.Material("stone", "20 kN/m^3"), bs.JointMaterial("joint", 0.65)
    ground = bs.Block.box("ground", Q_([0, 0, -1], "m"), Q_([3, 1, 1], "m"), stone, fixed=True)
    towers = [bs.Block.box(f"at {x}", Q_([x, 0, 0], "m"), Q_([1, 1, 1], "m"), stone) for x in (0, 2)]
    model = model_of([ground, *towers], joint)
    ax = figures.forces(model, solve(model, push(1, 0, 0)), ax=axes())
    assert not [c for c in ax.collections if isinstance(c, LineCollection)]


def with_rounding(result, points):
    """The result, with forces at some contact points that are a hundred-thousandth of their units."""
    history = result.history.copy(deep=True)
    rounding = history.unit_of_force.to_numpy()[points, None] * [1e-5, 0, 0]
    history["contact_force"].transpose("iteration", "contact_point", "component")[-1, points] = rounding
    return dataclasses.replace(result, history=history)


def test_forces_that_are_rounding_are_not_drawn(wall):
    model, result = wall
    still = with_rounding(result, slice(None))
    for at in ("interfaces", "contact points"):
        with pytest.raises(bs.ModelError, match="no forces in iteration"):
            figures.forces(model, still, at=at, ax=axes())
    assert not [p for p in pictures(model, still) if "Resultants" in p.caption]


def test_the_line_of_thrust_leaves_out_joints_whose_force_is_rounding(wall):
    _, result = wall
    point, _ = application_points(result, -1)
    pressed = np.isfinite(point).all(axis=1)
    points = np.flatnonzero(result.history.interface_of_contact_point == np.flatnonzero(pressed)[0])
    fewer, _ = application_points(with_rounding(result, points), -1)
    assert np.isfinite(fewer).all(axis=1).sum() == pressed.sum() - 1


def test_convergence_draws_every_load_factor(wall):
    _, result = wall
    ax = figures.convergence(result, ax=axes())
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), result.history.load_factor)
    markers = sum(len(line.get_xdata()) for line in ax.lines[1:])
    assert markers == result.n_iterations
    ax = figures.certificate(result, ax=axes())
    assert [len(line.get_ydata()) for line in ax.lines] == [result.n_iterations] * 4
    assert ax.get_yscale() == "log"


@pytest.mark.parametrize(("about", "depth"), [("s", 1.0), ("t", 0.4)])
def test_crushing_domain_of_a_rectangle_is_the_parabola(about, depth):
    blocks, _ = single_block(0.4, 0.8)
    strength = 0.2e6
    joint = bs.JointMaterial("weak", 0.65, compressive_strength=Q_(strength, "Pa"))
    model = model_of(blocks, joint)
    result = solve(model, push(1, 0, 0))
    name = model.interfaces[0].name
    frame = result.history.interface_frame.isel(interface=0)
    # s is horizontal but either way round: which extent lies across `about` follows from the frame.
    across = frame.sel(component="t" if about == "s" else "s").to_numpy()
    depth = float(np.abs(across) @ [0.4, 1.0, 0.0])
    ax = figures.crushing_domain(model, result, name, about=about, ax=axes())
    outline = ax.patches[0].get_path().vertices * [1e3, 1e3]
    F = strength * 0.4
    N, M = outline.T
    np.testing.assert_allclose(np.abs(M), N * depth / 2 * (1 - N / F), atol=1e-6 * F)
    (n,), (m,) = ax.lines[-1].get_data()
    last = result.resultants.isel(iteration=-1, interface=0)
    assert n * 1e3 == pytest.approx(float(last.force.sel(component="n")))
    assert m * 1e3 == pytest.approx(float(last.moment.sel(component=about)))
    assert ax.get_xlabel() == "N [kN]"


def crushing(direction, *, interaction="uniaxial", **strengths):
    """A block 0.4 × 1 × 0.8 m on a weak joint, pushed until it crushes."""
    blocks, joint = single_block(0.4, 0.8)
    model = model_of(blocks, joint.varied(compressive_strength=Q_(0.2, "MPa"), **strengths))
    return model, solve(model, push(*direction), crushing_interaction=interaction)


#: A joint that bears tension is checked by cells.
TENSION = {"cohesion": Q_(1, "kPa"), "tensile_strength": Q_(1, "kPa")}


@pytest.mark.parametrize(
    ("direction", "more", "text"),
    [
        ((1, 0, 0), {}, "utilisation of crushing 1.00"),
        ((1, 0.5, 0), {}, "utilisation of crushing 1.00\n589 N·m about s"),
        ((1, 0.5, 0), {"interaction": "biaxial"}, " N·m about s reduces the domain"),
        ((1, 0.5, 0), TENSION, " N·m about s reduces the domain"),
    ],
)
def test_the_domain_says_what_its_point_does_not_show(direction, more, text):
    structure = crushing(direction, **more)
    title = figures.crushing_domain(*structure, "ground|block", about="t", ax=axes()).get_title()
    assert title.startswith("ground|block\nutilisation of crushing ")
    assert title.endswith(text)


def test_the_report_shows_the_axis_about_which_a_joint_crushes():
    model, result = crushing((1, 1.5, 0))
    moment = abs(result.resultants.moment.isel(iteration=-1).sel(interface="ground|block"))
    assert moment.sel(component="s") > moment.sel(component="t")
    # Across the thinner side the smaller moment is nearer to the strength.
    assert nearest_to_crushing(model, result) == ("ground|block", "t")


def test_stress_blocks_of_a_triangle():
    # Area above y: (1 − y/h)² of the whole; its centroid at y + (h − y)/3, from the centroid of the triangle at h/3.
    h = 0.9
    N, M = stress_blocks(np.array([[0, -h / 3], [1, -h / 3], [0.5, 2 * h / 3]]), 2.0)
    share = 1 - np.linspace(0, 1, len(N) // 2)
    np.testing.assert_allclose(N[: len(share)], 2 * h / 2 * share**2, atol=1e-12)
    np.testing.assert_allclose(M[: len(share)], 2 * h / 2 * share**2 * (1 - share) * 2 * h / 3, atol=1e-12)


def test_curves_have_readable_units_and_show_the_unlimited_strength():
    strength = xr.DataArray([4e6, np.inf, 1e6], dims="compressive_strength", attrs={"units": "pascal"})
    sweep = xr.Dataset(
        {"load_factor": ("compressive_strength", [0.3, 0.35, 0.2])}, coords={"compressive_strength": strength}
    )
    ax = figures.curve(sweep, ax=axes())
    np.testing.assert_allclose(ax.lines[0].get_xydata(), [[1, 0.2], [4, 0.3]])
    assert ax.lines[1].get_ydata()[0] == 0.35
    assert ax.get_xlabel() == "compressive strength f_c [MPa]"
    friction = xr.DataArray([0.2, 0.3], dims="friction_coefficient", coords={"friction_coefficient": [0.5, 0.7]})
    assert figures.curve(friction, ax=axes()).get_xlabel() == "friction coefficient μ [-]"


@pytest.mark.parametrize("load_factor", [np.nan, np.inf])
def test_a_curve_without_load_factors_is_empty(load_factor):
    coords = {"friction_coefficient": [0.5, 0.7]}
    ax = figures.curve(xr.DataArray([load_factor] * 2, dims="friction_coefficient", coords=coords), ax=axes())
    ax.figure.savefig(BytesIO())
    assert ax.get_ylim()[0] == 0


def test_a_single_iteration_has_one_tick(rocking):
    _, result = rocking
    assert result.n_iterations == 1
    for draw in (figures.convergence, figures.certificate):
        ticks = draw(result, ax=axes()).get_xticks()
        assert ticks[np.abs(ticks) <= 0.5].tolist() == [0]


def test_triangles_cover_a_polygon_that_is_not_convex():
    ell = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 2, 0], [0, 2, 0]], dtype=float)
    for shift in range(6):
        points = np.roll(ell, shift, axis=0)
        corners, _ = triangles(points, [np.arange(6)])
        a, b, c = points[corners.T]
        areas = np.cross(b - a, c - a)[:, 2] / 2
        assert areas.min() > 0
        assert areas.sum() == pytest.approx(3)


def test_edges_of_a_box_are_twelve(wall):
    model, _ = wall
    assert len(Solids.of(model).edges) == 12 * len(model.blocks)


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda m, r: figures.structure(m, r, iteration=99), bs.UnknownNameError, "no iteration 99; it has 0 to"),
        (lambda m, r: figures.forces(m, r, iteration="3"), bs.ModelError, "iteration '3' is no integer; give 0 to"),
        (lambda m, r: figures.mechanism(m, r, iteration=1.5), bs.ModelError, "iteration 1.5 is no integer"),
        (lambda m, r: figures.structure(m, r, look="front"), bs.ModelError, "give 'x' or 'y'"),
        (lambda m, r: figures.structure(m, r, look="3d", ax=axes()), bs.ModelError, "projection='3d'"),
        (lambda m, r: figures.structure(m, r, colour="red"), bs.ModelError, "'state', 'sliding' or 'crushing'"),
        (lambda m, r: figures.mechanism(m, r, amplitude=0.1), bs.UnitError, "has no unit"),
        (lambda m, r: figures.mechanism(m, r, amplitude="3 kN"), bs.DimensionError, "does not fit"),
        (lambda m, r: figures.forces(m, r, at="blocks"), bs.ModelError, "'interfaces' or 'contact points'"),
        (lambda m, r: figures.crushing_domain(m, r, "a|b"), bs.UnknownNameError, "no interface 'a|b'; it has base|1.1"),
        (lambda m, r: figures.crushing_domain(m, r, "base|1.1"), bs.ModelError, "no compressive strength"),
        (lambda m, r: figures.crushing_domain(m, r, "base|1.1", about="n"), bs.ModelError, "give 's' or 't'"),
        (lambda m, r: figures.curve(r.history.block_velocity), bs.ModelError, "over one coordinate"),
    ],
)
def test_bad_input_is_told_with_the_remedy(wall, call, error, words):
    with pytest.raises(error) as raised:
        call(*wall)
    assert words in str(raised.value)


def test_a_result_of_another_model_is_refused(wall, rocking):
    with pytest.raises(bs.ModelError, match="has other blocks; give the model of the analysis"):
        figures.structure(wall[0], rocking[1])


def test_a_case_without_iterations_is_refused(small_model):
    def stop(event):
        raise KeyboardInterrupt

    case = bs.LimitCase("case", SELF_WEIGHT, push(1, 0, 0))
    result = bs.AnalysisManager(small_model, listeners=[stop]).run([case])["case"]
    for draw in (figures.structure, figures.mechanism, figures.forces):
        with pytest.raises(bs.ModelError, match="no iteration to show, interrupted"):
            draw(small_model, result)
    with pytest.raises(bs.ModelError, match="no iteration to show"):
        figures.convergence(result)


def test_an_unbounded_case_has_no_mechanism_to_draw(small_model):
    result = solve(small_model, push(0, 0, -1))
    with pytest.raises(bs.ModelError, match="no mechanism in iteration 0, unbounded"):
        figures.mechanism(small_model, result, ax=axes())
    with pytest.raises(bs.ModelError, match="no forces in iteration 0"):
        figures.forces(small_model, result, ax=axes())
    assert figures.structure(small_model, result, ax=axes()).get_legend().get_texts()[0].get_text() == "unknown"


@pytest.mark.parametrize(
    ("module", "package", "extra"),
    [
        ("figures", "matplotlib", "viz"),
        ("page", "plotly", "viz"),
        ("paraview", "pyvista", "viz"),
        ("report", "jinja2", "report"),
    ],
)
def test_a_missing_extra_says_what_to_install(module, package, extra):
    code = f"import sys; sys.modules['{package}'] = None; import blockstruct.views.{module}"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert f'{package} is not installed; it comes with: pip install "blockstruct[{extra}]"' in run.stderr


def test_the_core_imports_no_extra():
    extras = {f"blockstruct.views.{name}" for name in ("figures", "page", "paraview", "report")}
    code = (
        f"import sys, blockstruct.cli; print({extras | {'matplotlib', 'plotly', 'pyvista', 'vtk'}} & set(sys.modules))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert run.stdout.strip() == "set()"
