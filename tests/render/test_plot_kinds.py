"""All kinds of plots, for bodies with and without the data that they show."""

import html
import re
from dataclasses import replace

import matplotlib
import matplotlib.image
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.path import Path as MatplotlibPath

import gaitsim as gs
from gaitsim.actions.plot import file_stem
from gaitsim.contracts import Channel, Motion, Skeleton, Subject
from gaitsim.errors import GaitsimError, NothingToPlotError
from gaitsim.experiment import load_experiment
from gaitsim.individual import Individual
from gaitsim.registry.loading import load_product, products
from gaitsim.render.plots.components import limit_constant, lines_of, read_signal
from gaitsim.render.plots.data import window_slice
from gaitsim.render.plots.labels import add_heading
from gaitsim.render.plots.style import DARK, LIGHT, picture, save, styled
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim_plots.archive import polygons
from gaitsim_plots.genome import MAX_GENES
from gaitsim_plots.joints import legs_of
from gaitsim_plots.path import scene_of

SPACE = ("x", "y", "z")


# Kinds of packages that need a run of their own search or body are tested there.
KINDS = [kind for kind in products("plot") if kind not in ("assembly", "design")]


class Request:
    """A run, individuals, and the options of a plot."""

    def __init__(self, run, individuals=(), **options):
        self.run, self.individuals, self.options = run, individuals, options

    @property
    def individual(self):
        return self.individuals[0]

    def but(self, **options):
        return Request(self.run, self.individuals, **{**self.options, **options})


def request_for(run, *generations, **more):
    return Request(run, tuple(run.individual(number) for number in generations or (None,)), **more)


def draw(kind, request):
    product = load_product("plot", kind, request.options)
    return product.draw(Subject(request.run, request.individuals))


def stem(kind, request):
    product = load_product("plot", kind, request.options)
    return file_stem(kind, product, Subject(request.run, request.individuals))


def texts(figure):
    """Return the texts on a figure."""
    written = re.findall("<text[^>]*>(.*?)</text>", picture(figure, "svg", LIGHT).decode())
    return {html.unescape(text) for text in written}


def lines(axes):
    """Return the data lines of some axes."""
    return [line for line in axes.lines if len(line.get_xdata()) > 2]


def robot_request(**options):
    """Return a request for a robot with other options, without a run."""
    trot = load_experiment("quadruped", {"organism.duration": 3.0, **options})
    return Request(None, (Individual(trot, 0.0, {}, 1, trot.starts()["trot"]),))


DRIVE = [{"at": 0.0, "speed": 0.2, "turn": 20.0}, {"at": 2.0, "sideways": 0.05}]


@pytest.fixture
def flier(puppet_run, puppets, monkeypatch):
    """A run of puppets that fly in two trials, without joints and feet."""

    def move(self, genomes):
        times = np.linspace(0, 1, 5)[None, :, None, None]
        place = np.broadcast_to(times * genomes[:, None, None, :], (len(genomes), 5, 2, 3)).copy()
        place[:, :, 1] += 1
        return Motion(
            4.0,
            {
                "reach": genomes.sum(axis=1),
                "place": place,
                "rotation": np.ones((len(genomes), 5, 2, 4)),
                "landed": np.zeros((len(genomes), 5), dtype=bool),
            },
        )

    def skeleton(self, motion, individual):
        centre = motion["place"][individual, :, 0]
        ends = centre[:, None, None] + np.array([[[0.1, 0, 0], [-0.1, 0, 0]]])
        return Skeleton(ends, ("body",), 4.0, centre=centre)

    run = puppet_run()
    monkeypatch.setattr(puppets.Reach, "needs", ("reach",))
    monkeypatch.setattr(puppets.Puppet, "move", move)
    monkeypatch.setattr(puppets.Puppet, "skeleton", skeleton)
    monkeypatch.setattr(
        puppets.Puppet,
        "channels",
        {
            "reach": Channel((), "m", "distance reached"),
            "place": Channel(("frames", "trials", SPACE), "m", "position of the centre"),
            "rotation": Channel(("frames", "trials", ("w", "x", "y", "z")), "", "unit quaternion"),
            "landed": Channel(("frames",), "", "whether it has landed"),
        },
    )
    return run


@pytest.fixture
def drawn(spider_run, bundled):
    """A function that draws a kind of plot for a run that has the data."""

    def drawing(kind, **more):
        if kind == "feedback":
            feeling = {"organism.reflexes": {"heading": {}}, "organism.drive": DRIVE}
            return draw(kind, robot_request(**feeling).but(**more))
        runs = {"phase": "millipede", "front": "spider-front", "parallel": "spider-front"}
        runs |= dict.fromkeys(("archive", "gaits", "search"), "spider-atlas")
        run = bundled(runs[kind]) if kind in runs else spider_run
        if kind == "archive":
            more["axes"] = ("duty factor L1", "duty factor R1")
        return draw(kind, request_for(run, **more))

    return drawing


SAMPLE = ("fitness", "path", "footfall", "archive")


@pytest.mark.sampled
@pytest.mark.parametrize(
    "kind", [one if one in SAMPLE else pytest.param(one, marks=pytest.mark.slow) for one in KINDS]
)
def test_every_kind_is_reproducible_and_follows_the_theme(drawn, tmp_path, kind):
    pictures = [picture(drawn(kind), "svg", LIGHT) for _ in range(2)]
    assert pictures[0] == pictures[1]
    save(drawn(kind, theme="dark"), tmp_path / "dark.png", DARK)
    image = matplotlib.image.imread(tmp_path / "dark.png")
    width = (
        1530 if kind in ("gaits", "parallel") else 1020
    )  # a column is 86 mm at 300 dots per inch
    assert image.shape[1] == width
    assert image[-1, -1, :3] == pytest.approx([21 / 255, 24 / 255, 28 / 255], abs=0.003)


@pytest.mark.parametrize("kind", KINDS)
def test_everything_drawn_is_inside_the_picture(drawn, kind):
    figure = drawn(kind)
    with styled(LIGHT):
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        room = figure.get_tightbbox(canvas.get_renderer())  # inches
    assert room.x0 > -0.02
    assert room.x1 < figure.get_figwidth() + 0.02
    assert room.y0 > -0.02
    assert room.y1 < figure.get_figheight() + 0.02


@pytest.mark.parametrize("objectives", [2, 3])
def test_a_front_shows_every_pair_of_objectives_and_marks_the_best_score(puppet_run, objectives):
    names = ["reach", "price", "score"][:objectives]
    given = ", ".join(f"{name} = 'max'" for name in names)
    run = puppet_run("search.plugin=nsga-2", f"search.objectives={{ {given} }}")
    members = run.members
    figure = draw("front", Request(run))
    assert len(figure.axes) == {2: 1, 3: 3}[objectives]
    assert {"reach (m, more is better)", "price (more is better)"} < texts(figure)
    population, *_, front, best = figure.axes[0].collections
    np.testing.assert_array_equal(
        population.get_offsets(), np.stack([run.finished.values[name] for name in names[:2]], 1)
    )
    values = np.stack([members.values[name] for name in names[:2]], axis=1)
    np.testing.assert_array_equal(front.get_offsets(), values)
    np.testing.assert_array_equal(best.get_offsets()[0], values[members.scores.argmax()])
    for edge in figure.axes[0].lines:  # no member is better than a corner
        assert objectives == 2
        assert edge.get_drawstyle() == "steps-pre"  # both are maximised


@pytest.mark.parametrize("cells", ["[4, 5]", "30"])
def test_an_archive_shows_the_score_of_each_cell_and_marks_the_best(puppet_run, cells):
    axes = "{ reach = [-3, 3], price = [-1, 0] }"
    run = puppet_run("search.plugin=map-elites", f"search.axes={axes}", f"search.cells={cells}")
    members = run.members
    figure = draw("archive", Request(run))
    panel, bar = figure.axes
    assert {"reach (m)", "price", "score"} < texts(figure)
    assert bar.get_xlim() == pytest.approx((members.scores.min(), members.scores.max()), rel=0.5)
    drawn = panel.collections[0]
    if cells == "30":
        assert len(drawn.get_paths()) == len(members.scores)
        np.testing.assert_array_equal(drawn.get_array(), members.scores)
        for shape, *place in zip(drawn.get_paths(), *members.values.values(), strict=True):
            assert shape.contains_point(np.clip(place, [-3, -1], [3, 0]), radius=1e-9)
    else:
        scores = drawn.get_array().T
        assert scores.shape == (4, 5)
        assert scores.count() == len(members.scores)
        np.testing.assert_array_equal(scores[tuple(members.cells.T)], members.scores)
    best = members.scores.argmax()
    for mark in panel.lines:
        found = [values[best] for values in members.values.values()]
        np.testing.assert_allclose(np.ravel(mark.get_data()), found)
    assert stem("archive", Request(run, axes=("reach", "price"))) == "archive-reach-price"
    flipped = draw("archive", Request(run, axes=("price", "reach"))).axes[0]
    assert flipped.get_xlim() == (-1, 0)
    with pytest.raises(GaitsimError, match="no axis 'speed'"):
        draw("archive", Request(run, axes=("reach", "speed")))


def test_an_archive_with_one_axis_is_a_step_line(puppet_run):
    axes = "{ reach = [-3, 3] }"
    run = puppet_run("search.plugin=map-elites", f"search.axes={axes}", "search.cells=[6]")
    (panel,) = draw("archive", Request(run)).axes
    values, edges, _ = panel.patches[0].get_data()
    np.testing.assert_array_equal(edges, np.linspace(-3, 3, 7))
    np.testing.assert_array_equal(values[run.members.cells[:, 0]], run.members.scores)


def test_voronoi_cells_tile_the_rectangle_and_contain_the_nearest_points():
    rng = np.random.default_rng(1)
    ends = np.array([[-2.0, 4.0], [10.0, 11.0]])
    centres = ends[:, 0] + rng.random((40, 2)) * [6, 1]
    shapes = [MatplotlibPath(corners, closed=False) for corners in polygons(centres, ends)]
    areas = [abs(signed_area(shape.vertices)) for shape in shapes]
    assert sum(areas) == pytest.approx(6)
    points = ends[:, 0] + rng.random((300, 2)) * [6, 1]
    nearest = np.linalg.norm((points[:, None] - centres) / [6, 1], axis=2).argmin(1)
    for point, cell in zip(points, nearest, strict=True):
        assert shapes[cell].contains_point(point)


def signed_area(corners):
    (x, y), (u, v) = corners.T, np.roll(corners, -1, axis=0).T
    return (x * v - u * y).sum() / 2


def test_figures_of_a_search_are_drawn_over_the_evaluations(bundled, puppet_run):
    run = bundled("spider-atlas")
    panels = draw("search", Request(run)).axes
    for panel, name in zip(panels, ("coverage", "QD score", "best elite"), strict=True):
        assert panel.get_ylabel() == name
        assert panel.lines[0].get_xdata().tolist() == run.history["evaluations"].tolist()
        assert panel.lines[0].get_ydata().tolist() == run.history[f"search:{name}"].tolist()
    for kind in ("search", "archive", "front", "parallel"):
        with pytest.raises(NothingToPlotError, match="genetic"):
            load_product("plot", kind, {}).check(puppet_run().individual())
        with pytest.raises(NothingToPlotError, match="genetic"):
            draw(kind, Request(puppet_run()))


def test_angles_are_in_degrees_small_lengths_in_millimetres_and_the_last_second_has_a_label(
    spider_run,
):
    request = request_for(spider_run, channel="pose")
    axes = draw("channel", request).axes
    assert [one.get_ylabel() for one in axes] == ["x (mm)", "y (mm)", "yaw (°)"]
    pose = request.individual.motion["pose"][0].astype(float)
    for one, values in zip(axes, (pose * [1000, 1000, 180 / np.pi]).T, strict=True):
        assert np.allclose(lines(one)[0].get_ydata(), values)
        assert one.get_xlim() == (0, 10)
        assert 10 in one.get_xticks()


@pytest.mark.parametrize("high", [*np.geomspace(1e-3, 9e-3, 20), 12e6])
def test_steps_between_ticks_are_1_2_or_5(high):
    figure = Figure(figsize=(3, 2))
    axes = figure.subplots()
    axes.plot([0, 1], [0, high])
    add_heading(figure, "")
    step = np.diff(axes.get_yticks())
    digit = step / 10 ** np.floor(np.log10(step) + 1e-9)
    assert np.isclose(digit[:, None], [1, 2, 5], atol=1e-6).any(axis=1).all()


def test_a_line_at_zero_is_inside_its_panel_and_counts_are_whole(bundled, flier):
    shown = flier.individual()
    channel = draw("channel", Request(flier, (shown,), channel="place")).axes[0]
    limit_constant(channel, np.zeros(3))
    assert channel.get_ylim() == (-1, 1)
    search = draw("search", request_for(bundled("spider"))).axes
    (restarts,) = [axes for axes in search if axes.get_ylabel() == "restarts"]
    assert (restarts.get_yticks() % 1 == 0).all()
    assert restarts.get_ylim()[0] > -0.5


@pytest.mark.slow
def test_the_genes_of_a_long_genome_that_change_most_are_drawn_with_names(tmp_path):
    small = {"evolution.generations": 3, "evolution.population": 4, "organism.duration": 0.3}
    for _ in gs.evolve(load_experiment("fly", small), out=tmp_path / "run"):
        pass
    run = RunSnapshot(tmp_path / "run")
    axes = draw("genome", request_for(run)).axes[0]
    space = run.experiment.space()
    genomes = np.stack([run.best_genome(number) for number in (1, 2, 3)])
    spread = ((genomes - space.lower) / space.width).std(axis=0)
    names = [label.get_text() for label in axes.get_yticklabels()]
    assert len(names) == MAX_GENES < space.genes
    drawn = spread[[space.labels.index(name) for name in names]]
    assert drawn.min() >= np.sort(spread)[-MAX_GENES]
    assert f"the {MAX_GENES} of {space.genes} genes" in axes.get_title(loc="left")


def test_feet_without_a_common_stride_have_no_phase_plot(spider_run):
    with pytest.raises(NothingToPlotError, match="no common stride"):
        draw("phase", request_for(spider_run))


def test_terms_have_a_common_scale_or_are_shares_on_request(spider_run):
    own, common, share = (
        draw("terms", request_for(spider_run, scale=scale)).axes
        for scale in ("own", "common", "share")
    )
    assert len({axes.get_ylim() for axes in own}) > 1
    assert len({axes.get_ylim() for axes in common}) == 1
    assert len({axes.get_ylim() for axes in share}) == 1
    for line in (0, 1):
        values = np.stack([lines(axes)[line].get_ydata() for axes in share])
        assert np.allclose(np.abs(values).sum(axis=0), 1)
        terms = np.stack([lines(axes)[line].get_ydata() for axes in own])
        assert np.allclose(values, terms / np.abs(terms).sum(axis=0))
        assert np.allclose(terms, [lines(axes)[line].get_ydata() for axes in common])


def test_footfall_bars_span_the_stances(spider_run):
    request = request_for(spider_run, window=(1.0, 3.0))
    axes = draw("footfall", request).axes[0]
    touching = request.individual.stance[30:91]
    for foot, bars in enumerate(axes.collections):
        boxes = [path.get_extents() for path in bars.get_paths()]
        assert sum(box.width for box in boxes) == pytest.approx(touching[:, foot].sum() / 30)
        assert all(box.y0 < foot < box.y1 for box in boxes)
    assert [label.get_text() for label in axes.get_yticklabels()] == [
        f"{side}{leg}" for side in "LR" for leg in range(1, 5)
    ]


def with_channels(run, monkeypatch, **channels):
    """Return a request for an individual with more channels, (declaration, values) each."""
    shown = run.individual()
    motion = shown.motion
    more = {name: values[None] for name, (_, values) in channels.items()}
    motion = Motion(motion.frame_rate, {**motion, **more})
    monkeypatch.setattr(type(shown), "motion", property(lambda self: motion))
    bodies = type(run.experiment.organism)
    declared = {name: channel for name, (channel, _) in channels.items()}
    monkeypatch.setattr(bodies, "channels", {**bodies.channels, **declared})
    return request_for(run, window=(1.0, 3.0))


def test_joint_angles_are_in_degrees_with_a_panel_for_each_leg(spider_run):
    request = request_for(spider_run, window=(0.0, 1.0))
    figure = draw("joints", request)
    panels = {axes.get_title(loc="left"): axes for axes in figure.axes}
    assert [*panels] == ["L1", "R1", "L2", "R2", "L3", "R3", "L4", "R4"]
    angles = np.degrees(request.individual.motion["joint_angles"][0, :31].astype(float))
    drawn = lines(panels["R1"])
    assert [line.get_label() for line in drawn] == ["coxa", "femur", "tibia"]
    assert np.allclose(np.stack([line.get_ydata() for line in drawn], axis=1), angles[:, 12:15])


@pytest.mark.sampled
@pytest.mark.parametrize(("share", "limited"), [(0.3, False), (0.9, True)])
def test_the_stall_torque_is_drawn_if_torques_come_near_it(spider_run, monkeypatch, share, limited):
    torque = 2.0 * share * np.abs(np.sin(np.arange(300) / 5))[:, None].repeat(24, axis=1)
    request = with_channels(
        spider_run,
        monkeypatch,
        torque=(Channel(("frames", "joints"), "N m", ""), torque),
        stall_torque=(Channel(("joints",), "N m", ""), np.full(24, 2.0)),
    )
    figure = draw("joints", request.but(channel="torque"))
    assert len(figure.axes) == 8
    for axes in figure.axes:
        assert np.allclose(lines(axes)[0].get_ydata(), torque[30:91, 0])
        limits = [line for line in axes.lines if len(line.get_xdata()) == 2]
        assert [line.get_ydata()[0] for line in limits] == [2.0] * limited
    assert "torque (N m)" in texts(figure)
    assert ("stall" in texts(figure)) == limited


@pytest.mark.parametrize("kind", ["joints", "footfall"])
def test_the_default_window_ends_with_a_fall(spider_run, monkeypatch, kind):
    """The fall is at 4 s; the bar of a foot lasts until the next frame."""
    fallen = (Channel((), "s", ""), np.array(4.0))
    request = with_channels(spider_run, monkeypatch, lasted=fallen).but(window=None)
    assert draw(kind, request).axes[0].get_xlim()[1] == pytest.approx(4.0, abs=0.04)
    whole = request.but(window=(0.0, 9.0))
    assert draw(kind, whole).axes[0].get_xlim()[1] == pytest.approx(9.0, abs=0.04)


@pytest.mark.parametrize(
    ("names", "legs"),
    [
        (["L1 a", "L1 b", "R1 a", "R1 b"], {"L1": {"a": 0, "b": 1}, "R1": {"a": 2, "b": 3}}),
        (["left leg a", "left leg b"], {"left leg": {"a": 0, "b": 1}}),
        (["hip", "knee"], {"": {"hip": 0, "knee": 1}}),
        (["L1 a", "L1 b", "R1 a"], {"": {"L1 a": 0, "L1 b": 1, "R1 a": 2}}),
        (["L a", "L a", "R a"], {"": {"L a": 1, "R a": 2}}),
        (list("abcdefg"), {letter: {"": at} for at, letter in enumerate("abcdefg")}),
    ],
)
def test_joints_are_grouped_by_leg_if_names_begin_with_the_leg(names, legs):
    assert legs_of(names) == legs


@pytest.mark.parametrize(
    ("names", "joints"),
    [
        ("FL_hip_joint FL_calf_joint FR_hip_joint FR_calf_joint", ["hip joint", "calf joint"]),
        ("hip_joint_front_left knee_joint_front_left hip_joint_rear_right knee_joint_rear_right",
         ["hip joint", "knee joint"]),
        # Not ordered by leg, without the name of a leg, or different on each side.
        ("L_hip R_hip L_knee R_knee", None),
        ("L_hip L_knee R_hip R_ankle", None),
    ],
)  # fmt: skip
def test_joints_with_other_names_are_grouped_by_foot(names, joints):
    names = names.split()
    found = legs_of(names, ("L1", "R1"))
    if joints is None:
        assert found == {"": {name: column for column, name in enumerate(names)}}
    else:
        assert found == {
            "L1": dict(zip(joints, (0, 1), strict=True)),
            "R1": dict(zip(joints, (2, 3), strict=True)),
        }


def test_commands_changes_of_reflexes_and_yaw_are_drawn_in_degrees():
    feeling = robot_request(**{"organism.reflexes": {"heading": {}}, "organism.drive": DRIVE})
    motion = feeling.individual.motion
    frames = round(feeling.individual.measures["lasted"] * motion.frame_rate) + 1
    speed, turn, sideways, yaw = draw("feedback", feeling).axes
    assert [one.get_ylabel() for one in (speed, turn, sideways, yaw)] == [
        *("speed (m/s)", "turn (°/s)", "sideways (m/s)", "yaw (°)")
    ]
    for axes, channels in (
        (turn, [motion["command"][0, :, 1], motion["changed_command"][0, :, 1]]),
        (
            yaw,
            [
                motion["measured_orientation"][0, :, 2],
                motion["orientation"][0, :, 2],
                motion["commanded_heading"][0],
            ],
        ),
    ):
        for line, channel in zip(lines(axes), channels, strict=True):
            assert np.allclose(line.get_ydata(), np.degrees(channel[:frames]))
    part = draw("feedback", feeling.but(window=(1.0, 2.0))).axes[0]
    assert part.get_xlim() == (1.0, 2.0)


def test_the_path_is_drawn_at_one_scale_with_separate_bodies(bundled):
    request = request_for(bundled("spider"))
    scene = scene_of(request.individual.skeleton, slice(0, 300))
    assert np.allclose(scene.path, request.individual.skeleton.path)
    assert 1 <= len(scene.at) <= 6
    assert scene.at[0] == 0
    assert scene.factor == 1
    along = int(np.argmax(np.ptp(scene.path[:, :2], axis=0)))
    for panel, shown in zip(draw("path", request).axes, ((0, 1), (along, 2)), strict=True):
        assert np.allclose(path_in(panel), scene.path[:, shown])
        assert panel.get_aspect() == 1
        assert 1 <= len(panel.collections) - 1 <= len(scene.at)
        start, end = (
            line.get_xydata()[0] for line in panel.lines if line.get_label() in ("start", "end")
        )
        assert np.allclose([start, end], scene.path[[0, -1]][:, shown])


def path_in(panel):
    """Return the points of the path drawn in a panel."""
    parts = [part.vertices for part in panel.collections[-1].get_paths()]
    return np.concatenate([parts[0][:1], *(part[1:] for part in parts)])


@pytest.mark.parametrize(("radius", "bodies"), [(0.05, 0), (0.2, 1), (5.0, 4)])
def test_drawn_bodies_neither_overlap_nor_hide_a_path_that_returns(flier, radius, bodies):
    """The body, 1 m long, flies along a circle twice."""
    shown, turn = flier.individual(), np.linspace(0, 4 * np.pi, 200)
    centre = radius * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    ends = centre[:, None, None] + np.array([[[0.5, 0, 0], [-0.5, 0, 0]]])
    skeleton = Skeleton(ends, ("body",), 50.0, centre=centre)
    scene = scene_of(skeleton, slice(0, 200))
    assert len(scene.at) >= bodies
    assert (len(scene.at) == 0) == (bodies == 0)
    places = scene.path[scene.at]
    gaps = np.linalg.norm(places[:, None] - places, axis=-1) + 99 * np.eye(len(places))
    assert (gaps > 1).all()
    object.__setattr__(shown, "skeleton", skeleton)
    said = any("not drawn" in text for text in texts(draw("path", Request(flier, (shown,)))))
    assert said == (bodies == 0)


@pytest.mark.parametrize("broken", ["all", "some"])
def test_frames_that_are_not_finite_are_left_out_of_the_path(flier, broken):
    shown = flier.individual()
    segments = shown.skeleton.segments.copy()
    segments[slice(None) if broken == "all" else 1] = np.nan
    object.__setattr__(shown, "skeleton", replace(shown.skeleton, segments=segments))
    request = Request(flier, (shown,))
    if broken == "some":
        assert len(path_in(draw("path", request).axes[1])) == 4
    else:
        with pytest.raises(NothingToPlotError, match="puppet"):
            draw("path", request)


@pytest.mark.parametrize(
    ("components", "names"),
    [
        ((), ["trial 1 x", "trial 1 y", "trial 1 z", "trial 2 x", "trial 2 y", "trial 2 z"]),
        (("z",), ["trial 1 z", "trial 2 z"]),
        (("3",), ["trial 1 z", "trial 2 z"]),
        (("trial 2", "z", "x"), ["trial 2 x", "trial 2 z"]),
    ],
)
def test_components_are_chosen_by_name_or_index(flier, components, names):
    channel = read_signal(flier.individual(), "place")
    found = lines_of(channel, components)
    assert [line.name for line in found] == names
    for line in found:
        trial, axis = int(line.name[6]), "xyz".index(line.name[-1])
        assert np.array_equal(line.values, channel.values[:, trial - 1, axis])


def test_a_channel_has_a_unit_and_gaps_at_values_that_are_not_finite(flier, puppets, monkeypatch):
    real = puppets.Puppet.move

    def move(self, genomes):
        motion = real(self, genomes)
        motion["place"][:, 2:] = np.inf
        return motion

    monkeypatch.setattr(puppets.Puppet, "move", move)
    figure = draw("channel", request_for(flier, channel="place", components=("x",)))
    assert "place x (m)" in texts(figure)
    assert all(np.isnan(line.get_ydata()[2:]).all() for line in lines(figure.axes[0]))


def test_unknown_components_and_channels_without_frames_are_rejected(flier):
    for component in ("w", "4", "0", "-1", "", "²"):
        with pytest.raises(GaitsimError, match="has no component") as error:
            draw("channel", request_for(flier, channel="place", components=(component,)))
        assert error.value.allowed.startswith(
            "trial 1, trial 2; and x, y, z; or a number from 1 to 3"
        )
    with pytest.raises(GaitsimError, match="has no component '1'"):
        draw("channel", request_for(flier, channel="landed", components=("1",)))
    with pytest.raises(GaitsimError, match="one value per gait") as error:
        draw("channel", request_for(flier, channel="reach"))
    assert error.value.allowed == "place, rotation, landed"


@pytest.mark.parametrize(
    ("window", "frames"),
    [(None, (40, 300)), ((0, 1), (0, 31)), ((9, 20), (270, 300)), ((0.5, 0.6), (15, 19))],
)
def test_a_window_is_a_part_of_the_frames(window, frames):
    assert window_slice(300, 30.0, window, default=26 / 3) == slice(*frames)


def test_a_window_without_motion_is_rejected():
    for window in ((10, 20), (0.0, 0.01), (-1, 2)):
        with pytest.raises(GaitsimError, match="fewer than two frames") as error:
            window_slice(300, 30.0, window)
        assert "0 to 9.967 s" in error.value.allowed
    with pytest.raises(NothingToPlotError, match="only one frame"):
        window_slice(1, 30.0, None)
