"""The page that evolves a spider: the same bits as in Python, codes both ways, and its controls."""

import hashlib
import re
from dataclasses import replace

import pytest
from javascript import CHROMIUM, call
from run_helpers import evolve_run

import gaitsim as gs
from gaitsim.experiment import load_experiment
from gaitsim.sharing.challenge import Challenge, verify_challenge
from gaitsim_page.playground import experiment, page, worker_script, write_page

EVOLVE = """
const kernels = await Kernels.load();
return data.runs.map(([seed, start, lost, weights, generations]) => {
  const settings = { seed, start, lost, weights: { ...DATA.weights, ...weights } };
  const evolver = new Evolver(kernels, settings);
  for (let n = 0; n < generations; n++) evolver.next();
  const { number, scores, best, genomes } = evolver;
  const gait = { generation: number, score: scores[best], genome: genomes[best] };
  const code = codeOf({ ...gait, text: experimentOf(settings) });
  const found = { fingerprint: evolver.fingerprint(), score: gait.score, code };
  evolver.change({ ...settings, lost: "R3", weights: { ...settings.weights, yaw_weight: 1 } });
  for (let n = 0; n < 3; n++) evolver.next();
  return { ...found, later: hexOf(sha256(joined(evolver.genomes))) };
});
"""
PLAY = """
let found = null;
globalThis.postMessage = (message) => { found = message; };
const answers = [];
for (const text of data) {
  await (await ready).play({ text });
  answers.push(found);
}
return answers;
"""


@pytest.fixture(scope="module")
def script():
    """The script of the page's worker, which runs outside a worker as well."""
    quiet = "globalThis.postMessage = () => {}; let onmessage;"
    return quiet + worker_script(experiment()).removeprefix('"use strict";')


def python_run(folder, seed, start, lost, weights, generations):
    """Return the run in Python of the same settings."""
    options = {"organism.damage": [f"{lost} lost"] if lost else []}
    options |= {f"fitness.{name}": weight for name, weight in weights.items()}
    size = {"population": 50, "generations": generations}
    search = gs.evolve("spider-genetic", **size, seed=seed, start=start, set=options, out=folder)
    return ended(search).run


def ended(search):
    """Return a search after its last generation."""
    for _ in search:
        pass
    return search


def test_a_seed_gives_the_bits_of_python_and_a_code_to_verify(script, tmp_path):
    weights = {"slip_weight": 1.3, "safe_margin": 0.03}
    runs = [(0, "random", "", {}, 12), (7, "body", "L2", weights, 8)]
    for number, (run, found) in enumerate(
        zip(runs, call(script, EVOLVE, {"runs": runs}), strict=True)
    ):
        here = python_run(tmp_path / str(number), *run)
        rebuild = "if a kernel of the spider has changed: python -m gaitsim_page.kernels"
        assert found["fingerprint"] == here.fingerprint(), rebuild
        challenge = Challenge.read(found["code"])
        assert challenge.score == found["score"]
        checked = verify_challenge(challenge)
        assert checked.identical
        assert checked.version_differences == ()
        assert len(found["code"]) < 700
        more = f"evolution.generations={run[-1] + 3}"
        changes = "organism.damage=['R3 lost']", "fitness.yaw_weight=1"
        later = evolve_run(here.path, None, more, *changes).finished.genomes
        assert found["later"] == hashlib.sha256(later.tobytes()).hexdigest()


def test_codes_are_played_and_foreign_hostile_and_damaged_ones_refused(script, tmp_path):
    mine = python_run(tmp_path / "mine", 1, "body", "R4", {}, 2).share()
    options = {"organism.symmetry": "none"}
    every = ended(gs.evolve("spider", generations=1, population=5, set=options)).champion.share()
    foreign = ended(gs.evolve("millipede", generations=1)).champion.share()
    damaged = mine[:-5] + ("A" if mine[-5] != "A" else "B") + mine[-4:]
    hostile = "gaitsim1-<img src=x onerror=alert(1)>", "gaitsim1-AAAAAAAAAAAA", "", "gaitsim1-////"
    challenge = Challenge.read(mine)
    outside = replace(challenge, genome=1e300 * challenge.genome).code
    bad = [foreign, outside, damaged, mine[:-9], *hostile]
    texts = [f"> see {mine[:40]}\n> {mine[40:]}\n", every, *bad]
    own, all_legs, *refused = call(script, PLAY, texts)
    for answer, code in ((own, mine), (all_legs, every)):
        assert answer["kind"] == "played"
        assert answer["score"] == answer["claimed"] == Challenge.read(code).score
    assert own["lost"] == "R4"
    assert {one["kind"] for one in refused} == {"refused"}
    assert len({one["message"] for one in refused}) == 1


def test_a_page_is_one_small_file_whose_policy_allows_only_what_is_in_it():
    made = page(seed=3)
    assert made == page(seed=3)
    assert len(made) < 300_000
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]*)"', made.decode())
    assert policy.startswith("default-src 'none';")
    assert policy.endswith("'wasm-unsafe-eval'; worker-src blob:")
    assert len(re.findall(r"'sha256-[\w+/]{43}='", policy)) == 3  # viewer, the page, boot
    assert "unsafe-eval" not in policy.replace("wasm-unsafe-eval", "")


FLAGS = ["--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-sync"]
CONTROLS = """() => [
  ...document.querySelectorAll("button, select, input, textarea, summary, canvas")
].map((one) => {
  const name = one.getAttribute("aria-label") || one.labels?.[0]?.innerText;
  return [one.tagName, name || one.innerText];
})"""


@pytest.fixture(scope="module")
def browser():
    """Chromium."""
    if CHROMIUM is None:
        pytest.skip("needs Chromium")
    playwright = pytest.importorskip("playwright.sync_api", reason="needs Playwright")
    options = {"executable_path": CHROMIUM, "args": [*FLAGS, "--enable-unsafe-swiftshader"]}
    with playwright.sync_playwright() as driver:
        yield driver.chromium.launch(**options)


@pytest.fixture
def visit(browser, tmp_path):
    """A function that opens the page, without a network, in the state that options give."""
    events, contexts = [], []

    def visit(seed=2, without=b"", **options):
        path = tmp_path / "page.html"
        write_page(path, seed)
        path.write_bytes(path.read_bytes().replace(without, b""))
        contexts.append(browser.new_context(offline=True, **options))
        opened = contexts[-1].new_page()
        opened.on("request", lambda found: events.append(found.url))
        if not without:
            for event in ("console", "pageerror", "dialog"):
                opened.on(event, lambda found: events.append(str(found)))
        opened.goto(path.as_uri())
        return opened

    yield visit
    for context in contexts:
        context.close()
    assert [one for one in events if not one.startswith(("file:", "blob:null/"))] == []


@pytest.mark.slow
def test_seeds_give_the_bits_of_python_in_a_browser(visit, tmp_path):
    opened = visit(seed=2)
    opened.get_by_label("Generations").select_option("as fast as possible")
    opened.get_by_text("The same run on your computer").click()
    for seed in (2, 3, 4):
        fingerprint = opened.get_by_text("Fingerprint after 100 generations")
        fingerprint.wait_for()
        found = fingerprint.inner_text()
        assert f"--seed {seed} " in opened.get_by_label("Commands of the same run").input_value()
        opened.get_by_role("button", name="Learn again").click()
        here = python_run(tmp_path / str(seed), seed, "random", "", {}, 100)
        assert here.fingerprint() in found


@pytest.mark.slow
def test_visitors_change_the_rules_and_carry_codes(visit):
    opened = visit(viewport={"width": 390, "height": 844}, has_touch=True)
    opened.get_by_text("The same run on your computer").click()
    opened.get_by_text("the champion walks").wait_for()
    opened.get_by_role("button", name="Pause").tap()
    opened.get_by_label("Missing leg").select_option("L2")
    opened.get_by_text("What the score punishes").click()
    opened.get_by_label("slip weight").press("ArrowRight")
    assert opened.get_by_label("slip weight").get_attribute("aria-valuetext") == "0.55"
    opened.get_by_role("button", name="Copy its code").tap()
    opened.get_by_label("Code of the champion").wait_for()
    code = opened.get_by_label("Code of the champion").input_value()
    challenge = Challenge.read(code)
    assert verify_challenge(challenge).identical
    assert challenge.experiment.organism.damage == ("L2 lost",)
    assert challenge.experiment.fitness.slip_weight == 0.55
    commands = opened.get_by_label("Commands of the same run").input_value()
    assert "gaitsim resume learned" in commands
    assert "'organism.damage=[\"L2 lost\"]' --set fitness.slip_weight=0.55" in commands
    place = opened.get_by_label("Code of a gait")
    for text, answer in (
        ("<img src=x onerror=alert(1)>", "not the code"),
        (code, "as the code says"),
    ):
        place.fill(text)
        opened.get_by_role("button", name="Play").tap()
        opened.get_by_text(answer).wait_for()
    opened.get_by_text("The gait of the code").wait_for()
    opened.get_by_role("button", name="Back to the champion").tap()
    opened.get_by_text("the champion walks").wait_for()
    assert [one for one in opened.evaluate(CONTROLS) if not one[1]] == []
    assert opened.evaluate("document.documentElement.scrollWidth") <= 390


@pytest.mark.slow
def test_after_the_last_generation_visitors_can_only_learn_again(visit, monkeypatch):
    options = {"evolution.population": 50, "evolution.generations": 3, "search.start": "random"}
    short = load_experiment("spider-genetic", options)
    monkeypatch.setattr("gaitsim_page.playground.experiment", lambda seed: short)
    opened = visit(seed=2)
    opened.get_by_text("The same run on your computer").click()
    opened.get_by_role("button", name="Finished").wait_for()
    assert opened.get_by_role("button", name="Finished").is_disabled()
    opened.get_by_role("button", name="Learn again").click()
    from playwright.sync_api import expect

    # The new run may end before anyone sees a button 'Pause'.
    commands = opened.get_by_label("Commands of the same run")
    expect(commands).to_have_value(re.compile("--seed 3 "))


@pytest.mark.slow
def test_visitors_who_reduce_motion_begin_by_themselves(visit):
    opened = visit(reduced_motion="reduce")
    opened.get_by_text("Press Continue to begin").wait_for()
    opened.get_by_role("button", name="Copy its code").click()
    opened.get_by_text("Generation 1:").wait_for()


@pytest.mark.slow
@pytest.mark.parametrize("missing", [b" 'wasm-unsafe-eval'", b"worker-src blob:"])
def test_a_browser_without_webassembly_or_workers_is_told(visit, missing):
    opened = visit(without=missing)
    opened.get_by_text("cannot evolve the spider").wait_for()
    assert opened.get_by_role("button", name="Learn again").is_disabled()
