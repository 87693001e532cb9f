"""Pages for browsers: their content, and that only the viewer is executed."""

import json
import re
from html import unescape
from html.parser import HTMLParser

import numpy as np
import pytest

import gaitsim as gs
from gaitsim.contracts import Measure, Skeleton
from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment
from gaitsim.individual import Individual
from gaitsim.render.encoder import ENOUGH, movement_frequency
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim_page.document import document
from gaitsim_page.player import FPS, MAX_CURVE_POINTS, page, page_data

EVIL = (
    "é</script><script>document.title = 'evil'; alert(1)</script><!--\"'><img src=x onerror="
    "alert(2)>&lt;\u2028\u2029\x00\x1b[31m\x85\u202e\u2066{policy}]]>\\u003c${alert(3)}`"
)
LINE = EVIL.partition("\u2028")[0]  # descriptions have one line


@pytest.fixture(scope="module")
def spider(spider_run) -> Individual:
    return spider_run.individual()


def data_of(found: bytes) -> dict:
    """Return the data of a page."""
    (text,) = re.findall(r'id="data">(.*?)</script>', found.decode(), re.DOTALL)
    return json.loads(text)


def test_pages_start_in_slow_motion_if_the_movement_is_fast(spider):
    fly = load_experiment("fly", {"organism.duration": 1.0})
    (wing_beat,) = fly.starts().values()
    flying = Individual(fly, 0.0, {}, 1, wing_beat)
    frequency = movement_frequency(flying.skeleton)
    speed = page_data([flying])["speed"]
    assert page_data([spider])["speed"] == 1
    assert FPS / (frequency * speed) >= ENOUGH > FPS / (2 * frequency * speed)


def test_pages_are_reproducible_and_small(spider, spider_run):
    several = [spider_run.individual(number) for number in (1, 3)]
    one = page([spider], spider_run)
    assert one == page([RunSnapshot(spider_run.path).individual()], spider_run)
    assert len(json.dumps(data_of(one))) <= 150_000
    assert len(one) <= 1_000_000
    assert gs.verify(data_of(one)["code"]).identical
    assert [clip["tag"] for clip in data_of(page(several))["clips"]] == [
        "generation 1",
        "generation 3",
    ]


def test_long_curves_are_thinned(spider, spider_run):
    run = RunSnapshot(spider_run.path)
    best = np.append(np.arange(4000.0), np.inf)
    run.__dict__["history"] = {"generation": np.arange(1.0, 4002), "best": best}
    curve = page_data([spider], run)["curve"]
    assert len(curve["best"]) == MAX_CURVE_POINTS
    assert (curve["generation"][0], curve["generation"][-1]) == (1, 4001)
    assert (curve["best"][0], curve["best"][-1]) == (0.0, None)


class Tags(HTMLParser):
    """Collect the elements of a page with their attributes."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found, self.texts = [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.found.append((tag, sorted(dict(attributes))))

    def handle_data(self, data):
        self.texts.append(data)


@pytest.fixture
def hostile(puppet_run, puppets, monkeypatch):
    """A page in which every text is hostile, and a plain page of the same body."""

    def skeleton(self, motion, individual):
        segments = np.zeros((5, 3, 2, 3))
        segments[:, :, 1, 2] = [0.1, 0.2, 0.3]
        contacts, touching = segments[:, :1, 0], np.ones((5, 1), bool)
        names = (EVIL, EVIL + "b", EVIL + "c")
        return Skeleton(segments, names, 4.0, contacts, touching, (EVIL,), damaged=(EVIL,))

    plain = page([puppet_run().individual()])
    joints = (EVIL, EVIL, EVIL)
    reach = Measure(np.ones(1), EVIL, EVIL)
    monkeypatch.setattr(puppets.Puppet, "skeleton", skeleton)
    monkeypatch.setattr(puppets.Puppet, "joint_names", lambda self: joints)
    monkeypatch.setattr(puppets.Puppet, "measures", lambda self, motion: {EVIL: reach})
    run = puppet_run(f"description={LINE}")
    path = run.path.rename(EVIL.replace("/", "").replace("\x00", "")[:80])
    return page([RunSnapshot(path).individual()], RunSnapshot(path)), plain


def test_no_text_of_a_run_becomes_markup(hostile):
    evil, plain = (Tags(one.decode()) for one in hostile)
    assert evil.found == plain.found
    assert data_of(hostile[0])["description"] == LINE
    raw = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069]")
    assert not raw.search(hostile[0].decode())


def test_the_policy_of_a_page_allows_only_its_scripts():
    text = document("a", "player", {}, ["1 < 2"]).decode()
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]*)"', text)
    assert policy.startswith("default-src 'none';")
    assert "http" not in policy
    assert len(re.findall(r"'sha256-[\w+/]{43}='", policy)) == 3  # viewer, the script, boot
    with pytest.raises(ValueError, match="JSON"):
        document("a", "player", {"score": np.inf})


def test_a_notebook_shows_a_page_in_a_sandboxed_frame(spider):
    frame = gs.view(spider)._repr_html_()
    (found,) = Tags(frame).found
    assert found == ("iframe", ["allow", "sandbox", "srcdoc", "style", "title"])
    inside = re.findall(r'srcdoc="([^"]*)"', frame)[0]
    shown = data_of(unescape(inside).encode())
    assert shown["page"] == {"embedded": True}
    assert len(shown["curve"]["best"]) == 3
    with pytest.raises(GaitsimError, match="without an individual"):
        gs.view()
