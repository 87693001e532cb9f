// The search of the page that evolves a spider, in a worker. `DATA` is the object that playground.py
// makes. Numbers are computed in the order in which NumPy and gaitsim compute them, so
// that the same seed gives the same bits.

const SCRATCH = 61440; // addresses in the module's memory; its stack is below, its constants at 0
const BASE = 65536;
const PURPOSE = { initial: 0, selection: 1, crossover: 2, mutation: 3 };
const MASK = (1n << 64n) - 1n;
const KINDS = {
  f4: Float32Array, f8: Float64Array, i8: BigInt64Array, u8: BigUint64Array, u1: Uint8Array,
};
const TERMS = ["forward", "slip", "drift", "yaw", "slope", "support", "vibration", "jerk"];

/** The generator PCG64 (O'Neill 2014), seeded as `np.random.default_rng` seeds it. */
class Random {
  /** @param {number[]} seeds whole numbers below 2³² */
  constructor(seeds) {
    // NumPy's SeedSequence (O'Neill 2015, "Developing a seed_seq alternative").
    const { imul } = Math;
    const pool = [0, 0, 0, 0];
    let constant = 0x43b0d7e5;
    const hashed = (value, multiplier) => {
      value ^= constant;
      constant = imul(constant, multiplier);
      value = imul(value, constant);
      return (value ^ (value >>> 16)) >>> 0;
    };
    const mixed = (one, other) => {
      const found = imul(0xca01f9dd, one) - imul(0x4973f715, other);
      return (found ^ (found >>> 16)) >>> 0;
    };
    pool.forEach((_, i) => (pool[i] = hashed(seeds[i] ?? 0, 0x931e8875)));
    for (let from = 0; from < 4; from++)
      for (let to = 0; to < 4; to++)
        if (from !== to) pool[to] = mixed(pool[to], hashed(pool[from], 0x931e8875));
    constant = 0x8b51f9dd;
    const words = Array.from({ length: 8 }, (_, i) => BigInt(hashed(pool[i % 4], 0x58f38ded)));
    const [a, b, c, d] = [0, 2, 4, 6].map((i) => words[i] | (words[i + 1] << 32n));
    this.increment = (((c << 64n) | d) << 1n) | 1n;
    this.state = 0n;
    this._step();
    this.state += (a << 64n) | b;
    this._step();
    this.kept = null; // the upper half of a number whose lower half was drawn
  }

  _step() {
    this.state = BigInt.asUintN(128, this.state * 0x2360ed051fc65da44385df649fccf645n + this.increment);
  }

  /** Draw 64 bits. */
  bits() {
    this._step();
    const [word, turn] = [(this.state >> 64n) ^ (this.state & MASK), this.state >> 122n];
    return ((word >> turn) | (word << (64n - turn))) & MASK;
  }

  /** Draw a number from [0, 1). */
  next() {
    return Number(this.bits() >> 11n) * 2 ** -53;
  }

  _word() {
    if (this.kept !== null) {
      const word = this.kept;
      this.kept = null;
      return word;
    }
    const both = this.bits();
    this.kept = both >> 32n;
    return both & 0xffffffffn;
  }

  /** Draw a whole number below `end`, from 1 to 2³² (Lemire 2019). @param {number} end */
  below(end) {
    if (end === 1) return 0;
    const range = BigInt(end);
    const threshold = 0x100000000n % range;
    let product = this._word() * range;
    while ((product & 0xffffffffn) < threshold) product = this._word() * range;
    return Number(product >> 32n);
  }
}

/** Draw a number of successes, as gaitsim/portable/binomial_draws.py does. */
function binomial(random, n, p, { exp, log }) {
  const q = 1 - p;
  const spread = n * p * q;
  if (n * p <= 30) {
    const bound = Math.min(n, n * p + 10 * Math.sqrt(spread + 1));
    const none = exp(n * log(q));
    let [successes, chance, rest] = [0, none, random.next()];
    while (rest > chance) {
      successes += 1;
      if (successes > bound) [successes, chance, rest] = [0, none, random.next()];
      else {
        rest -= chance;
        chance = ((n - successes + 1) * p * chance) / (successes * q);
      }
    }
    return successes;
  }
  const peak = n * p + p;
  const mode = Math.floor(peak);
  const middle = mode + 0.5;
  const half = Math.floor(2.195 * Math.sqrt(spread) - 4.6 * q) + 0.5;
  const [left, right] = [middle - half, middle + half];
  const height = 0.134 + 20.5 / (15.3 + mode);
  const rate = (slope) => slope * (1 + slope / 2);
  const leftRate = rate((peak - left) / (peak - left * p));
  const rightRate = rate((right - peak) / (right * q));
  const sides = half * (1 + 2 * height);
  const leftTail = sides + height / leftRate;
  const rightTail = leftTail + height / rightRate;
  const stirling = (x) => {
    const square = x * x;
    return (13680 - (462 - (132 - (99 - 140 / square) / square) / square) / square) / x / 166320;
  };
  const accepted = (v, y) => {
    const away = Math.abs(y - mode);
    if (away <= 20 || away >= spread / 2 - 1) {
      const odds = p / q;
      const factor = odds * (n + 1);
      let ratio = 1;
      for (let k = mode + 1; k <= y; k++) ratio *= factor / k - odds;
      for (let k = y + 1; k <= mode; k++) ratio /= factor / k - odds;
      return v <= ratio;
    }
    const error =
      (away / spread) * ((away * (away / 3 + 0.625) + 0.16666666666666666) / spread + 0.5);
    const [about, level] = [(-away * away) / (2 * spread), log(v)];
    if (level < about - error) return true;
    if (level > about + error) return false;
    const [atY, atMode, beyondMode, beyondY] = [y + 1, mode + 1, n + 1 - mode, n - y + 1];
    let exact = (mode + 0.5) * log(atMode / atY) + (n - mode + 0.5) * log(beyondMode / beyondY);
    exact += (y - mode) * log((beyondY * p) / (atY * q));
    exact += stirling(atMode) + stirling(beyondMode) + stirling(atY) + stirling(beyondY);
    return level <= exact;
  };
  for (;;) {
    const u = random.next() * rightTail;
    let v = random.next();
    let y;
    if (u <= half) return Math.floor(middle - half * v + u);
    if (u <= sides) {
      const x = left + (u - half) / height;
      v = v * height + 1 - Math.abs(mode - x + 0.5) / half;
      if (v > 1) continue;
      y = Math.floor(x);
    } else if (v === 0) continue;
    else if (u <= leftTail) {
      y = Math.floor(left + log(v) / leftRate);
      if (y < 0) continue;
      v = v * (u - sides) * leftRate;
    } else {
      y = Math.floor(right - log(v) / rightRate);
      if (y > n) continue;
      v = v * (u - leftTail) * rightRate;
    }
    if (accepted(v, y)) return y;
  }
}

/** Add up to 128 numbers in the order of NumPy's pairwise summation. @param {ArrayLike<number>} values */
function sum(values) {
  const whole = values.length - (values.length % 8);
  let total = 0;
  if (whole) {
    const r = Array.from({ length: 8 }, (_, i) => values[i]);
    for (let i = 8; i < whole; i++) r[i % 8] += values[i];
    total = r[0] + r[1] + (r[2] + r[3]) + (r[4] + r[5] + (r[6] + r[7]));
  }
  for (let i = whole; i < values.length; i++) total += values[i];
  return total;
}

const mean = (values) => sum(values) / values.length;
const meanInOrder = (values) => values.reduce((one, other) => one + other) / values.length;

/** Return the standard deviation of values, from their mean in one order of summation. */
function deviation(values, mean_) {
  const middle = mean_(values);
  return Math.sqrt(mean_(values.map((value) => (value - middle) * (value - middle))));
}

/** The spider's kernels, compiled from gaitsim's; see kernels.py. */
class Kernels {
  static async load() {
    const memory = new WebAssembly.Memory({ initial: 2 + Math.ceil(DATA.size / 65536) });
    const stack = new WebAssembly.Global({ value: "i32", mutable: true }, SCRATCH);
    const env = { __linear_memory: memory, __stack_pointer: stack };
    const { instance } = await WebAssembly.instantiate(bytesOf(DATA.module), { env });
    new Uint8Array(memory.buffer).set(await inflate(bytesOf(DATA.memory)), BASE);
    const legs = await inflate(bytesOf(DATA.legs));
    return new Kernels(instance.exports, memory.buffer, new Float32Array(legs.buffer));
  }

  constructor(functions, buffer, legs) {
    Object.assign(this, { functions, buffer, legs });
    for (const name of ["exp", "log", "power"])
      this[name] = (x, y = 0) => {
        this.view("x")[0] = x;
        this.view("y")[0] = y;
        this.call(name);
        return this.view("result")[0];
      };
  }

  call(name) {
    this.functions[name](SCRATCH, SCRATCH + 8, BASE);
  }

  /** Return a field of the memory. @param {string} name */
  view(name) {
    const [place, count, kind] = DATA.fields[name];
    return new KINDS[kind](this.buffer, BASE + place, count);
  }

  /** Set the body and the fitness. @param {Settings} settings */
  prepare({ lost, weights }) {
    const row = this.legs.subarray(75 * (DATA.legNames.indexOf(lost) + 1)); // the first is intact
    this.view("lengths").set(row.subarray(0, 24));
    this.view("shares").set(row.subarray(24, 48));
    this.view("hips").set(row.subarray(48, 72));
    this.view("moments").set(row.subarray(72, 75));
    this.view("lost").set(DATA.legNames.map((name) => (name === lost ? 1 : 0)));
    this.view("safe_margin")[0] = weights.safe_margin;
    const rate = DATA.frameRate;
    this.weights = [1, ...TERMS.slice(1).map((name) => -weights[`${name}_weight`])];
    this.weights[7] *= rate * rate * rate;
  }

  /** Move and score a genome of an alternating gait, or of a gait of all legs; return its terms. */
  score(genome) {
    const half = genome.length === DATA.lower.length ? 1 : 0;
    const at = [0, half ? 12 : 24, half ? 16 : 32, genome.length];
    const [amplitude, phase, lags] = [0, 1, 2].map((i) => genome.subarray(at[i], at[i + 1]));
    for (let copy = 0; copy <= half; copy++) {
      this.view("amplitude").set(amplitude, copy * 12);
      this.view("phase").set(phase.map((value) => (copy ? value + Math.PI : value)), copy * 4);
      const lag = this.view("lag"); // coxae have none
      lags.forEach((value, i) => (lag[3 * ((i >> 1) + copy * 4) + 1 + (i & 1)] = value));
    }
    this.call("evaluate");
    return Array.from(this.view("sums"), (value, i) => this.weights[i] * value);
  }

  /** @param {Random} random @param {number} count */
  normals(random, count) {
    const bits = this.view("bits"); // twice as many as draws, and a draw takes 1.02
    for (let i = 0; i < Math.min(bits.length, 2 * count + 64); i++) bits[i] = random.bits();
    this.view("draws")[0] = BigInt(count);
    this.call("normals");
    return this.view("normals").slice(0, count);
  }
}

/**
 * @typedef {{seed: number, start: "random" | "body", lost: string, weights: Record<string, number>}} Settings
 */

/** The genetic algorithm of the preset 'spider-genetic' with a population of 50. */
class Evolver {
  /** @param {Kernels} kernels @param {Settings} settings */
  constructor(kernels, settings) {
    this.kernels = kernels;
    this.settings = settings;
    this.number = 0;
    this.history = [];
    this.genomes = [];
    kernels.prepare(settings);
  }

  _random(purpose) {
    return new Random([this.settings.seed, this.number, PURPOSE[purpose]]);
  }

  /** Evolve the next generation. */
  next() {
    this.number += 1;
    this.genomes = this.number === 1 ? this._first() : this._bred();
    this.evaluate();
    this._record();
  }

  /** Score the population with other settings, which hold from now on. @param {Settings} settings */
  change(settings) {
    this.settings = settings;
    this.kernels.prepare(settings);
    this.evaluate();
    this.history = null; // the fingerprint is that of a run with the same settings from the beginning
  }

  evaluate() {
    this.terms = this.genomes.map((genome) => this.kernels.score(genome));
    this.scores = this.terms.map((terms) => {
      const total = terms.reduce((one, other) => one + other, 0);
      return Math.abs(total) <= 1e100 ? total : -Infinity;
    });
    this.best = this.scores.indexOf(Math.max(...this.scores));
  }

  _first() {
    const { lower, upper, population } = DATA;
    const random = this._random("initial");
    const genomes = Array.from({ length: population }, () =>
      Float64Array.from(lower, (low, i) => low + (upper[i] - low) * random.next()));
    if (this.settings.start === "body") {
      const start = Float64Array.from(DATA.start);
      const count = Math.ceil(DATA.search.start_share * population);
      const varied = Array.from({ length: count - 1 }, () => start.slice());
      [start, ...this._mutated(varied)].forEach((genome, i) => (genomes[i] = genome));
    }
    return genomes.map(repaired);
  }

  _bred() {
    const { population, search, selection, crossover } = DATA;
    const order = this.scores.map((_, i) => i).sort((i, j) => this.scores[j] - this.scores[i] || i - j);
    const elites = order.slice(0, search.elites).map((i) => this.genomes[i]);
    const pairs = population - search.elites;
    const random = this._random("selection");
    const winners = Array.from({ length: 2 * pairs }, () => {
      const entrants = Array.from({ length: selection.size }, () => random.below(population));
      return entrants.reduce((one, other) => (this.scores[other] > this.scores[one] ? other : one));
    });
    const crossing = this._random("crossover");
    const children = Array.from({ length: pairs }, (_, pair) => {
      const [mother, father] = [winners[2 * pair], winners[2 * pair + 1]].map((i) => this.genomes[i]);
      return mother.map((gene, i) => (crossing.next() < crossover.probability ? father[i] : gene));
    });
    return [...elites, ...this._mutated(children).map(repaired)];
  }

  _mutated(genomes) {
    const { lower, upper, mutation } = DATA;
    const genes = lower.length;
    const random = this._random("mutation");
    const all = genomes.length * genes;
    const sigma = mutation.sigma * this.kernels.power(mutation.decay, this.number);
    const count = binomial(random, all, mutation.rate, this.kernels);
    const sites = [];
    const drawn = new Set(); // Floyd's sampling (Bentley and Floyd 1987)
    for (let newest = all - count; newest < all; newest++) {
      const one = random.below(newest + 1);
      sites.push(drawn.has(one) ? newest : one);
      drawn.add(sites.at(-1));
    }
    const changes = this.kernels.normals(random, count);
    sites.forEach((site, i) => {
      const gene = site % genes;
      genomes[Math.floor(site / genes)][gene] += changes[i] * (sigma * (upper[gene] - lower[gene]));
    });
    return genomes;
  }

  _record() {
    const { lower, upper } = DATA;
    const alive = this.scores.map((_, i) => i).filter((i) => Number.isFinite(this.scores[i]));
    const chosen = alive.length ? alive : this.scores.map((_, i) => i);
    const finite = chosen.map((i) => this.scores[i]);
    const sorted = Float64Array.from(finite).sort();
    const [low, median, high] = [0.25, 0.5, 0.75].map((part) => {
      const place = part * (sorted.length - 1);
      const [below, rest] = [Math.floor(place), place % 1];
      const [one, other] = [sorted[below], sorted[Math.ceil(place)]];
      return one === other ? one : one * (1 - rest) + other * rest;
    });
    const spreads = lower.map((bound, gene) => {
      const values = this.genomes.map((genome) => genome[gene]);
      return deviation(values, meanInOrder) / (upper[gene] - bound);
    });
    this.mean = mean(finite);
    this.history?.push([
      this.number, 1, this.number * this.genomes.length, this.scores[this.best], this.mean, median, low,
      high, Math.min(...this.scores), alive.length ? deviation(finite, mean) : 0, mean(spreads),
      ...this.terms[this.best],
      ...TERMS.map((_, i) => (alive.length ? mean(alive.map((one) => this.terms[one][i])) : NaN)),
    ]);
  }

  /** Return the fingerprint that `gaitsim show RUN --fingerprint` prints for the same run. */
  fingerprint() {
    const { history } = this;
    const columns = history[0].map((_, i) => history.map((row) => row[i]));
    const numbers = [this.scores, ...columns].map((values) => Float64Array.from(values));
    return hexOf(sha256(joined([...this.genomes, ...numbers])));
  }
}

/** Clip the genes of a genome to their bounds; wrap periodic genes. */
function repaired(genome) {
  return genome.map((gene, i) => {
    const [low, high] = [DATA.lower[i], DATA.upper[i]];
    if (gene >= low && gene <= high) return gene;
    if (!DATA.periodic[i]) return gene < low ? low : high;
    const rest = (gene - low) % (high - low);
    return Math.min(low + (rest < 0 ? rest + (high - low) : rest), high);
  });
}
