// The page of an atlas: a map of its cells, and the gait of the selected cell in 3D.

class Atlas {
  /** @param {object} data of the page @param {HTMLElement} root */
  static async open(data, root) {
    const numbers = async (packed) => (packed ? (await gaitsim.unpack(packed)).values : null);
    const axes = await Promise.all(
      data.axes.map(async (axis) => ({
        ...axis,
        places: await numbers(axis.places),
        values: await numbers(axis.values),
      })),
    );
    const [scores, raster] = [await numbers(data.scores), await numbers(data.raster)];
    const highest = scores.reduce((one, other) => Math.max(one, other), -Infinity);
    const gaits = data.gaits && (await Gaits.read(data.gaits));
    const bodies = data.bodies && (await gaitsim.unpackJson(data.bodies));
    return new Atlas({ ...data, axes, scores, raster, highest, bodies }, gaits, root);
  }

  constructor(data, gaits, root) {
    Object.assign(this, { data, gaits });
    this.themes = new gaitsim.Themes(data.theme, (theme) => this._paint(theme));
    this.announcer = new gaitsim.Announcer();
    this.clock = new gaitsim.Clock(1);
    this.map = new CellMap(
      data,
      (member) => this.select(member),
      (member) => this._hint(member),
    );
    this.list = new GaitList(data, this.map, (member) => this.select(member));
    const actions = this._actions();
    this.hint = element("p", { class: "hint", "aria-hidden": "true" });
    this.facts = element("div", { id: "chosen" });
    const side = element("section", { class: "side", "aria-label": "Map" }, ...this._head());
    side.append(this._legend(), this.map.canvas, this.hint);
    const panel = element("section", { class: "panel", "aria-label": "Gait" }, this.facts);
    panel.append(this.list.root, notesOf(data));
    this.root = element("div", { class: gaits ? "atlas" : "atlas flat" }, side);
    if (gaits) this.root.append(...this._picture(actions));
    this.root.append(panel);
    root.replaceChildren(this.root, this.announcer.root);
    if (gaits) this._open();
    if (gaits) gaitsim.listenToKeys(actions);
    this._axes(data.pairs[0] ?? [0]);
    this.select(this.map.order.at(-1), false);
    this._paint(this.themes.theme);
    this.list.show(0);
    if (!this.stage) return;
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) this.controls.playing = false;
    else this.play(true);
  }

  /** Return the title, the choice of axes and the filter. */
  _head() {
    const { data } = this;
    const named = (index) => data.axes[index].name;
    const pairs = data.pairs.map((pair, i) =>
      element("option", { value: i }, pair.map(named).join(" · ")),
    );
    this.pair = element("select", { change: () => this._axes(data.pairs[this.pair.value]) }, ...pairs);
    const step = (data.highest - data.lowest) / 100 || 1;
    this.least = element("input", {
      type: "range",
      min: 0,
      max: 100,
      value: 0,
      input: () => this._filter(this.least.valueAsNumber && data.lowest + step * this.least.valueAsNumber),
    });
    this.bound = element("output", {}, "all");
    return [
      element("h1", {}, data.title),
      data.description ? element("p", { class: "details" }, data.description) : "",
      element("p", { class: "details" }, `Generation ${data.generation}: ${data.filled}`),
      element(
        "p",
        { class: "choices" },
        ...(pairs.length > 1 ? [element("label", {}, "Axes ", this.pair)] : []),
        element("label", {}, "Score from ", this.least, this.bound),
      ),
    ];
  }

  /** Return the legend of colours. */
  _legend() {
    const { lowest, highest, colours, unit } = this.data;
    const below = this.data.below ? "≤ " : "";
    const bar = element("span", { class: "scale" });
    bar.style.background = `linear-gradient(90deg, ${colours.join(", ")})`;
    const [low, high] = [`${below}${numeral(lowest, 3)}`, `${numeral(highest, 3)} ${unit}`];
    return element("p", { class: "scales" }, `score ${low}`, bar, high);
  }

  /** Return the picture and its controls. */
  _picture(actions) {
    this.controls = new gaitsim.Controls(actions);
    this.controls.rate = 1;
    this.canvas = element("canvas", { tabindex: "0", role: "img", "aria-label": "The gait in 3D" });
    const held = element("p", { class: "place" }, "held in place");
    const view = element("section", { class: "view", "aria-label": "Picture" }, this.canvas, held);
    view.append(this.controls.tools);
    const deck = element("section", { class: "deck", "aria-label": "Time" }, this.controls.root);
    return [view, deck];
  }

  /** Build the stage; without WebGL, show a message in place of the picture. */
  _open() {
    const { theme } = this.themes;
    try {
      this.stage = new gaitsim.Stage(this.canvas, theme);
    } catch {
      gaitsim.withoutPicture(this.canvas, "The map and the numbers are still available.");
      return;
    }
    this.ground = new gaitsim.Ground(null, 0, null);
    this.stage.setGround(this.ground);
    this._embody(this.map.order.at(-1));
  }

  /** Put the body of a gait on the stage, if another is on it. @param {number} member */
  _embody(member) {
    const shape = this.data.bodies ? this.data.bodies[member] : this.data.body;
    if (shape === this.shape) return;
    this.shape = shape;
    if (this.body) this.stage.remove(this.body);
    this.body = null;
    if (!shape) return;
    this.rig = new Rig(shape);
    const clip = { ...shape.clip, floor: 0 };
    if (this.rig.boxes) clip.feet = null; // they are inside the boxes
    this.body = new gaitsim.Body(clip, this.themes.theme, 0, 0, this.ground);
    this.stage.add(this.body);
    this.body.show(this.rig.place(this.gaits.at(member, 0)));
    const { low, high, middle } = this.body.box;
    const box = new gaitsim.Box();
    for (const end of [low, high]) box.add(...end.map((value, i) => 1.15 * (value - middle[i])));
    this.stage.lookAt(middle);
    this.stage.frame(box);
  }

  _actions() {
    return {
      play: () => this.play(!this.clock.runs),
      speed: (factor) => this._speed(factor),
      faster: (steps) => this._speed(gaitsim.speedBeside(this.clock.speed, steps)),
      step: (seconds) => {
        const { now, end } = this.clock;
        this.clock.now = (((now + seconds) % end) + end) % end;
        this._show();
      },
      zoom: (factor) => this.stage?.orbit.magnify(factor),
      reset: () => this.stage?.view(this.stage.orbit.name),
      view: () => gaitsim.nextView(this.stage, this.announcer),
      theme: () => this.themes.toggle(),
      help: () => this.controls?.help.showModal(),
    };
  }

  /** @param {number[]} axes indices of the axes of the map */
  _axes(axes) {
    this.map.show(axes);
    this.list.moved();
  }

  /** @param {number} score least score shown; 0, the start of the slider, shows all */
  _filter(score) {
    const all = !this.least.valueAsNumber;
    this.map.filter = all ? -Infinity : score;
    this.bound.textContent = all ? "all" : numeral(score, 3);
    this.list.show(0);
  }

  /**
   * Show a gait.
   * @param {number} member counted from 0
   * @param {boolean} aloud whether to announce it
   */
  select(member, aloud = true) {
    const { data, gaits } = this;
    this.member = member;
    this.map.select(member);
    const row = (name, value, unit) =>
      element(
        "tr",
        {},
        element("th", { scope: "row" }, name),
        element("td", {}, unit ? `${numeral(value)} ${unit}` : numeral(value)),
      );
    const table = element(
      "tbody",
      {},
      row("score", data.scores[member], data.unit),
      ...data.axes.map(({ name, values, unit }) => row(name, values[member], unit)),
    );
    this.facts.replaceChildren(
      element("h2", {}, `Gait ${member + 1} of ${data.count}`),
      element("div", { class: "scrolls", tabindex: "0" }, element("table", {}, table)),
      element("p", { class: "details" }, element("code", {}, `${data.command} ${member + 1}`)),
    );
    if (gaits && !gaits.repeats(member))
      this.facts.append(
        element(
          "p",
          { class: "details" },
          gaits.jointsOf(member)
            ? "The motion ended, perhaps in a fall, before the gait repeated."
            : "This body has no joints.",
        ),
      );
    this.list.selected = member;
    if (aloud) this.announcer.say(this._words(member));
    if (!gaits) return;
    this.clock.end = gaits.seconds(member);
    this.clock.now = 0;
    if (this.stage) this._embody(member);
    this._show();
  }

  /** @param {number} member @returns {string} text with the member's values */
  _words(member) {
    const { scores, unit } = this.data;
    const shown = this.map.axes.map(({ name, values }) => `${name} ${numeral(values[member], 3)}`);
    return [`gait ${member + 1}: score ${numeral(scores[member])} ${unit}`, ...shown].join(", ");
  }

  /** @param {number} member the member under the pointer, or -1 */
  _hint(member) {
    this.hint.textContent = member < 0 ? "" : this._words(member);
  }

  /** @param {boolean} runs */
  play(runs) {
    if (!this.stage) return;
    this.clock.runs = runs;
    this.controls.playing = runs;
    const step = (seconds) => {
      this.clock.advance(seconds);
      this._show();
      return this.clock.runs;
    };
    this.stage.animate(runs ? step : null);
  }

  _speed(factor) {
    this.clock.speed = factor;
    if (this.controls) this.controls.rate = factor;
    this.announcer.say(`speed ${factor} times`);
  }

  _show() {
    if (!this.stage) return;
    this.controls.readout.textContent = gaitsim.secondsText(this.clock.now);
    this.body?.show(this.rig.place(this.gaits.at(this.member, this.clock.now)));
    this.stage.request();
  }

  /** @param {object} theme */
  _paint(theme) {
    const { style } = document.documentElement;
    for (const name of ["ground", "left", "right", "damaged"])
      style.setProperty(`--${name}`, theme[name]);
    if (this.stage) this.stage.theme = theme;
    this.map.draw();
  }

  /** @param {number} member counted from 0 @returns {Float64Array[]} joint angles by frame, rad */
  anglesOf(member) {
    return Array.from({ length: this.gaits.framesOf(member) }, (_, frame) =>
      this.gaits.atFrame(member, frame),
    );
  }
}

gaitsim.register("atlas", (data, root) => Atlas.open(data, root));
