"""The viewer in Chromium, from a file, with the network blocked."""

from types import SimpleNamespace

import numpy as np
import pytest
from javascript import CHROMIUM

from gaitsim.contracts import Terrain
from gaitsim_page.document import document
from gaitsim_page.packing import pack
from gaitsim_page.player import themes

FLAGS = [
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
DRAWN = ["--enable-unsafe-swiftshader"]
UNDRAWN = ["--disable-3d-apis"]

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium")]
FRAMES, RATE = 61, 30.0
NAMED = "</script><script>document.title = 'evil'</script><img src=x onerror=alert(1)>\u202e"


@pytest.fixture(scope="module")
def driver():
    playwright = pytest.importorskip("playwright.sync_api", reason="needs Playwright")
    with playwright.sync_playwright() as driver:
        yield driver.chromium


@pytest.fixture(scope="module")
def browser(driver):
    return driver.launch(executable_path=CHROMIUM, args=[*FLAGS, *DRAWN])


@pytest.fixture(scope="module")
def blind(driver):
    """A browser without WebGL."""
    return driver.launch(executable_path=CHROMIUM, args=[*FLAGS, *UNDRAWN])


@pytest.fixture
def show(browser, tmp_path):
    """A function that opens a page; returns it with its requests, messages and dialogs."""
    contexts = []

    def show(data, browser=browser, **options):
        path = tmp_path / "page.html"
        path.write_bytes(document(data["title"], "player", data))
        context = browser.new_context(offline=True, **options)
        contexts.append(context)
        page = context.new_page()
        events = []
        page.on("request", lambda request: events.append(request.url))
        page.on("console", lambda message: events.append(message.text))
        page.on("pageerror", lambda error: events.append(str(error)))
        page.on("dialog", lambda dialog: events.append(dialog.message))
        page.goto(path.as_uri())
        page.wait_for_selector(".player")
        # Wait for the first pictures: the graphics library may print messages when it draws.
        page.evaluate(PICTURES)
        return SimpleNamespace(page=page, events=events, uri=path.as_uri(), run=page.evaluate)

    yield show
    for context in contexts:
        context.close()


PICTURES = """() => new Promise((go) => {
    const { stage } = gaitsimPage;
    if (!stage) return go();
    let left = 4;
    const count = () => {
        if (--left) return stage.request();
        stage.listeners.splice(stage.listeners.indexOf(count), 1);
        go();
    };
    stage.listeners.push(count);
    stage.request();
})"""


def clip(**changes):
    """Return a body of two limbs and a plate that walks 2 m along x in 2 s."""
    time = np.arange(FRAMES) / RATE
    base = np.array([[0, 0, 0.3], [0.3, 0, 0.3], [0.15, 0.2, 0], [-0.2, 0.1, 0.3], [0.1, -0.2, 0]])
    points = np.repeat(base[None], FRAMES, axis=0)
    points[..., 0] += time[:, None]
    centre = points.mean(axis=1)
    feet = points[:, [2, 4]]
    touching = np.stack([np.sin(9 * time) > 0, np.sin(9 * time) <= 0], axis=1)
    made = {
        "title": "walker",
        "details": "generation 3, score 2",
        "tag": "generation 3",
        "score": 2.0,
        "unit": "m",
        "frameRate": RATE,
        "frames": FRAMES,
        "flies": False,
        "floor": 0.0,
        "span": 0.5,
        "mark": 0.02,
        "said": [],
        "ends": [0, 2, 0, 4],
        "points": pack(points, 1e-5),
        "limbs": [[0, 2, 0.02, 0.01, "limb"], [0, 4, 0.02, 0.01, "damaged"]],
        "plates": [{"corners": [0, 1, 3], "half": 0.01}],
        "hulls": [],
        "solids": [],
        "poses": None,
        "feet": {
            "names": ["L1", "R1"],
            "sides": ["left", "right"],
            "points": pack(feet, 1e-5),
            "touching": pack(touching, 1),
            "lost": [False, False],
        },
        "centre": pack(centre, 1e-5),
        "ground": None,
        "angles": {"names": ["hip"], "values": pack(np.sin(time)[:, None], 1e-6)},
        "terms": [{"name": "forward", "value": 2.5, "unit": "m"}],
        "measures": [{"name": "speed", "value": 1.0, "unit": "m/s", "help": "How fast."}],
    }
    return made | changes


def data(*clips, **changes):
    return {
        "title": "walker",
        "description": "a body that walks",
        "theme": themes(),
        "clips": list(clips),
        "curve": {"generation": [1, 2, 3], "best": [0.5, None, 2.0]},
        "code": "gs1-CODE",
        "made": "gaitsim",
    } | changes


def flying():
    return clip(flies=True, floor=-1.0, feet=None, angles=None)


def solid(ground):
    poses = np.zeros((FRAMES, 6, 7))
    poses[..., 0] = np.arange(FRAMES)[:, None] / RATE + np.arange(6) / 5
    poses[..., 2] = 0.3
    poses[..., 3] = 1
    shapes = [
        ("box", [0.1, 0.05, 0.02]),
        ("sphere", [0.05]),
        ("capsule", [0.02, 0.1]),
        ("cylinder", [0.03, 0.05]),
        ("ellipsoid", [0.1, 0.05, 0.02]),
        ("mesh", []),
    ]
    corners = [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    solids = [
        {
            "name": shape,
            "shape": shape,
            "size": size,
            "side": ["", "left", "right"][number % 3],
            "damaged": number == 3,
            "vertices": corners if shape == "mesh" else [],
            "faces": faces if shape == "mesh" else [],
        }
        for number, (shape, size) in enumerate(shapes)
    ]
    none = {"ends": [], "limbs": [], "plates": [], "hulls": []}
    points = pack(np.empty((FRAMES, 0, 3)), 1e-5)
    poses = pack(poses, 1e-5)
    return clip(points=points, solids=solids, poses=poses, ground=ground, **none)


def uneven():
    heights = np.random.default_rng(0).uniform(0, 0.05, (30, 40))
    return {"corner": [-1.0, -1.5], "spacing": 0.1, "heights": pack(heights, 1e-5)}


BODIES = {
    "walker": lambda: [clip()],
    "several": lambda: [clip(tag=f"generation {number}") for number in (1, 2, 3)],
    "flying": lambda: [flying()],
    "solids on a terrain": lambda: [solid(uneven())],
    "on a profile": lambda: [clip(ground={"x": [0.0, 0.5, 1.0], "z": [0.0, 0.05, 0.0]})],
    "one frame": lambda: [
        clip(
            frames=1,
            points=pack(np.random.default_rng(0).uniform(0, 1, (1, 5, 3)), 1e-5),
            centre=pack(np.zeros((1, 3)), 1e-5),
            feet=None,
            angles=None,
        )
    ],
    "hostile names": lambda: [
        clip(title=NAMED, tag=NAMED, terms=[{"name": NAMED, "value": None, "unit": NAMED}])
    ],
}


@pytest.mark.parametrize("body", BODIES)
def test_bodies_are_drawn_without_requests_or_messages(show, body):
    shown = show(data(*BODIES[body]()), color_scheme="dark")
    for key in ("v", "v", "t", "+", "0", "ArrowRight", "ArrowUp"):
        shown.page.keyboard.press(key)
    shown.run(PICTURES)
    assert shown.events == [shown.uri]
    assert shown.page.title() == "walker"
    assert shown.run(COLOURS) > 20


COLOURS = """() => {
    const { canvas } = gaitsimPage.stage;
    const { width, height } = canvas;
    const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
    return new Set(new Uint32Array(data.buffer)).size;
}"""


def test_unpacked_numbers_are_within_half_a_step(show):
    values = np.random.default_rng(1).normal(0, 50, (40, 3, 2)).cumsum(axis=0)
    shown = show(data(clip()))
    got = shown.run("async (one) => [...(await gaitsim.unpack(one)).values]", pack(values, 1e-6))
    assert np.abs(np.array(got) - values.ravel()).max() <= 0.5001e-6
    angles = shown.run(
        "() => Array.from({length: 61}, (_, i) => gaitsimPage.recordings[0].anglesAt(i)[0])"
    )
    assert np.abs(np.array(angles) - np.sin(np.arange(FRAMES) / RATE)).max() <= 1e-6
    line = shown.page.locator(".curve polyline").get_attribute("points")
    assert len(line.split()) == 2  # a generation in which all failed has no score rather than 0


def test_heights_of_a_terrain_are_as_in_python(show):
    heights = np.random.default_rng(2).uniform(0, 1, (5, 7))
    terrain = Terrain(heights, 0.25, (-0.5, 0.25))
    ground = {"corner": [-0.5, 0.25], "spacing": 0.25, "heights": pack(heights, 1e-6)}
    shown = show(data(clip(ground=ground)))
    places = np.random.default_rng(3).uniform(-1, 2, (50, 2))
    found = shown.run(
        "(places) => places.map(([x, y]) => gaitsimPage.recordings[0].ground.height(x, y))",
        places.tolist(),
    )
    np.testing.assert_allclose(found, terrain.height(places), atol=1e-6)


def falling(depth, **changes):
    """Return a body that flies and sinks by `depth` m."""
    time = np.arange(FRAMES)[:, None, None] / RATE
    base = np.array([[0, 0.5, 0], [0, -0.5, 0], [0.3, 0, 0], [-0.3, 0, 0], [0, 0, 0.1]])
    points = base - [0, 0, depth / 2] * time
    centre = pack(points.mean(axis=1), 1e-4)
    return clip(points=pack(points, 1e-4), centre=centre, flies=True, feet=None, **changes)


EXTENTS = """() => {
    const { bodies, stage } = gaitsimPage;
    stage.scene.updateMatrixWorld();
    stage.orbit.camera.updateMatrixWorld();
    return bodies.map(({ box }) => {
        const at = [0, 1, 2, 3, 4, 5, 6, 7].map((corner) => {
            const place = box.low.map((low, axis) => (corner >> axis) & 1 ? box.high[axis] : low);
            const { x, y } = new gaitsim.THREE.Vector3(...place).project(stage.orbit.camera);
            return [x, y];
        });
        const of = (axis) => at.map((point) => point[axis]);
        return [0, 1].map((axis) => [Math.min(...of(axis)), Math.max(...of(axis))]);
    });
}"""


@pytest.mark.parametrize("depth", [0, 500])
def test_the_champion_is_followed_closely_however_far_others_are(show, depth):
    """All bodies are large at the start, and the champion always, in coordinates from −1 to 1."""
    clips = [
        falling(depth, tag="generation 1", score=-3.0),
        falling(0.5, tag="generation 2", score=9.0),
        falling(depth, tag="generation 3", score=1.0),
    ]
    shown = show(data(*clips, speed=0.25), reduced_motion="reduce")
    assert shown.run("() => [gaitsimPage.selected, gaitsimPage.clock.speed]") == [1, 0.25]
    assert shown.page.locator(".factor").inner_text() == "0.25×"
    for seconds in (0, 2):
        shown.run(f"() => gaitsimPage.seek({seconds})")
        shown.run(PICTURES)
        extents = shown.run(EXTENTS)
        for (left, right), (low, high) in extents if seconds == 0 else [extents[1]]:
            assert max(right - left, high - low) > 0.3
            assert -1 < left < right < 1
            assert -1 < low < high < 1
    shown.page.get_by_role("button", name="generation 3").click()
    shown.run(PICTURES)
    (left, right), (low, high) = shown.run(EXTENTS)[2]
    assert -1 < left < right < 1
    assert -1 < low < high < 1


def test_the_legend_names_the_marks_of_feet(show):
    feet = {**clip()["feet"], "lost": [False, True]}
    for body, names in (
        (clip(), ["left", "right", "on the ground", "in the air"]),
        (clip(feet=feet), ["left", "right", "on the ground", "in the air", "lost"]),
        (flying(), []),
    ):
        assert show(data(body)).page.locator(".key .foot").all_inner_texts() == names


def test_keys_and_the_slider_change_the_time(show):
    shown = show(data(clip()), reduced_motion="reduce")
    page = shown.page
    slider = page.get_by_role("slider", name="Time")
    now = "() => gaitsimPage.clock.now"
    assert shown.run(now) == 0
    page.keyboard.press("ArrowRight")
    assert shown.run(now) == pytest.approx(0.1)
    slider.press("End")
    assert slider.get_attribute("aria-valuetext") == "2.00 seconds of 2.00"
    slider.press("ArrowLeft")
    assert shown.run(now) == pytest.approx(2 - 1 / RATE)
    box = slider.bounding_box()
    slider.click(position={"x": box["width"] / 2, "y": 20})
    assert 0.8 < shown.run(now) < 1.2
    foot = shown.run("() => [...gaitsimPage.bodies[0].pose.centre]")
    assert foot[0] == pytest.approx(0.07 + shown.run(now), abs=1e-3)


def test_playback_and_views_are_announced(show):
    shown = show(data(clip()), reduced_motion="reduce")
    page, status = shown.page, shown.page.get_by_role("status")
    assert not shown.run("() => gaitsimPage.clock.runs")
    page.keyboard.press("Space")
    assert status.inner_text() == "playing"
    before = shown.run("() => gaitsimPage.clock.now")
    page.wait_for_selector(f".readout:not(:text-is('{before:.2f} s'))")
    page.get_by_role("button", name="Pause").press("Space")
    assert status.inner_text().startswith("paused at")
    page.keyboard.press("ArrowDown")
    assert status.inner_text() == "speed 0.75 times"
    page.get_by_label("Speed").press("End")
    assert status.inner_text() == "speed 2 times"
    for view in ("side", "top", "oblique"):
        page.keyboard.press("v")
        assert status.inner_text() == f"{view} view"


def test_every_control_has_a_name_and_can_be_reached_by_tab(show):
    shown = show(data(clip(), clip(tag="generation 1")), reduced_motion="reduce")
    page = shown.page
    reached = []
    focus = """() => {
        const one = document.activeElement;
        const name = one.getAttribute("aria-label") ?? one.innerText;
        const seen = getComputedStyle(one).outlineStyle !== "none";
        return [one.tagName, name || (one.labels?.[0]?.innerText ?? ""), seen];
    }"""
    for _ in range(30):
        page.keyboard.press("Tab")
        tag, name, seen = shown.run(focus)
        if tag == "BODY":
            break
        assert name, tag
        assert seen, name
        reached.append(name)
    wanted = ("Play", "Time", "Speed", "Zoom in", "Light or dark", "Keys and help", "Copy the code")
    assert not {*wanted} - {*(name.strip() for name in reached)}
    assert any(name.startswith("generation 1, score ") for name in reached)
    canvas = page.get_by_role("img", name="walker, in 3D")
    assert "2 feet" in canvas.get_attribute("aria-label")
    before = shown.run("() => gaitsimPage.stage.orbit.azimuth")
    canvas.press("ArrowLeft")
    assert shown.run("() => gaitsimPage.stage.orbit.azimuth") != before
    page.keyboard.press("?")
    page.get_by_role("dialog").get_by_role("button", name="Close").press("Enter")
    assert page.get_by_role("dialog").count() == 0


CONTRAST = """() => {
    const channel = (one) => (one /= 255) <= 0.04045 ? one / 12.92 : ((one + 0.055) / 1.055) ** 2.4;
    const light = (text) => {
        const [r, g, b] = text.match(/[\\d.]+/g).map(Number).map(channel);
        return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const under = (one) => {
        for (; one; one = one.parentElement) {
            const colour = getComputedStyle(one).backgroundColor;
            if (!/, 0\\)$/.test(colour)) return colour;
        }
    };
    return [...document.querySelectorAll(".player *")]
        .filter((one) => [...one.childNodes].some((node) => node.nodeName === "#text"))
        .filter((one) => one.checkVisibility())
        .map((one) => {
            const pair = [light(getComputedStyle(one).color), light(under(one))].sort();
            return [one.className || one.tagName, (pair[1] + 0.05) / (pair[0] + 0.05)];
        })
        .filter(([, ratio]) => ratio < 4.5);
}"""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_texts_have_contrast(show, scheme):
    shown = show(data(clip(), clip()), color_scheme=scheme, reduced_motion="reduce")
    assert shown.run(CONTRAST) == []


@pytest.mark.parametrize("size", [(390, 844), (1280, 800)])
def test_nothing_is_wider_than_the_screen(show, size):
    viewport = {"width": size[0], "height": size[1]}
    shown = show(data(clip(), clip()), viewport=viewport, reduced_motion="reduce")
    assert shown.run("() => document.documentElement.scrollWidth") <= size[0]
    outside = """(wide) => [...document.querySelectorAll("button, input, canvas")]
        .filter((one) => one.checkVisibility() && one.getBoundingClientRect().right > wide + 0.5)
        .map((one) => one.outerHTML.slice(0, 80))"""
    assert shown.run(outside, size[0]) == []


def test_without_webgl_the_texts_remain(show, blind):
    shown = show(data(clip()), browser=blind, reduced_motion="reduce")
    page = shown.page
    assert "WebGL" in page.get_by_role("alert").inner_text()
    assert page.get_by_role("row", name="forward m 2.5").is_visible()
    page.keyboard.press("ArrowRight")
    assert page.locator(".readout").inner_text() == "0.10 s"
    assert shown.events == [shown.uri]
