// The clock, the controls of playback, view and theme, the keys and the help.

const SPEEDS = [1 / 32, 1 / 16, 1 / 8, 0.25, 0.5, 0.75, 1, 1.5, 2];
const NAMES = { iso: "oblique", side: "side", top: "top" };

/**
 * Return the speed a number of steps above or below another.
 * @param {number} speed one of SPEEDS
 * @param {number} steps
 */
const speedBeside = (speed, steps) =>
  SPEEDS[clamp(SPEEDS.indexOf(speed) + steps, 0, SPEEDS.length - 1)];

/**
 * Switch a stage to the next view and announce its name.
 * @param {Stage | undefined} stage
 * @param {Announcer} announcer
 */
function nextView(stage, announcer) {
  if (!stage) return;
  const names = Object.keys(VIEWS);
  const next = names[(names.indexOf(stage.orbit.name) + 1) % names.length];
  stage.view(next);
  announcer.say(`${NAMES[next]} view`);
}

/** A clock that runs, pauses, and restarts at its end. */
class Clock {
  /** @param {number} seconds time at which the clock restarts */
  constructor(seconds) {
    this.end = seconds;
    this.now = 0;
    this.speed = 1;
    this.runs = false;
  }

  /** @param {number} seconds elapsed real time */
  advance(seconds) {
    this.now += seconds * this.speed;
    if (this.now > this.end) this.now = this.end > 0 ? this.now % this.end : 0;
  }
}

class Controls {
  /**
   * @param {object} actions actions of the buttons: play(), speed(factor), view(), theme(),
   *   zoom(factor)
   */
  constructor(actions) {
    this.actions = actions;
    this.play = button("Play", icon("play"), () => actions.play(), "Space");
    this.play.classList.add("play");
    this.speed = element("input", {
      type: "range",
      min: "0",
      max: String(SPEEDS.length - 1),
      step: "1",
      id: "speed",
      input: () => actions.speed(SPEEDS[this.speed.valueAsNumber]),
    });
    this.factor = element("span", { class: "factor", "aria-hidden": "true" });
    this.readout = element("span", { class: "readout" });
    this.help = helpDialog();
    /** Buttons on top of the picture. */
    this.tools = element(
      "div",
      { class: "tools", role: "group", "aria-label": "View" },
      button("Zoom in", icon("plus"), () => actions.zoom(1.25), "+"),
      button("Zoom out", icon("minus"), () => actions.zoom(1 / 1.25), "−"),
      button("Next view", icon("view"), () => actions.view(), "v"),
    );
    this.root = element(
      "div",
      { class: "controls", role: "group", "aria-label": "Playback" },
      this.play,
      this.readout,
      element("label", { class: "speed" }, element("span", { class: "word" }, "Speed"), this.speed),
      this.factor,
      element("span", { class: "gap" }),
      button("Light or dark", icon("theme"), () => actions.theme(), "t"),
      button("Keys and help", "?", () => this.help.showModal(), "?"),
      this.help,
    );
  }

  /** @param {boolean} runs */
  set playing(runs) {
    const label = runs ? "Pause" : "Play";
    this.play.setAttribute("aria-label", label);
    this.play.title = `${label} (Space)`;
    this.play.replaceChildren(icon(runs ? "pause" : "play"));
  }

  /** @param {number} factor */
  set rate(factor) {
    this.speed.value = String(SPEEDS.indexOf(factor));
    this.speed.setAttribute("aria-valuetext", `${factor} times`);
    this.factor.textContent = factor < 0.25 ? `1/${1 / factor}×` : `${factor}×`;
  }
}

/**
 * Listen to keys anywhere on the page, except keys that the focused control uses itself.
 * @param {object} actions actions as in Controls, and step(seconds), faster(steps), reset(), help()
 */
function listenToKeys(actions) {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    const { target, key, shiftKey } = event;
    const inside = (/** @type {string} */ what) => target instanceof Element && target.closest(what);
    if (inside("textarea, select, dialog")) return;
    if (key === " " && inside("button, summary, a")) return;
    if (/^(Arrow|Home|End|Page)/.test(key) && inside("input, .scrolls")) return;
    const byKey = {
      " ": () => actions.play(),
      ArrowLeft: () => actions.step(shiftKey ? -1 : -0.1),
      ArrowRight: () => actions.step(shiftKey ? 1 : 0.1),
      ArrowUp: () => actions.faster(1),
      ArrowDown: () => actions.faster(-1),
      "+": () => actions.zoom(1.25),
      "=": () => actions.zoom(1.25),
      "-": () => actions.zoom(1 / 1.25),
      "−": () => actions.zoom(1 / 1.25),
      0: () => actions.reset(),
      v: () => actions.view(),
      t: () => actions.theme(),
      "?": () => actions.help(),
    };
    const action = byKey[key];
    if (!action) return;
    event.preventDefault();
    action();
  });
}

const KEYS = [
  ["Space", "play or pause"],
  ["← →", "back or forward 0.1 s; with Shift 1 s"],
  ["↑ ↓", "faster or slower"],
  ["+ −", "zoom"],
  ["v", "next view: oblique, side, top"],
  ["0", "reset the view"],
  ["t", "light or dark"],
  ["?", "this help"],
];

function helpDialog() {
  const dialog = element(
    "dialog",
    { class: "help", "aria-labelledby": "help" },
    element("h2", { id: "help" }, "Keys and gestures"),
    element(
      "dl",
      {},
      ...KEYS.flatMap(([key, meaning]) => [
        element("dt", {}, element("kbd", {}, key)),
        element("dd", {}, meaning),
      ]),
    ),
    element(
      "p",
      {},
      "Drag to turn the view; drag with Shift or the right button to move it. The wheel zooms; a ",
      "double click resets the view. On a touch screen, one finger turns the view, two fingers ",
      "zoom and move it. When the picture has focus, the arrow keys turn the view.",
    ),
    element("form", { method: "dialog" }, element("button", {}, "Close")),
  );
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  return dialog;
}
