// The page on which a visitor evolves a spider. The search runs in a worker (evolver_worker.js); the
// page draws the champion, and never runs or interprets what is in a pasted code.

const { element, drawing, numeral } = gaitsim;
const PACES = [["1 a second", 1], ["10 a second", 10], ["as fast as possible", 1e6]];
const [WIDE, HIGH] = [300, 110]; // of the curve
const TURNS = 4; // largest weight, relative to its default
const TRAIL = 400; // points of the path, one a frame
const UNSUPPORTED =
  "This browser cannot evolve the spider: it has no Web Workers or no WebAssembly with SIMD, or they " +
  "are disabled. Try a newer browser, or install gaitsim and run: gaitsim run spider";

const section = (name, title, ...children) =>
  element("section", { class: name }, element("h2", {}, title), ...children);
const press = (label, click, title) => element("button", { type: "button", title, click }, label);
const choice = (options, change) =>
  element("select", { change }, ...options.map(([label, value]) => element("option", { value }, label)));
const area = (label, more) =>
  element("textarea", { rows: "3", spellcheck: "false", "aria-label": label, ...more });

/** Return the options that differ from earlier settings. @returns {string[]} */
function setsOf({ lost, weights }, before) {
  const sets = Object.entries(weights)
    .filter(([name, weight]) => weight !== before.weights[name])
    .map(([name, weight]) => `fitness.${name}=${weight}`);
  const damage = `'organism.damage=[${lost ? `"${lost} lost"` : ""}]'`;
  return lost === (before.lost ?? "") ? sets : [damage, ...sets];
}

class Playground {
  /** @param {object} data data of the page @param {HTMLElement} root */
  constructor(data, root) {
    this.data = data;
    this.legs = data.body.clip.feet.names;
    this.settings = { seed: data.seed, start: "random", lost: "", weights: { ...data.weights } };
    this.themes = new gaitsim.Themes(data.theme, (theme) => this._paint(theme));
    this.announcer = new gaitsim.Announcer();
    this.rig = new Rig(data.body);
    this.place = { x: 0, y: 0, yaw: 0 }; // of the body on the ground
    this.frame = 0;
    this.path = [];
    this.points = []; // best and mean score of each generation
    // It stands with straight legs until the first generation.
    const stride = { angles: new Float32Array(3 * this.legs.length), steps: new Float32Array(3) };
    this.champion = { stride, lost: "" };
    this.runs = 0;
    this.still = matchMedia("(prefers-reduced-motion: reduce)").matches; // moves only on demand
    this.actions = {
      play: () => this.run(!this.running),
      view: () => gaitsim.nextView(this.stage, this.announcer),
      zoom: (factor) => this.stage?.orbit.magnify(factor),
      theme: () => this.themes.toggle(),
      reset: () => this.stage?.view(this.stage.orbit.name),
      faster: (steps) => this.faster(steps),
      ...{ speed() {}, step() {}, help() {} },
    };
    root.replaceChildren(this._page(), this.announcer.root);
    this._tell("Loading …");
    this._open();
    this._paint(this.themes.theme);
    gaitsim.listenToKeys(this.actions);
    this._work();
  }

  _page() {
    const { title, description, made } = this.data;
    this.canvas = element("canvas", { tabindex: "0", role: "img", "aria-label": "The champion in 3D" });
    this.caption = element("p", { class: "caption", "aria-hidden": "true" });
    const { tools } = new gaitsim.Controls(this.actions);
    this.panel = element(
      "aside", { class: "panel", "aria-label": "Evolution" },
      element("h1", {}, title), element("p", {}, description), this._curve(), this._controls(),
      this._rules(), this._home(), this._guest(), this._repeat(),
      element("p", { class: "made" }, `Created with ${made}`));
    return element(
      "div", { class: "playground" },
      element("section", { class: "view", "aria-label": "Picture" }, this.canvas, this.caption, tools),
      this.panel);
  }

  _curve() {
    this.lines = ["mean", "best"].map((name) => drawing("polyline", { class: name }));
    this.marks = drawing("g", { class: "marks" });
    this.curve = drawing(
      "svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, role: "img", "aria-label": "Score by generation" },
      this.marks, ...this.lines);
    this.readout = element("p", { class: "ends" });
    return section("curve", "Score: metres in 10 s, less penalties", this.curve, this.readout);
  }

  _controls() {
    this.runner = press("Pause", () => this.run(!this.running), "Pause or continue (space)");
    const again = press("Learn again", () => this.again(), "A new seed: other random movements");
    this.pace = choice(PACES, () => this.run(true));
    this.pace.value = 10;
    return element(
      "div", { class: "choices", role: "group", "aria-label": "Run" },
      this.runner, again, element("label", {}, "Generations ", this.pace));
  }

  _rules() {
    const change = (name) => (event) => this.change({ [name]: event.target.value });
    const lost = choice([["none", ""], ...this.legs.map((leg) => [leg, leg])], change("lost"));
    const start = choice([["random movements", "random"], ["a walk made by hand", "body"]], change("start"));
    this.costs = new Map(); // elements with the champion's penalties
    const rows = Object.entries(this.data.weights).map(([name, usual]) => {
      const [output, cost] = [element("output", {}), element("b", {})];
      const help = element("small", { id: `help-${name}` }, `${this.data.help[name]} `, cost);
      const slider = element("input", {
        type: "range", min: 0, max: 10 * TURNS, value: 10, "aria-describedby": help.id,
        input: () => show(),
        change: () => this.change({ weights: { ...this.settings.weights, [name]: weight() } }),
      });
      const weight = () => (usual * slider.valueAsNumber) / 10;
      const show = () => {
        output.textContent = numeral(weight());
        slider.setAttribute("aria-valuetext", output.textContent);
      };
      show();
      this.costs.set(name, cost);
      return element("div", {}, element("label", {}, `${name.replaceAll("_", " ")} `, slider), output, help);
    });
    return section(
      "rules", "Change the rules while it learns",
      element(
        "p", { class: "choices" },
        element("label", {}, "Missing leg ", lost), element("label", {}, "Begin with ", start)),
      element("details", {}, element("summary", {}, "What the score punishes"), ...rows));
  }

  _home() {
    this.code = area("Code of the champion", { readonly: true, hidden: true });
    this.copied = element("p", { role: "status" });
    return section(
      "code", "Take the champion home",
      element("p", {}, "Anyone can check its score: ", element("code", {}, "gaitsim verify CODE")),
      press("Copy its code", () => this._send({ kind: "code" })), this.code, this.copied);
  }

  _guest() {
    this.guest = area("Code of a gait", { placeholder: "gaitsim1-…" });
    this.answer = element("p", { role: "status" });
    const play = press("Play", () => this._send({ kind: "play", text: this.guest.value }));
    this.back = press("Back to the champion", () => this._leave());
    this.back.hidden = true;
    return section(
      "code", "Play a code",
      element("p", {}, "Paste the code of a spider, as ", element("code", {}, "gaitsim share"), " prints it."),
      this.guest, element("p", { class: "choices" }, play, this.back), this.answer);
  }

  _repeat() {
    this.command = area("Commands of the same run", { readonly: true });
    this.print = element("p", { class: "print" });
    return element(
      "details", { class: "code" }, element("summary", {}, "The same run on your computer"),
      element("p", {}, "These commands give the same bits:"), this.command, this.print);
  }

  /** Build the stage; without WebGL, show a message in place of the picture. */
  _open() {
    try {
      this.stage = new gaitsim.Stage(this.canvas, this.themes.theme);
    } catch {
      gaitsim.withoutPicture(this.canvas, "The spider still learns.");
      return;
    }
    this.ground = new gaitsim.Ground(null, 0, null);
    this.stage.setGround(this.ground);
    const reach = 0.6 * this.data.body.clip.span;
    this.stage.frame(new gaitsim.Box().add(0, 0, 0, reach));
    this._wearChampion();
    this.stage.animate((seconds) => this._walk(seconds));
  }

  /** Draw the body without a leg. @param {string} lost */
  _wear(lost) {
    if (!this.stage) return;
    if (this.worn !== lost) this._build(lost);
    this._show(0);
  }

  _build(lost) {
    this.worn = lost;
    if (this.body) this.stage.remove(this.body);
    const { clip } = this.data.body;
    const leg = this.legs.indexOf(lost);
    const outline = clip.limbs.length - 3 * this.legs.length;
    const limbs = clip.limbs.filter((_, i) => leg < 0 || Math.floor((i - outline) / 3) !== leg);
    const feet = { ...clip.feet, lost: this.legs.map((name) => name === lost) };
    this.body = new gaitsim.Body({ ...clip, limbs, feet, floor: 0 }, this.themes.theme, 0, 0, this.ground);
    this.stage.add(this.body);
  }

  /** Walk on; a new gait continues where the last one is. @param {number} seconds */
  _walk(seconds) {
    const { stride } = this;
    if (this.still && !this.running && !this.guesting) return true;
    const count = stride.steps.length / 3;
    let left = seconds * this.data.frameRate;
    while (left > 0) {
      const share = Math.min(left, Math.floor(this.frame + 1) - this.frame);
      const [forward, sideways, turn] = stride.steps.subarray(3 * (Math.floor(this.frame) % count));
      const { place } = this;
      const yaw = place.yaw + (share * turn) / 2;
      place.x += share * (Math.cos(yaw) * forward - Math.sin(yaw) * sideways);
      place.y += share * (Math.sin(yaw) * forward + Math.cos(yaw) * sideways);
      place.yaw += share * turn;
      this.frame += share;
      left -= share;
      if (Number.isInteger(this.frame)) this.path.push([place.x, place.y, 0]);
    }
    this.path = this.path.slice(-TRAIL);
    this._show(seconds);
    return true;
  }

  _show(seconds) {
    const { stride, place, rig } = this;
    const count = stride.steps.length / 3;
    const joints = stride.angles.length / count;
    const [one, other] = [0, 1].map((more) => joints * ((Math.floor(this.frame) + more) % count));
    const share = this.frame % 1;
    const angles = Float64Array.from({ length: joints }, (_, i) =>
      (1 - share) * stride.angles[one + i] + share * stride.angles[other + i]);
    const leg = this.legs.indexOf(this.worn);
    const pose = rig.place(angles, leg);
    const [cosine, sine] = [Math.cos(place.yaw), Math.sin(place.yaw)];
    for (const points of [pose.points, pose.feet, pose.centre])
      for (let i = 0; i < points.length; i += 3) {
        const [x, y] = [points[i], points[i + 1]];
        points[i] = place.x + cosine * x - sine * y;
        points[i + 1] = place.y + sine * x + cosine * y;
      }
    this.body.show(pose);
    this.body.trail(Float64Array.from(this.path.flat()), this.path.length);
    this.stage.follow([place.x, place.y, pose.centre[2] / 2], seconds);
  }

  /** Start the worker, from a text in the page, as the page's policy allows no other source. */
  _work() {
    try {
      const source = URL.createObjectURL(new Blob([WORKER], { type: "text/javascript" }));
      this.worker = new Worker(source);
    } catch {
      this._fail();
      return;
    }
    this.worker.onerror = () => this._fail();
    this.worker.onmessage = ({ data }) => this[`_${data.kind}`](data);
    document.addEventListener("visibilitychange", () => this._pace());
  }

  _fail() {
    if (this.failed) return;
    this.failed = true;
    this._tell("");
    this.panel.prepend(element("p", { class: "failure", role: "alert" }, UNSUPPORTED));
    for (const one of this.panel.querySelectorAll("button, select, input, textarea")) one.disabled = true;
  }

  _send(message) {
    this.worker?.postMessage(message);
  }

  _ready() {
    this.begin();
    this._tell("Press Continue to begin");
    this.run(!this.still);
  }

  /** Start a run with the current settings. */
  begin() {
    cancelAnimationFrame(this.pending);
    this.pending = null;
    this.points = [];
    this.stages = [];
    this.print.textContent = "";
    this._leave();
    this.runs += 1;
    this._send({ kind: "start", settings: this.settings, run: this.runs });
  }

  again() {
    this.settings = { ...this.settings, seed: (this.settings.seed + 1) % 2 ** 31 };
    this.begin();
    this.run(true);
    this.announcer.say(`learning again, with seed ${this.settings.seed}`);
  }

  /** Change settings; the population continues with them. @param {object} changed */
  change(changed) {
    this.settings = { ...this.settings, ...changed };
    if (changed.start !== undefined) return this.again();
    this._send({ kind: "change", settings: this.settings });
    this.announcer.say("rules changed");
  }

  /** @param {boolean} running */
  run(running) {
    const ended = this.points.length >= this.data.generations;
    this.running = running && !ended;
    this.runner.disabled = ended;
    this.runner.textContent = ended ? "Finished" : running ? "Pause" : "Continue";
    const words = `${ended ? "finished" : "paused"}. ${this.curve.getAttribute("aria-label")}`;
    this.announcer.say(this.running ? "learning" : words);
    this._pace();
  }

  /** Choose another number of generations a second. @param {number} steps */
  faster(steps) {
    const next = gaitsim.clamp(this.pace.selectedIndex + steps, 0, PACES.length - 1);
    this.pace.selectedIndex = next;
    this.announcer.say(`generations: ${PACES[next][0]}`);
    this._pace();
  }

  _pace() {
    const pace = this.running && !document.hidden ? Number(this.pace.value) : 0;
    this._send({ kind: "run", pace });
  }

  _generation({ run, number, best, mean, terms, stride, lost, settings, fingerprint }) {
    if (run !== this.runs) return; // sent before the worker heard of the new run
    this.points[number - 1] = [best, mean];
    if (settings) this._began(number, settings);
    this.champion = { ...this.champion, terms };
    if (stride) {
      Object.assign(this.champion, { stride, lost });
      if (!this.guesting) this._wearChampion();
    }
    if (fingerprint) this.print.textContent = `Fingerprint after ${number} generations: ${fingerprint}`;
    if (number === this.data.generations) this.run(false);
    this.pending ??= requestAnimationFrame(() => this._report());
  }

  _wearChampion() {
    this.stride = this.champion.stride;
    this._wear(this.champion.lost);
  }

  /** Write the numbers and draw the curve, at most once a picture. */
  _report() {
    this.pending = null;
    const { points } = this;
    const [best, mean] = points.at(-1);
    const far = numeral(this.champion.terms.forward, 3);
    this._tell(`Generation ${points.length}: the champion walks ${far} m in 10 s`);
    this.readout.replaceChildren(
      element("span", { class: "best" }, `best ${numeral(best, 3)}`),
      element("span", {}, `generation ${points.length}`),
      element("span", { class: "mean" }, `mean ${numeral(mean, 3)}`));
    for (const [name, cost] of this.costs) {
      const term = this.champion.terms[name.replace("_weight", "")];
      cost.textContent = term === undefined ? "" : `(${numeral(term, 2)} m)`;
    }
    const wide = Math.max(points.length - 1, 30);
    const values = points.flat();
    const [low, top] = [Math.max(Math.min(...values), -3), Math.max(...values, 1)];
    const x = (generation) => (WIDE * generation) / wide;
    const y = (score) => Math.min(4 + (HIGH - 8) * (1 - (score - low) / (top - low)), HIGH);
    this.lines.forEach((line, i) =>
      line.setAttribute("points", points.map((point, at) => `${x(at)},${y(point[1 - i])}`).join(" ")));
    this.marks.replaceChildren(
      drawing("line", { x1: 0, x2: WIDE, y1: y(0), y2: y(0) }),
      ...this.stages.slice(1).map(({ after }) =>
        drawing("line", { x1: x(after - 1), x2: x(after - 1), y1: 0, y2: HIGH })));
    const scores = `best ${numeral(best, 3)} m, mean ${numeral(mean, 3)} m`;
    this.curve.setAttribute("aria-label", `Score: ${scores} in generation ${points.length}`);
  }

  /** Write about the champion, unless another gait is shown. @param {string} now */
  _tell(now) {
    this.now = now;
    if (!this.guesting) this.caption.textContent = now;
  }

  async _code({ code }) {
    this.code.value = code;
    this.code.hidden = false;
    this.code.select();
    let words = "Copied.";
    try {
      await navigator.clipboard.writeText(code);
    } catch {
      words = "Selected; press Ctrl+C to copy.";
    }
    this.copied.textContent = words;
  }

  _played({ claimed, score, stride, lost }) {
    this.guesting = true;
    this.stride = stride;
    this._wear(lost);
    this.back.hidden = false;
    const same = Object.is(claimed, score);
    this.answer.textContent = same
      ? `The score is ${numeral(score)} m, as the code says, to the last bit.`
      : `The code says ${numeral(claimed)}, but the score here is ${numeral(score)} m.`;
    this.caption.textContent = "The gait of the code";
  }

  _refused({ message }) {
    this.answer.textContent = message;
  }

  _leave() {
    this.guesting = false;
    this.back.hidden = true;
    this.answer.textContent = "";
    this._tell(this.now);
    this._wearChampion();
  }

  /**
   * Write the commands of the same run.
   * @param {number} number generation after which other settings hold; 1 at the beginning
   * @param {object} settings
   */
  _began(number, settings) {
    const { preset, population, compared } = this.data;
    const after = this.stages.length ? number : 0;
    this.stages = [...this.stages.filter((stage) => stage.after < after), { after, settings }];
    const lines = this.stages.map((stage, i) => {
      const last = this.stages[i + 1]?.after ?? stage.after + compared;
      const sets = setsOf(stage.settings, this.stages[i - 1]?.settings ?? this.data);
      if (i) return [`gaitsim resume learned --generations ${last}`, ...sets].join(" --set ");
      const size = [`evolution.population=${population}`, `evolution.generations=${last}`];
      const head = `gaitsim run ${preset} --seed ${settings.seed} --out learned`;
      return [head, ...size, `search.start=${settings.start}`, ...sets].join(" --set ");
    });
    const check = this.stages.length > 1 ? "share" : "show --fingerprint";
    this.command.value = [...lines, `gaitsim ${check} learned`].join("\n");
  }

  /** @param {object} theme */
  _paint(theme) {
    const { style } = document.documentElement;
    for (const name of ["ground", "left", "right", "damaged"]) style.setProperty(`--${name}`, theme[name]);
    if (this.stage) this.stage.theme = theme;
  }
}

gaitsim.register("playground", (data, root) => new Playground(data, root));
