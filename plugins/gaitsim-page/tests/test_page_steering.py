"""Steering pages: keys and buttons select commands, and the ground ends the flight."""

import re

import pytest
from cart import CART
from javascript import CHROMIUM, FLAGS
from kite import SCRIPT, fly_kites

from gaitsim.contracts import SteeringPage
from gaitsim.errors import ContractError, GaitsimError
from gaitsim.steering import controllers_of
from gaitsim_page.steering import page, write_page


@pytest.fixture
def kite(puppet, puppets, monkeypatch):
    """The experiment of a kite."""
    fly_kites(monkeypatch, puppets.Puppet)
    return puppet()


def test_a_page_is_one_small_file_with_the_script_of_the_body(kite, tmp_path):
    controllers = controllers_of(kite, {})
    made = page(kite, controllers)
    assert made == page(kite, controllers)
    assert len(made) < 300_000
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]*)"', made.decode())
    assert len(re.findall(r"'sha256-[\w+/]{43}='", policy)) == 4  # viewer, page, body, boot
    summary = write_page(kite, controllers, tmp_path / "kite.html")
    assert "3 commands" in summary
    assert (tmp_path / "kite.html").read_bytes() == made


@pytest.mark.parametrize(
    ("given", "kind", "message"),
    [
        (None, GaitsimError, "web pages cannot simulate the body 'puppet'"),
        ("a script", ContractError, "returned a str from steering_page"),
        (SteeringPage(SCRIPT, {"a": object()}), ContractError, "package gaitsim-puppets"),
    ],
)
def test_a_body_without_a_page_is_reported(kite, puppets, monkeypatch, given, kind, message):
    monkeypatch.setattr(puppets.Puppet, "steering_page", lambda self, controllers: given)
    with pytest.raises(kind, match=message):
        page(kite, controllers_of(kite, {}))


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium")
def test_held_keys_and_buttons_steer_until_the_body_hits_the_ground(kite, tmp_path):
    playwright = pytest.importorskip("playwright.sync_api", reason="needs Playwright")
    write_page(kite, controllers_of(kite, {}), tmp_path / "kite.html")
    address = (tmp_path / "kite.html").as_uri()
    requests, messages = [], []
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        opened = browser.new_context(offline=True).new_page()
        opened.on("request", lambda request: requests.append(request.url))
        for event in ("console", "pageerror"):
            opened.on(event, lambda found: messages.append(str(found)))
        opened.goto(address)
        opened.wait_for_selector(".steering")

        def now():
            return opened.evaluate(
                "({ command: gaitsimPage.command, height: gaitsimPage.state.centre[2], "
                "ending: gaitsimPage.ending })"
            )

        def fly(seconds):
            """Pause the clock and simulate a number of seconds."""
            opened.evaluate(f"gaitsimPage.pause(true); gaitsimPage._tick({seconds})")

        opened.evaluate("gaitsimPage.restart()")
        fly(0)
        start = now()["height"]
        opened.keyboard.down("ArrowUp")
        fly(0.5)
        assert now() == {
            "command": "rise",
            "height": pytest.approx(start + 0.5, abs=0.02),
            "ending": "",
        }
        opened.keyboard.down("Space")
        assert now()["command"] == "sink"
        opened.keyboard.up("Space")
        assert now()["command"] == "rise"
        opened.keyboard.up("ArrowUp")
        assert now()["command"] == "stay"
        button = opened.get_by_role("button", name="sink")
        button.hover()
        opened.mouse.down()
        assert now()["command"] == "sink"
        fly(0.1)
        assert button.get_attribute("aria-pressed") == "true"
        fly(3)
        opened.mouse.up()
        assert "hit the ground" in now()["ending"]
        assert "hit the ground" in opened.get_by_role("alert").inner_text()
        opened.keyboard.press("r")
        assert now()["ending"] == ""
        opened.evaluate("gaitsimPage.pause(true)")
        browser.close()
    assert requests == [address]
    assert messages == []


def test_a_body_that_pages_cannot_simulate_is_refused(gaitsim, cart, tmp_path):
    (tmp_path / "cart.toml").write_text(CART)
    said = gaitsim("steer-page", "cart.toml", "--out", "a.html", code=2).stderr
    assert "web pages cannot simulate the body 'cart'" in said.replace("\n", " ")
    assert not [*tmp_path.glob("*.html")]
