// The page of a steered body: keys and buttons select the controller. The next script, from the
// body's package, simulates the body.

const { element, button, icon, clamp } = gaitsim;
const CODES = {
  ArrowUp: "up", ArrowDown: "down", ArrowLeft: "left", ArrowRight: "right", " ": "space",
};
const VIEWS = [["behind", 180, 18], ["side", -90, 8], ["above", 180, 80]];
const CALM = 0.35; // time constant with which the camera turns to the heading, s
const WIDE = 1.6; // half the width of the picture, in spans of the body
const SPEED = 0.25; // interval over which speeds are measured, s
const PLACES = 10; // points of the path per second, Hz
const TRAIL = 8; // drawn length of the path, s

let simulate = null;
// The viewer's own object is frozen; only pages of this kind accept simulation scripts.
globalThis.gaitsim = Object.freeze({
  ...gaitsim,
  registerSteering: (make) => {
    simulate = make;
  },
});

class Steering {
  /** @param {object} data data of the page @param {HTMLElement} root */
  constructor(data, root) {
    this.data = data;
    this.commands = data.commands;
    this.held = []; // names of held commands, in the order in which they were pressed
    this.latched = null; // command selected by a click without a pointer, as by a screen reader
    this.view = 0;
    this.best = 0;
    this.themes = new gaitsim.Themes(data.theme, (theme) => this._paint(theme));
    this.announcer = new gaitsim.Announcer();
    this.canvas = element("canvas", {
      tabindex: "0", role: "img", "aria-label": `${data.title}: the body in 3D`,
    });
    this.place = element("p", { class: "place", "aria-hidden": "true" });
    this.message = element("p", { class: "ending", role: "alert", hidden: true });
    this.picture = element(
      "section", { class: "view", "aria-label": "Picture" }, this.canvas, this.place, this.message);
    this.pad = new Pad(this.commands, (name, down) => this.press(name, down), (name) => {
      this.latched = name;
    });
    this.root = element(
      "div", { class: "steering" }, this.picture, this.pad.root, this._panel());
    root.replaceChildren(this.root, this.announcer.root);
    this._open();
    this._listen();
    this._paint(this.themes.theme);
    this.restart();
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) this.pause(true);
  }

  _panel() {
    const rows = ["in the air", "altitude", "climb", "speed", "heading"];
    this.cells = rows.map(() => element("td", {}));
    const table = element("table", {}, ...rows.map((name, i) =>
      element("tr", {}, element("th", { scope: "row" }, name), this.cells[i])));
    const { title, description, made } = this.data;
    this.pauser = button("Pause", icon("pause"), () => this.pause(!this.paused), "p");
    return element(
      "aside", { class: "panel", "aria-label": "About this flight" },
      element("h1", {}, title),
      description ? element("p", {}, description) : null,
      element(
        "div", { class: "controls", role: "group", "aria-label": "Flight" },
        element(
          "button", { type: "button", title: "Restart (r)", click: () => this.restart() },
          "Restart"),
        this.pauser,
        button("Zoom out", icon("minus"), () => this.zoom(1 / 1.25), "−"),
        button("Zoom in", icon("plus"), () => this.zoom(1.25), "+"),
        button("Change the view", icon("view"), () => this.nextView(), "v"),
        button("Light or dark", icon("theme"), () => this.themes.toggle(), "t")),
      table,
      element(
        "p", { class: "how" },
        "Hold a key or a button to give its network control; the change takes a moment. On release, ",
        element("b", {}, this.commands[0].name), " is in control. Bars show the networks' shares."),
      element("p", { class: "made" }, made ? `Created with ${made}` : ""));
  }

  /** Build the stage; without WebGL, show a message in place of the picture. */
  _open() {
    const { clip } = this.data;
    try {
      this.stage = new gaitsim.Stage(this.canvas, this.themes.theme);
    } catch {
      gaitsim.withoutPicture(this.canvas, "The numbers are still available.");
      return;
    }
    this.ground = new gaitsim.Ground(null, 0, null);
    this.body = new gaitsim.Body(clip, this.themes.theme, 0, 0, this.ground);
    this.stage.add(this.body);
    this.stage.setGround(this.ground);
    const reach = WIDE * clip.span;
    this.stage.frame(new gaitsim.Box().add(0, 0, 0, reach / 2));
  }

  _listen() {
    // Capture arrow keys before the picture, which would turn the camera.
    addEventListener("keydown", (event) => this._pressed(event, true), { capture: true });
    addEventListener("keyup", (event) => this._pressed(event, false), { capture: true });
    addEventListener("blur", () => {
      this.held = [];
    });
  }

  /** @param {KeyboardEvent} event @param {boolean} down */
  _pressed(event, down) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    // Space presses the focused button, unless it is the button of a command.
    const pressed = event.target instanceof Element && event.target.closest("button:not(.key)");
    if (down && pressed && event.key === " ") return;
    const command = this.commands.find(({ key }) => key === CODES[event.key]);
    const actions = {
      r: () => this.restart(), p: () => this.pause(!this.paused), v: () => this.nextView(),
      t: () => this.themes.toggle(), "+": () => this.zoom(1.25), "=": () => this.zoom(1.25),
      "-": () => this.zoom(1 / 1.25), "−": () => this.zoom(1 / 1.25),
    };
    if (!command && !(down && actions[event.key])) return;
    event.preventDefault();
    event.stopPropagation();
    if (command) this.press(command.name, down);
    else if (!event.repeat) actions[event.key]();
  }

  /** Press or release a command. @param {string} name @param {boolean} down */
  press(name, down) {
    if (down && this.held.at(-1) === name) return;
    this.held = this.held.filter((one) => one !== name);
    if (down) {
      this.held.push(name);
      this.latched = null;
    }
  }

  /** The name of the current command: that of the last key pressed, else the first command. */
  get command() {
    return this.held.at(-1) ?? this.latched ?? this.commands[0].name;
  }

  restart() {
    this.flight = simulate(this.data.body);
    this.seconds = this.frames = this.heading = this.looking = 0;
    this.left = 0; // elapsed seconds not yet simulated
    this.path = [];
    this.ending = "";
    this.latched = null;
    this.message.hidden = true;
    this._advance(1);
    this._view();
    this.stage?.lookAt(this.state.centre);
    this.pause(false);
    this._show(0);
  }

  /** @param {boolean} paused */
  pause(paused) {
    this.paused = paused;
    const label = paused ? "Resume" : "Pause";
    this.pauser.setAttribute("aria-label", label);
    this.pauser.title = `${label} (p)`;
    this.pauser.replaceChildren(icon(paused ? "play" : "pause"));
    if (this.ending) return;
    this.announcer.say(paused ? "paused" : "flying");
    if (this.stage) this.stage.animate(paused ? null : (seconds) => this._tick(seconds));
    else if (!paused) this._flyUnseen(performance.now());
  }

  /** Fly without a stage. @param {number} last ms */
  _flyUnseen(last) {
    requestAnimationFrame((now) => {
      const passed = clamp((now - last) / 1000, 0, 0.25);
      if (!this.paused && this._tick(passed)) this._flyUnseen(now);
    });
  }

  /** Simulate the elapsed time; return whether the flight continues. @param {number} passed s */
  _tick(passed) {
    this.left += passed;
    const frames = Math.floor(this.left * this.flight.frameRate);
    this.left -= frames / this.flight.frameRate;
    // Frame by frame, to stop in the frame that hits the ground.
    for (let n = 0; n < frames && !this.ending; n += 1) this._advance(1);
    this._show(passed);
    return !this.ending && !this.paused;
  }

  _advance(frames) {
    const state = this.flight.advance(this.command, frames);
    this.frames += frames;
    this.seconds = this.frames / this.flight.frameRate;
    let lowest = Infinity;
    for (let i = 2; i < state.ends.length; i += 3) lowest = Math.min(lowest, state.ends[i]);
    const every = Math.max(1, Math.round(this.flight.frameRate / PLACES));
    this.state = state;
    if (this.frames % every === 0) this.path.push([this.seconds, ...state.centre]);
    if (state.failed)
      this._end(`The simulation failed after ${this.seconds.toFixed(1)} s: the body is too fast.`);
    else if (lowest < 0 && this.data.clip.flies)
      this._end(`It hit the ground after ${this.seconds.toFixed(1)} s.`);
  }

  /** @param {string} words */
  _end(words) {
    this.ending = words;
    this.best = Math.max(this.best, this.seconds);
    const best = this.best > this.seconds ? ` Best: ${this.best.toFixed(1)} s.` : "";
    this.message.replaceChildren(
      `${words}${best} `,
      element("button", { type: "button", click: () => this.restart() }, "Fly again (r)"));
    this.message.hidden = false;
  }

  /** Show the current state. @param {number} passed seconds since the last picture */
  _show(passed) {
    const { state, stage } = this;
    this._facts();
    this.pad.show(this.command, state.shares);
    if (!stage) return;
    const { ends } = this.data.clip;
    const points = new Float64Array(3 * (Math.max(...ends) + 1));
    ends.forEach((point, end) => points.set(state.ends.subarray(3 * end, 3 * end + 3), 3 * point));
    this.body.show({ points, poses: null, feet: null, touching: null, centre: state.centre });
    const path = this.path.slice(-TRAIL * PLACES).map(([, ...place]) => place);
    this.body.trail(Float64Array.from(path.flat()), path.length);
    const before = this.looking;
    const away = ((this.heading - this.looking + 540) % 360) - 180;
    this.looking += away * (1 - Math.exp(-passed / CALM));
    stage.orbit.azimuth += this.looking - before;
    stage.follow(state.centre, passed);
  }

  /** Write altitude, speeds and heading. */
  _facts() {
    const { state, path, seconds } = this;
    const from = path.findLast(([when]) => when <= seconds - SPEED) ?? path[0];
    const gone = from && seconds > from[0] ? seconds - from[0] : Infinity;
    const moved = state.centre.map((place, axis) => (from ? place - from[axis + 1] : 0) / gone);
    if (state.facts.heading !== undefined) this.heading = (state.facts.heading * 180) / Math.PI;
    const signed = (value, digits) =>
      `${value < 0 ? "−" : "+"}${Math.abs(value).toFixed(digits)}`;
    const words = [
      `${seconds.toFixed(1)} s`,
      `${state.centre[2].toFixed(2)} m`,
      `${signed(moved[2], 2)} m/s`,
      `${Math.hypot(moved[0], moved[1]).toFixed(2)} m/s`,
      state.facts.heading === undefined ? "–" : `${signed(this.heading, 0)}°`,
    ];
    this.place.textContent = `${words[0]}   altitude ${words[1]}`;
    words.forEach((word, i) => {
      this.cells[i].textContent = word;
    });
  }

  nextView() {
    this.view = (this.view + 1) % VIEWS.length;
    this._view();
    this.announcer.say(`view from ${VIEWS[this.view][0]}`);
  }

  _view() {
    if (!this.stage) return;
    const [, azimuth, elevation] = VIEWS[this.view];
    Object.assign(this.stage.orbit, { azimuth: azimuth + this.looking, elevation });
    this.stage.orbit.fit();
  }

  /** @param {number} factor */
  zoom(factor) {
    this.stage?.orbit.magnify(factor);
  }

  /** @param {object} theme */
  _paint(theme) {
    document.documentElement.style.setProperty("--ground", theme.ground);
    if (this.stage) this.stage.theme = theme;
  }
}

gaitsim.register("steering", (data, root) => new Steering(data, root));
