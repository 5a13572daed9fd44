"""Figures show the numbers of the results, with units."""

import dataclasses
import subprocess
import sys
from collections import Counter

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import LineCollection, PathCollection, PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure

import blockstruct as bs
from blockstruct import Q_
from blockstruct.views import figures
from blockstruct.views.figures.diagrams import stress_blocks
from blockstruct.views.figures.sheet import Drawing, _file_names
from blockstruct.views.solids import triangles
from blockstruct.views.style import ACCENT, AMPLITUDE, FORCE, STATE_COLOURS, parts
from refusals import refused
from structures import SELF_WEIGHT, box, model_of, push, single_block, solve, stopping
from studied import samples

mpl.use("Agg")

MODEL, UNKNOWN = bs.errors.ModelError, bs.errors.UnknownNameError


@pytest.fixture(autouse=True)
def _no_figure_is_left_open():
    yield
    plt.close("all")


def axes():
    return Figure().add_subplot()


def drawn(ax):
    """Faces and lines of the bodies on Axes, each as its path, edge colour and face colour, in the order of drawing."""
    (found,) = [c for c in ax.collections if isinstance(c, PathCollection) and len(c.get_facecolor())]
    paths, edges, fills = found.get_paths(), found.get_edgecolor(), found.get_facecolor()
    items = list(zip((p.vertices for p in paths), map(tuple, edges), map(tuple, fills), strict=True))
    return [i for i in items if len(i[0]) > 2], [i for i in items if len(i[0]) == 2]


def arrows(ax, colour):
    """Tails and tips (n, 2) of the arrows of a colour."""
    arrows = [c for c in ax.collections if isinstance(c, PolyCollection)]
    found = [c for c in arrows if tuple(c.get_facecolor()[0]) == to_rgba(colour)]
    shapes = np.array([p.vertices[:7] for c in found for p in c.get_paths()])
    return (shapes[:, 0] + shapes[:, 6]) / 2, shapes[:, 3]


@pytest.fixture(scope="module")
def rocking():
    """A block 0.4 × 1 × 0.8 m that rocks about its edge at x = 0.4 m."""
    return solve(model_of(*single_block(0.4, 0.8)), push(1, 0, 0))


@pytest.fixture(scope="module")
def wall(small_analysis):
    return small_analysis["push nonassociative"]


@pytest.mark.parametrize("look", ["x", "y", "z", "3d", (-30, 40), None])
@pytest.mark.parametrize("draw", [figures.structure, figures.mechanism, figures.forces])
def test_every_figure_draws_on_the_axes_it_is_given_with_lengths(wall, draw, look):
    given = axes()
    assert draw(wall, look=look, ax=given) is given
    # In space the axes are three arrows of a round length.
    labels = [given.get_xlabel(), given.get_ylabel()] if look in ("x", "y", "z", None) else ["[m]"]
    texts = [text.get_text() for text in given.texts]
    assert all(label.endswith("[m]") for label in labels)
    assert len(labels) == 2 or "0.1 m" in texts


@pytest.mark.parametrize("size", [(0.5, 0.5, 4.0), (8.0, 0.3, 0.5), (2.0, 2.0, 0.1)])
def test_nothing_is_cut_off_in_space(size):
    blocks = [box("foot", [0, 0, -0.1], [*size[:2], 0.1], fixed=True), box("block", [0, 0, 0], size)]
    result = solve(model_of(blocks, bs.JointMaterial("joint", 0.65)), push(1, 0, 0))
    for draw in (figures.structure, figures.mechanism, figures.forces):
        ax = draw(result, look="3d", ax=axes())
        ax.figure.draw_without_rendering()
        points = np.concatenate([p.vertices for c in ax.collections for p in c.get_paths()])
        low, high = np.transpose([ax.get_xlim(), ax.get_ylim()])
        assert (low < points).all()
        assert (points < high).all()
        # It fills them, too.
        assert max(np.ptp(points, axis=0) / (high - low)) > 0.85


def test_joints_on_the_surface_have_the_colour_of_their_state(wall):
    ax = figures.structure(wall, ax=axes())
    moving = [state for state in wall.states.isel(iteration=-1).to_numpy().tolist() if state != "sticking"]
    # The front edge of each joint, once for each of its parts; joints that stick are edges of blocks.
    expected = Counter(to_rgba(STATE_COLOURS[part]) for state in moving for part in parts(state))
    assert Counter(edge for _, edge, _ in drawn(ax)[1]) == expected
    assert {t.get_text() for t in ax.get_legend().get_texts()} == {s.replace(" + ", ", ") for s in moving}


def test_the_mechanism_is_drawn_to_its_amplitude(rocking):
    """The one given is that of the centroid that moves most; without one the farthest corner has its share."""
    faces, _ = drawn(figures.mechanism(rocking, amplitude="10 cm", look="y", ax=axes()))
    moved = np.concatenate([p[:4] for p, _, _ in faces])
    # The centroid is √(0.2² + 0.4²) m from the edge it turns about: the turn is 0.1 m over that.
    turn = 0.1 / np.hypot(0.2, 0.4)
    for corner in ([0.4, 0.0], [0.4 + 0.8 * turn, 0.8], [0.0, 0.4 * turn], [0.8 * turn, 0.8 + 0.4 * turn]):
        assert np.abs(moved - corner).sum(axis=1).min() == pytest.approx(0, abs=1e-6)
    ax = figures.mechanism(rocking, look="y", ax=axes())
    size = np.ptp([b.shape.vertices for b in rocking.model.blocks], (0, 1)).max()
    translation = AMPLITUDE * size * np.hypot(0.2, 0.4) / np.hypot(0.4, 0.8)
    assert ax.figure.axes[-1].get_ylabel().endswith(f"\nlargest translation drawn as {translation:.2g} m")


def test_the_push_is_an_arrow_with_the_load_factor(rocking):
    ax = figures.mechanism(rocking, look="y", ax=axes())
    (tail,), (tip,) = arrows(ax, FORCE)
    assert tip[1] == pytest.approx(tail[1]) == pytest.approx(0.4)
    # It points at the structure from the side that the push comes from.
    assert tail[0] < tip[0] < -1
    assert rocking.plot(look="y").get_xlabel() == "x [m]"
    with pytest.raises(bs.errors.ModelError, match="known are mechanism"):
        rocking.plot("bending")
    (text,) = ax.texts
    assert text.get_text() == "α = 0.5"
    ax.figure.draw_without_rendering()
    # Beside the structure and within the picture.
    extent = text.get_window_extent()
    assert ax.bbox.x0 <= extent.x0 < extent.x1 < ax.transData.transform((0, 0))[0]


def test_load_arrows_end_at_their_points(rocking):
    model = rocking.model
    dead = bs.LoadPattern("dead", [bs.SelfWeight(), bs.Weight("block", Q_([0.1, 0.5, 1.0], "m"), "4 kN")])
    result = solve(model, bs.LoadPattern("push", [bs.BodyForce("+x")]), dead=dead)
    ax = figures.loads(result, look="y", ax=axes())
    np.testing.assert_allclose(arrows(ax, ACCENT)[1], [[0.1, 1.0]], atol=1e-9)
    _, tips = arrows(ax, FORCE)
    # The block is pushed at its centroid, the roof at its own.
    np.testing.assert_allclose(tips[np.argsort(tips[:, 1])], [[0.2, 0.4], [0.1, 1.0]], atol=1e-9)
    assert [t.get_text() for t in ax.get_legend().get_texts()] == ["dead: 4 kN", "push: 10.4 kN × load factor"]
    load = bs.PointLoad("block", Q_([0, 0.5, 0.8], "m"), "[1, 0, 0] kN")
    ax = figures.mechanism(solve(model, bs.LoadPattern("one", [load])), look="y", ax=axes())
    np.testing.assert_allclose(arrows(ax, FORCE)[1], [[0, 0.8]], atol=1e-9)


def test_resultants_lie_on_the_thrust_line(rocking):
    ax = figures.forces(rocking, look="y", ax=axes())
    tails, tips = arrows(ax, FORCE)
    np.testing.assert_allclose(tails[0], [0.4, 0], atol=1e-6)
    # α W sideways and W upwards: α = 1/2.
    across, up = tips[0] - tails[0]
    assert across / up == pytest.approx(-0.5, rel=1e-6)
    # The key is an arrow of a round force on the same scale.
    size = np.hypot(0.5, 1) * 0.4 * 0.8 * 20
    assert [t.get_text() for t in ax.texts] == ["5 kN"]
    assert tips[1][0] - tails[1][0] == pytest.approx(5 / size * np.hypot(across, up))


def test_the_line_of_thrust_joins_the_two_pressed_interfaces_of_a_free_block():
    def thrust(blocks):
        result = solve(model_of(blocks, bs.JointMaterial("joint", 0.65)), push(1, 0, 0))
        collections = figures.forces(result, look="y", ax=axes()).collections
        return [segment for c in collections if isinstance(c, LineCollection) for segment in c.get_segments()]

    size = [0.4, 1, 0.5]
    lower, upper = box("lower", [0, 0, 0], size), box("upper", [0, 0, 0.5], size)
    (segment,) = thrust([box("ground", [0, 0, -0.5], size, fixed=True), lower, upper])
    # At α = 0.4 the thrust leaves the base at its edge, x = 0.4, and the upper joint below the upper centroid.
    np.testing.assert_allclose(segment[np.argsort(segment[:, 1])], [[0.4, 0], [0.3, 0.5]], atol=1e-6)
    towers = [box(f"at {x}", [x, 0, 0], [1, 1, 1]) for x in (0, 2)]
    assert thrust([box("ground", [0, 0, -1], [3, 1, 1], fixed=True), *towers]) == []


def test_forces_that_are_rounding_are_not_drawn(wall):
    """All forces are a hundred-thousandth of their units."""
    history = wall.history.copy(deep=True)
    rounding = history.contact_force_unit.to_numpy()[:, None] * [1e-5, 0, 0]
    history["contact_force"].transpose("iteration", "contact_point", "component")[-1] = rounding
    still = dataclasses.replace(wall, history=history)
    for at in ("interfaces", "contact points"):
        with refused(bs.errors.ModelError, "no forces"):
            figures.forces(still, at=at, ax=axes())
    assert "forces" not in [d.name for d in figures.drawings(still)]


def test_convergence_draws_every_load_factor_its_bound_and_the_certificate(wall, rocking):
    ax = figures.convergence(wall, ax=axes())
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), wall.history.load_factor)
    level = {line.get_label(): line.get_ydata()[0] for line in ax.lines}
    bound = float(wall.history.load_factor[0])
    assert level[f"associative bound {bound:.4g}"] == bound
    assert level[f"certified, α = {wall.load_factor:.4g}"] == wall.load_factor
    # With associative flow the value is the bound.
    single = figures.convergence(rocking, ax=axes())
    assert not [line for line in single.lines if "bound" in line.get_label()]
    ax = figures.certificate(wall, ax=axes())
    measures, limits = ax.lines[::2], ax.lines[1::2]
    assert [len(line.get_ydata()) for line in measures] == [wall.n_iterations] * 4
    s = wall.settings.numerics
    expected = [s.equilibrium_tolerance, s.yield_tolerance, s.interpenetration_tolerance]
    assert [line.get_ydata()[0] for line in limits] == [*expected, wall.certificate.flow_rule_gap_limit]


MORTAR = {"cohesion": Q_(60, "kPa"), "tensile_strength": Q_(50, "kPa")}


@pytest.mark.parametrize(("about", "strengths", "tension"), [("s", {}, 0), ("t", {}, 0), ("t", MORTAR, 5e4 * 0.4)])
def test_crushing_domain_of_a_rectangle_is_the_parabola_from_tension_to_compression(about, strengths, tension):
    result = crushing(**strengths)
    name, F = result.model.interfaces[0].name, 0.2e6 * 0.4
    # s is horizontal but either way round: which extent lies across `about` follows from the frame.
    across = result.history.interface_frame.isel(interface=0).sel(component="t" if about == "s" else "s").to_numpy()
    depth = float(np.abs(across) @ [0.4, 1.0, 0.0])

    def largest(N):
        return (N + tension) * depth / 2 * (1 - (N + tension) / (F + tension))

    ax = figures.crushing_domain(result, name, about=about, ax=axes())
    N, M = (ax.patches[0].get_path().vertices * 1e3).T
    np.testing.assert_allclose(np.abs(M), largest(N), atol=1e-6 * F)
    assert (N.min(), N.max()) == pytest.approx((-tension, F))
    n, m = 1e3 * ax.lines[-1].get_xydata()[0]
    last = result.resultants.isel(iteration=-1, interface=0)
    assert n == pytest.approx(float(last.force.sel(component="n")))
    assert m == pytest.approx(float(last.moment.sel(component=about)))
    assert ax.get_xlabel() == "N [kN]"
    if abs(depth - 0.4) < 1e-9:
        assert abs(m) == pytest.approx(largest(n), rel=1e-5)


def crushing(**strengths):
    """A block 0.4 × 1 × 0.8 m on a weak joint, pushed until it crushes."""
    blocks, joint = single_block(0.4, 0.8)
    return solve(model_of(blocks, joint.varied(compressive_strength="0.2 MPa", **strengths)), push(1, 0, 0))


def test_stress_blocks_are_as_deep_as_the_normal_force_needs():
    strength, N = 0.2e6, 0.4 * 0.8 * 20e3
    _, lines = drawn(figures.structure(crushing(), colour="crushing", look="y", ax=axes()))
    bars = [path for path, _, _ in lines if np.ptp(path[:, 1]) < 1e-9]
    # About the resultant, which the crushing keeps half a block's depth off the edge at 0.4 m.
    np.testing.assert_allclose(np.sort(bars[0][:, 0]), [0.4 - N / strength, 0.4], atol=1e-4)
    assert all(edge == to_rgba(FORCE) for _, edge, _ in lines)


def test_stress_blocks_of_a_triangle():
    # Area above y: (1 − y/h)² of the whole; its centroid at y + (h − y)/3, from the centroid of the triangle at h/3.
    h = 0.9
    N, M = stress_blocks(np.array([[0, -h / 3], [1, -h / 3], [0.5, 2 * h / 3]]), 2.0)
    share = 1 - np.linspace(0, 1, len(N) // 2)
    np.testing.assert_allclose(N[: len(share)], 2 * h / 2 * share**2, atol=1e-12)
    np.testing.assert_allclose(M[: len(share)], 2 * h / 2 * share**2 * (1 - share) * 2 * h / 3, atol=1e-12)


def test_names_with_dollars_are_no_formulas():
    """As layers of a bound DXF reference have them, XREF$0$WALL."""
    block, joint = r"a$\frac$", bs.JointMaterial("soft", 0.6, compressive_strength="1 MPa")
    blocks = [box("b$0$", [-1, -1, -0.5], [3, 3, 0.5], fixed=True), box(block, [0, 0, 0], [0.4, 1, 0.8])]
    result = solve(model_of(blocks, joint), push(1, 0, 0))
    for drawing in figures.drawings(result):
        drawing.picture()
    title = figures.crushing_domain(result, rf"b$0$|{block}", ax=axes()).get_title(loc="left")
    # Dollars behind a backslash are themselves.
    assert title.split("\n")[0] == r"b\$0\$|a\$\frac\$"


def test_curves_have_readable_units_and_show_the_unlimited_strength():
    strength = xr.DataArray([4e6, np.nan, 1e6], dims="compressive_strength", attrs={"units": "pascal"})
    alpha = {"load_factor": ("compressive_strength", [0.3, 0.35, 0.2])}
    data = xr.Dataset(alpha, coords={"compressive_strength": strength})
    ax = figures.curve(data, label="wall", ax=axes())
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["wall"]
    np.testing.assert_allclose(ax.lines[0].get_xydata(), [[1, 0.2], [4, 0.3]])
    assert ax.lines[1].get_ydata()[0] == 0.35
    assert ax.get_xlabel() == "compressive strength f_c [MPa]"


def test_triangles_cover_a_concave_polygon():
    ell = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 2, 0], [0, 2, 0]], dtype=float)
    for shift in range(6):
        points = np.roll(ell, shift, axis=0)
        corners, _ = triangles(points, [np.arange(6)])
        a, b, c = points[corners.T]
        areas = np.cross(b - a, c - a)[:, 2] / 2
        assert areas.min() > 0
        assert areas.sum() == pytest.approx(3)


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda r: figures.structure(r, iteration=99), UNKNOWN, "99 0 -1"),
        (lambda r: figures.forces(r, iteration="3"), MODEL, "iteration '3' 0 -1"),
        (lambda r: figures.structure(r, look="front"), MODEL, "'front' 'x' 'y'"),
        (lambda r: figures.structure(r, ax=Figure().add_subplot(projection="3d")), MODEL, "'3d' plain"),
        (lambda r: figures.mechanism(r.model), MODEL, "Model CaseResult"),
        (lambda r: figures.structure(r, colour="crushing"), MODEL, "compressive strength"),
        (lambda r: figures.structure(r, colour="red"), MODEL, "'red' state sliding crushing"),
        (lambda r: figures.mechanism(r, amplitude=0.1), bs.errors.UnitError, "amplitude 0.1"),
        (lambda r: figures.mechanism(r, colour="body"), MODEL, "'body' displacement macro-block"),
        (lambda r: figures.forces(r, at="blocks"), MODEL, "'blocks' interfaces contact"),
        (lambda r: figures.crushing_domain(r, "a|b"), UNKNOWN, "'a|b' base|1.1"),
        (lambda r: figures.crushing_domain(r, "base|1.1"), MODEL, "'base|1.1' compressive strength"),
        (lambda r: figures.crushing_domain(r, "base|1.1", about="n"), MODEL, "'n' s, t"),
        (lambda r: figures.curve(r.history.block_velocity), MODEL, "one coordinate"),
    ],
)
def test_bad_input_is_refused_with_a_remedy(wall, call, error, words):
    with refused(error, words):
        call(wall)


def test_figures_of_an_analysis_are_written_into_a_folder(tmp_path, small_analysis, monkeypatch):
    folder = tmp_path / "new" / "figures"
    with monkeypatch.context() as patch:
        patch.setattr(Drawing, "picture", lambda *_: b"drawn")
        written = figures.write_figures(small_analysis, folder)
    named = _file_names(["a/b", "a b", "../x", "A-B", "push +x [slow]", "墙", "///"])
    assert list(named.values()) == ["a-b", "a-b-2", "x", "A-B-3", "push-+x-slow", "墙", "case"]
    names = ["mechanism", "loads", "states", "sliding", "forces"]
    both = {"push-associative": names, "push-nonassociative": [*names, "convergence", "certificate"]}
    assert [p.name for p in written] == [f"{case}-{name}.png" for case, all_ in both.items() for name in all_]
    assert sorted(folder.iterdir()) == sorted(written)
    one = small_analysis.replaced(results={"push associative": small_analysis["push associative"]})
    (vector, *_) = figures.write_figures(one, folder, file_format="svg", look="3d")
    assert "α = " in vector.read_text(encoding="utf-8")
    with refused(bs.errors.ModelError, "png, svg, pdf"):
        figures.write_figures(small_analysis, tmp_path, file_format="bmp")
    (tmp_path / "file").write_text("taken")
    with refused(bs.errors.StorageError, "file made"):
        figures.write_figures(small_analysis, tmp_path / "file")


def test_cases_without_iterations_or_without_a_mechanism_are_refused(small_model):
    case = bs.LimitCase("case", SELF_WEIGHT, push(1, 0, 0))
    result = bs.AnalysisManager(small_model, listeners=[stopping()]).run([case])["case"]
    unbounded = solve(small_model, push(0, 0, -1))
    for draw in (figures.structure, figures.mechanism, figures.forces, figures.convergence):
        with refused(bs.errors.ModelError, "no iteration interrupted"):
            draw(result)
    for draw in (figures.mechanism, figures.forces):
        with refused(bs.errors.ModelError, "iteration 0"):
            draw(unbounded, ax=axes())
    assert figures.structure(unbounded, ax=axes()).get_legend().get_texts()[0].get_text() == "unknown"


def test_a_missing_extra_is_named():
    extras = {"figures": ("matplotlib", "viz"), "page": ("plotly", "viz"), "paraview": ("pyvista", "viz")}
    extras["report"] = ("jinja2", "report")
    code = "import sys\n" + "".join(
        f"sys.modules['{package}'] = None\ntry: import blockstruct.views.{module}\nexcept ImportError as e: print(e)\n"
        for module, (package, _) in extras.items()
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    for line, (package, extra) in zip(run.stdout.splitlines(), extras.values(), strict=True):
        assert line.endswith(f'{package} is not installed; it comes with: pip install "blockstruct[{extra}]"')


def test_a_legend_of_long_names_stays_on_the_picture():
    stone = bs.Material("stone", "24 kN/m^3")
    blocks = bs.arch(span="6 m", thickness="0.4 m", depth="1 m", voussoirs=11, material=stone)
    fill = bs.FillLoad("18 kN/m^3", start=["-3.6 m", "0 m", "0 m"], end=["3.6 m", "1 m", "4 m"])
    dead = bs.LoadPattern("with fill", [bs.SelfWeight(), fill])
    result = solve(model_of(blocks, bs.JointMaterial("joint", 0.6)), push(1, 0, 0), dead=dead)
    figure = plt.figure(figsize=(6.3, 3.1), layout="constrained")
    ax = figures.mechanism(result, colour="macro-block", ax=figure.add_subplot())
    figure.canvas.draw()
    texts = ax.get_legend().get_texts()
    assert len(texts) >= 3
    assert all(text.get_text().endswith(" kN of it carried") for text in texts)
    assert max(text.get_window_extent().x1 for text in texts) <= figure.bbox.x1


def test_the_compass(small_model, dead):
    around = bs.directions(small_model, dead, 4, flow="associative")
    ax = figures.compass(around, label="wall")
    line = ax.get_lines()[0]
    np.testing.assert_allclose(line.get_ydata()[:4], around.data.load_factor)
    np.testing.assert_allclose(np.degrees(line.get_xdata()), [0, 90, 180, 270, 360])
    assert f"{around.load_factor:.4g}" in ax.get_title()
    assert "not covered" not in ax.get_title() + str(around)
    figures.compass(around.analysis, label="again", ax=ax)
    assert len(ax.get_legend().get_texts()) == 2
    with pytest.raises(bs.errors.ModelError, match="give polar ones"):
        figures.compass(around, ax=plt.figure().add_subplot())


def test_a_compass_joins_points_of_convex_directions_only(small_model, dead):
    around = bs.directions(small_model, dead, 4)
    settled = around.data["settled"].copy(data=[True, False, True, True])
    drifting = bs.studies.Directions(around.analysis, around.data.assign(settled=settled))
    ax = figures.compass(drifting)
    assert ax.get_lines()[0].get_linestyle() == "None"
    assert "directions between the points are not covered" in ax.get_title()
    (hollow,) = ax.collections
    np.testing.assert_allclose(hollow.get_offsets().ravel(), [np.pi / 2, around.data.load_factor[1]])
    # Half a turn apart.
    half = figures.compass(bs.directions(small_model, dead, bs.Q_([0, 90], "deg"), flow="associative"))
    assert np.isnan(half.get_lines()[0].get_ydata()).tolist() == [False, False, True, False]


def test_the_tornado():
    data = xr.Dataset(
        {"contribution": ("interface", [0.2, -0.1, 0.0]), "load_factor": 0.5, "independent": 0.2, "correlated": 0.3},
        coords={"interface": ["a|b", "b|c", "c|d"]},
        attrs={"unique": 0},
    )
    ax = figures.tornado(data)
    assert [text.get_text() for text in ax.get_yticklabels()] == ["a|b", "b|c"]
    assert [bar.get_width() for bar in ax.patches] == pytest.approx([0.2, -0.1, -0.2, 0.1])
    assert all(bar.get_x() == 0.5 for bar in ax.patches)
    with pytest.raises(bs.errors.ModelError, match="first_order"):
        figures.tornado(xr.Dataset())


def test_the_distribution():
    alpha = np.append(np.linspace(0.1, 0.3, 19), np.nan)
    data = samples(alpha, ["converged"] * 19 + ["failed"])
    ax = figures.distribution(data)
    step, *_ = ax.get_lines()
    assert step.get_xdata().tolist() == alpha[:19].tolist()
    assert step.get_ydata()[-1] == 1
    # The 5 % fractile of 20 runs has no lower end, the 95 % one no upper one.
    ends = {line.get_marker(): line.get_ydata().tolist() for line in ax.get_lines() if line.get_marker() in ("<", ">")}
    assert ends == {"<": [0.05], ">": [0.95]}
    with pytest.raises(bs.errors.UnknownNameError, match="no case 'pull'"):
        figures.distribution(data, "pull")
    with pytest.raises(bs.errors.ModelError, match="name one"):
        figures.distribution(xr.concat([data, data.assign_coords(case=["pull"])], "case"))
