// The player: recorded motions on the stage, with the timeline, the controls and the panel.

const ROOM = 4; // maximum extent of the first picture of several bodies, in body lengths

class Player {
  /**
   * @param {object} data data of the page
   * @param {Recording[]} recordings
   * @param {HTMLElement} root
   */
  constructor(data, recordings, root) {
    this.data = data;
    this.recordings = recordings;
    this.themes = new Themes(data.theme, (theme) => this._paint(theme));
    this.announcer = new Announcer();
    this.clock = new Clock(Math.max(...recordings.map((one) => one.seconds)));
    this.selected = championOf(recordings);
    const actions = this._actions();
    this.controls = new Controls(actions);
    this.timeline = new Timeline(this.clock.end, (seconds) => this.seek(seconds));
    this.canvas = element("canvas", {
      tabindex: "0",
      role: "img",
      "aria-label": describe(data, recordings),
    });
    this.place = element("p", { class: "place" });
    this.scale = element("span", {});
    this.view_ = element(
      "section",
      { class: "view", "aria-label": "Picture" },
      this.canvas,
      recordings.length > 1 ? this._legend() : null,
      this.controls.tools,
      this.place,
      element("p", { class: "key" }, ...this._key(), this.scale),
    );
    const deck = element("section", { class: "deck", "aria-label": "Time" }, this.timeline.root);
    deck.prepend(this.controls.root);
    const kinds_ = [data.page?.embedded && "embedded", recordings.length > 2 && "several"];
    const class_ = ["player", ...kinds_].filter(Boolean).join(" ");
    this.root = element("div", { class: class_ }, this.view_, deck, panelOf(data, this.announcer));
    root.replaceChildren(this.root, this.announcer.root);
    this._open();
    listenToKeys(actions);
    this.controls.rate = this.clock.speed = data.speed ?? 1;
    this.seek(0);
    this._paint(this.themes.theme);
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) this.controls.playing = false;
    else this.play(true);
  }

  /** Build the stage; without WebGL, show a message in place of the picture. */
  _open() {
    const { theme } = this.themes;
    try {
      this.stage = new Stage(this.canvas, theme);
    } catch {
      withoutPicture(this.canvas, "The numbers and the footfalls are still available.");
      this.place.remove();
      this.controls.tools.remove();
      return;
    }
    const lanes = lanesOf(this.recordings);
    const floor = Math.min(...this.recordings.map(({ ground }) => ground.floor));
    this.bodies = this.recordings.map((recording, number) => {
      if (recording.ground.level) recording.ground.floor = floor;
      const body = new Body(recording.clip, theme, lanes[number], number, recording.ground);
      this.stage.add(body);
      return body;
    });
    const uneven = this.recordings.find(({ ground }) => !ground.level);
    this.stage.setGround(uneven?.ground ?? this.recordings[0].ground);
    this.lanes = lanes;
    this.stage.frame(this._box());
    this.stage.listeners.push(() => this._showGridStep());
  }

  /**
   * Return a box, relative to the aim of the selected body, that contains it throughout, and as
   * many of its neighbours at the start as fit.
   */
  _box() {
    const own = this.recordings[this.selected].box;
    const box = new Box();
    this.recordings.forEach((recording, number) => {
      const side = this.lanes[number] - this.lanes[this.selected];
      const { low, high } = number === this.selected ? own : recording.boxAt(0);
      for (const [x, y, z] of [low, high]) box.add(x, y + side, z);
    });
    const most = ROOM * Math.max(...own.size);
    for (let axis = 0; axis < 3; axis++) {
      const more = box.size[axis] - own.size[axis];
      const share = more > 0 ? Math.min((most - own.size[axis]) / more, 1) : 0;
      box.low[axis] = own.low[axis] + share * (box.low[axis] - own.low[axis]);
      box.high[axis] = own.high[axis] + share * (box.high[axis] - own.high[axis]);
    }
    return box;
  }

  /** Return the actions of buttons and keys. */
  _actions() {
    return {
      play: () => this.play(!this.clock.runs),
      speed: (factor) => this.speed(factor),
      faster: (steps) => this.speed(speedBeside(this.clock.speed, steps)),
      step: (seconds) => this.seek(clamp(this.clock.now + seconds, 0, this.clock.end)),
      zoom: (factor) => this.stage?.orbit.magnify(factor),
      reset: () => this.stage?.view(this.stage.orbit.name),
      view: () => nextView(this.stage, this.announcer),
      theme: () => {
        this.themes.toggle();
        this.announcer.say(`${this.themes.name} theme`);
      },
      help: () => this.controls.help.showModal(),
    };
  }

  /** @param {boolean} runs */
  play(runs) {
    this.clock.runs = runs;
    this.controls.playing = runs;
    this.announcer.say(runs ? "playing" : `paused at ${this.clock.now.toFixed(2)} seconds`);
    const step = (/** @type {number} */ seconds) => {
      this.clock.advance(seconds);
      this._show();
      return this.clock.runs;
    };
    if (this.stage) this.stage.animate(runs ? step : null);
    else if (runs) this._tick(step);
  }

  /** Play without a stage. @param {(seconds: number) => boolean} step */
  _tick(step, last = performance.now()) {
    requestAnimationFrame((now) => {
      if (this.clock.runs && step(Math.max(now - last, 0) / 1000)) this._tick(step, now);
    });
  }

  /** @param {number} factor */
  speed(factor) {
    this.clock.speed = factor;
    this.controls.rate = factor;
    this.announcer.say(`speed ${factor} times`);
  }

  /** @param {number} seconds */
  seek(seconds) {
    this.clock.now = seconds;
    this._show();
    this.stage?.request();
  }

  _show() {
    const { now } = this.clock;
    this._showTime(now);
    if (!this.stage) return;
    const poses = this.recordings.map((one) => one.at(now));
    poses.forEach((pose, number) => {
      this.bodies[number].show(pose);
      this.bodies[number].trail(this.recordings[number].values.centre, pose.frame);
    });
    const [x, y, z] = poses[this.selected].aim;
    this.stage.lookAt([x, y + this.lanes[this.selected], z]);
  }

  /**
   * Update the time; while playing only ten times a second, as text takes longer to update than the picture.
   * @param {number} now s
   */
  _showTime(now) {
    this.timeline.head.style.transform = `translateX(${this.timeline._x(now)}px)`;
    const time = performance.now();
    if (this.clock.runs && time - (this.timeShown ?? 0) < 100) return;
    this.timeShown = time;
    this.timeline.time = now;
    this.controls.readout.textContent = secondsText(now);
    if (this.stage) this._showPosition(this.recordings[this.selected].at(now));
  }

  /** Show distance, altitude and command of the selected body. @param {Pose & {frame: number}} pose */
  _showPosition({ centre, frame }) {
    const { clip, values } = this.recordings[this.selected];
    const gone = Math.hypot(centre[0] - values.centre[0], centre[1] - values.centre[1]);
    const parts = [`distance ${lengthText(gone)}`];
    if (clip.flies) parts.push(`altitude ${lengthText(centre[2])}`);
    const said = clip.said.filter(([first]) => first <= frame).at(-1);
    if (said) parts.push(said[1]);
    this.place.textContent = parts.join("   ");
  }

  /** Update the step of the grid after each picture. */
  _showGridStep() {
    const text = `grid ${lengthText(this.stage.gridStep)}`;
    if (this.scale.textContent !== text) this.scale.textContent = text;
  }

  /** Return the legend of the marks of feet. */
  _key() {
    const sides = new Set(this.recordings.flatMap(({ clip }) => clip.feet?.sides ?? []));
    const named = ["left", "right"].filter((side) => sides.has(side));
    // The sides of a planar body are near and far; the camera is on its right.
    const planar = this.recordings[0].clip.feet?.names.some((name) => /^(near|far)\b/.test(name));
    const word = planar ? { left: "far", right: "near" } : { left: "left", right: "right" };
    const marks = named.map((side) => [side, word[side]]);
    if (this.recordings.some(({ feet }) => feet))
      marks.push(["stance", "on the ground"], ["swing", "in the air"]);
    if (this.recordings.some(({ clip }) => clip.feet?.lost.includes(true)))
      marks.push(["lost", "lost"]);
    return marks.map(([kind, text]) => element("span", { class: `foot ${kind}` }, text));
  }

  /** Return the names of the bodies, as buttons that select the footfalls to show. */
  _legend() {
    const choices = this.recordings.map(({ clip }, number) =>
      element(
        "button",
        {
          type: "button",
          "aria-label": `${clip.tag || clip.title}, score ${numeral(clip.score)}`,
          "aria-pressed": String(number === this.selected),
          click: () => this.select(number),
        },
        dotOf(number),
        element("bdi", {}, clip.tag || clip.title),
        element("small", {}, numeral(clip.score)),
      ),
    );
    this.choices = choices;
    const label = "Bodies: select one to show its footfalls";
    return element("div", { class: "legend", role: "group", "aria-label": label }, ...choices);
  }

  /** @param {number} number index of the body whose footfalls to show */
  select(number) {
    this.selected = number;
    this.choices?.forEach((choice, i) => choice.setAttribute("aria-pressed", String(i === number)));
    this.timeline.show(this.recordings[number], this.themes.theme, number);
    this.stage?.frame(this._box());
    this.seek(this.clock.now);
  }

  /** @param {object} theme */
  _paint(theme) {
    const { style } = document.documentElement;
    theme.bodies.forEach((colour, i) => style.setProperty(`--body-${i}`, colour));
    for (const name of ["ground", "left", "right", "damaged"])
      style.setProperty(`--${name}`, theme[name]);
    if (this.stage) this.stage.theme = theme;
    this.timeline.show(this.recordings[this.selected], theme, this.selected);
  }
}

/** Return the index of the body with the best score, of several the last. @param {Recording[]} recordings */
function championOf(recordings) {
  const scores = recordings.map(({ clip }) => clip.score ?? -Infinity);
  return scores.lastIndexOf(Math.max(...scores));
}

/** Return a description of the picture for screen readers. */
function describe(data, recordings) {
  const each = recordings.map(({ clip, seconds, feet, values }) => {
    const end = values.centre.length - 3;
    const gone = Math.hypot(
      values.centre[end] - values.centre[0],
      values.centre[end + 1] - values.centre[1],
    );
    const how = clip.flies ? "a flying body" : `a body with ${feet} feet`;
    return `${clip.tag || clip.title}: ${how} moves ${lengthText(gone)} in ${secondsText(seconds)}`;
  });
  return `${data.title}, in 3D. ${each.join(". ")}.`;
}
