// The worker of the page that evolves a spider: it evolves at the asked pace and answers the page.

const SLICE = 30; // ms
const DICTIONARY = new TextEncoder().encode(DATA.dictionary);
const FOREIGN =
  "The text is not the code of a spider that this page can play. Copy the whole code again, from " +
  "'gaitsim1-' to its last character. The page plays codes of gaits with the encoding 'sine' at " +
  "1.5 Hz and the fitness 'spider-walk', such as those of: gaitsim share spider";

/** Return a number as TOML. @param {number} value */
const real = (value) => (Number.isInteger(value) ? `${value}.0` : String(value));

/** Return the experiment of a run with some settings. @param {Settings} settings */
function experimentOf({ seed, start, lost, weights }) {
  const values = { seed, start: `"${start}"`, damage: lost ? `["${lost} lost"]` : "[]" };
  for (const [name, weight] of Object.entries(weights)) values[name] = real(weight);
  const changed = (line, key) => (key in values ? `${key}=${values[key]}` : line);
  return DATA.experiment.replace(/^(\w+)=.*$/gm, changed);
}

/** Return the settings of the experiment of a code; throw if the page cannot play it. @param {string} text */
function settingsIn(text) {
  const found = new Map();
  let section = "";
  for (const line of text.split("\n")) {
    section = /^\[(\w+)\]$/.exec(line)?.[1] ?? section;
    const [, key, value] = /^(\w+) *= *([^#]*)/.exec(line) ?? [];
    if (key) found.set(`${section}.${key}`, value.trim());
  }
  const required = {
    "organism.plugin": '"spider"', "organism.encoding": '"sine"', "organism.frequency": "1.5",
    "organism.world": "{}", "worlds.number": "0", "worlds.cases": "[]", "fitness.plugin": '"spider-walk"',
  };
  const damage = /^\[(?:"([LR][1-4]) lost")?\]$/.exec(found.get("organism.damage"));
  if (!damage || Object.entries(required).some(([key, value]) => found.get(key) !== value))
    throw new Error("another body or fitness");
  const weights = {};
  for (const name of Object.keys(DATA.weights)) {
    weights[name] = Number(found.get(`fitness.${name}`) ?? NaN);
    if (!(weights[name] >= 0)) throw new Error(name);
  }
  const every = found.get("organism.symmetry") === '"none"';
  return { genes: (every ? 2 : 1) * DATA.lower.length, settings: { lost: damage[1] ?? "", weights } };
}

/** Return a stride of the gait in the kernels' memory: angles, and the body's motion in each frame. */
function strideOf(kernels) {
  const { stride, frames } = DATA;
  const [angles, pose] = [kernels.view("angles"), kernels.view("pose")];
  const joints = angles.length / frames;
  // The last whole stride: after a fall, a body may need some frames to settle.
  const first = frames - 1 - stride;
  const turned = Float32Array.from({ length: stride * joints }, (_, i) =>
    angles[(i % joints) * frames + first + Math.floor(i / joints)]);
  const steps = Float32Array.from({ length: stride * 3 }, (_, i) => {
    const at = first + Math.floor(i / 3);
    const [x, y, turn] = [0, 1, 2].map((axis) => pose[axis * frames + at + 1] - pose[axis * frames + at]);
    const yaw = pose[2 * frames + at] + turn / 2;
    const [cosine, sine] = [Math.cos(yaw), Math.sin(yaw)];
    return [cosine * x + sine * y, cosine * y - sine * x, turn][i % 3];
  });
  return { angles: turned, steps };
}

class Evolution {
  constructor(kernels) {
    this.kernels = kernels;
    this.evolver = null;
    this.pace = 0; // generations per second; 0 pauses
    this.timer = null;
  }

  start({ settings, run }) {
    this.evolver = new Evolver(this.kernels, settings);
    this.number = run;
    this.shown = -Infinity;
    this.due = performance.now();
    this._schedule();
  }

  change({ settings }) {
    if (!this.evolver.number) return this.start({ settings, run: this.number });
    this.evolver.change(settings);
    this.shown = -Infinity;
    this._report(true);
  }

  run({ pace }) {
    this.pace = pace;
    this.due = performance.now();
    this._schedule();
  }

  _schedule() {
    clearTimeout(this.timer);
    if (!this.pace || !this.evolver || this._ended) return;
    this.timer = setTimeout(() => this._evolve(), this.due - performance.now());
  }

  _evolve() {
    // Timers may wait 4 ms, so several generations follow each other; messages come in between.
    const begun = performance.now();
    do {
      this.evolver.next();
      this._report();
      this.due += 1000 / this.pace;
    } while (performance.now() > this.due && performance.now() < begun + SLICE && !this._ended);
    // After a pause of the browser, the missed generations are not caught up.
    this.due = Math.max(this.due, performance.now() - 1000);
    this._schedule();
  }

  get _ended() {
    return this.evolver.number >= DATA.generations;
  }

  /** @param {boolean} changed whether other settings hold from here */
  _report(changed = false) {
    const { evolver, kernels } = this;
    const { number, scores, best, mean, settings } = evolver;
    const terms = Object.fromEntries(TERMS.map((name, i) => [name, evolver.terms[best][i]]));
    const message = { kind: "generation", run: this.number, number, best: scores[best], mean, terms };
    if (scores[best] > this.shown) {
      this.shown = scores[best];
      kernels.score(evolver.genomes[best]);
      Object.assign(message, { stride: strideOf(kernels), lost: settings.lost });
    }
    if (changed || number === 1) message.settings = settings;
    if (number === DATA.compared && evolver.history) message.fingerprint = evolver.fingerprint();
    postMessage(message);
  }

  code() {
    if (!this.evolver.number) {
      this.evolver.next(); // a page that is paused at the start has no champion yet
      this._report();
    }
    const { number, scores, best, genomes, settings } = this.evolver;
    const gait = { generation: number, score: scores[best], genome: genomes[best] };
    postMessage({ kind: "code", code: codeOf({ ...gait, text: experimentOf(settings) }) });
  }

  async play({ text }) {
    try {
      const { genome, score, text: experiment } = await readCode(text);
      const { genes, settings } = settingsIn(experiment);
      const inside = (gene, i) => {
        const like = i < genes / 2 ? 0 : DATA.lower.length - 1; // an amplitude, or an angle
        return gene >= DATA.lower[like] && gene <= DATA.upper[like];
      };
      if (genome.length !== genes || !genome.every(inside)) throw new Error("genes");
      this.kernels.prepare(settings);
      const terms = this.kernels.score(genome);
      const found = terms.reduce((one, other) => one + other, 0);
      const stride = strideOf(this.kernels);
      postMessage({ kind: "played", claimed: score, score: found, stride, lost: settings.lost });
    } catch {
      postMessage({ kind: "refused", message: FOREIGN });
    } finally {
      if (this.evolver) this.kernels.prepare(this.evolver.settings);
    }
  }
}

const ready = Kernels.load().then((kernels) => new Evolution(kernels));
ready.then(() => postMessage({ kind: "ready" }), () => postMessage({ kind: "fail" }));
onmessage = async ({ data }) => {
  const worker = await ready;
  worker[data.kind](data);
};
