// The timeline: footfalls, or the altitude of a flying body, with a playhead.

const ROWS = 104; // height of all rows of feet, pixels
const WIDEST_LABEL = 92; // pixels
const EDGE = 8; // margin to the right of the rows, pixels
const AXIS = 16; // height of the axis below the rows, pixels

class Timeline {
  /**
   * @param {number} seconds length of the longest recording
   * @param {(seconds: number) => void} seek
   */
  constructor(seconds, seek) {
    this.seconds = seconds;
    this.seek = seek;
    this.picture = element("canvas", { "aria-hidden": "true" });
    this.head = element("div", { class: "head" });
    this.root = element(
      "div",
      {
        class: "timeline",
        role: "slider",
        tabindex: "0",
        "aria-label": "Time",
        "aria-valuemin": "0",
        "aria-valuemax": seconds.toFixed(2),
        pointerdown: (event) => this._held(event),
        pointermove: (event) => event.buttons & 1 && this._to(event),
        keydown: (event) => this._pressed(event),
      },
      this.picture,
      this.head,
    );
    new ResizeObserver(() => this.draw()).observe(this.root);
    this.now = 0;
  }

  /**
   * Show a recording.
   * @param {Recording} recording
   * @param {object} theme
   * @param {number} number index of the body, which selects its colour
   */
  show(recording, theme, number) {
    Object.assign(this, { recording, theme, number });
    const rows = recording.feet ? clamp(ROWS, 9 * recording.feet, 12 * recording.feet) : 64;
    this.rows = Math.min(rows, ROWS + 40);
    this.labels = 0;
    this.root.style.height = `${this.rows + AXIS + 8}px`;
    this.draw();
  }

  /** Move the playhead. @param {number} seconds */
  set time(seconds) {
    this.now = seconds;
    const text = `${seconds.toFixed(2)} seconds of ${this.seconds.toFixed(2)}`;
    if (this.root.getAttribute("aria-valuetext") !== text) {
      this.root.setAttribute("aria-valuenow", seconds.toFixed(2));
      this.root.setAttribute("aria-valuetext", text);
    }
    this.head.style.transform = `translateX(${this._x(seconds)}px)`;
  }

  /** @param {number} seconds */
  _x(seconds) {
    return this.labels + ((this.width ?? 0) - this.labels - EDGE) * (seconds / (this.seconds || 1));
  }

  draw() {
    const { recording, theme, picture } = this;
    this.width = this.root.clientWidth;
    const height = this.root.clientHeight;
    if (!recording || !this.width) return;
    const ratio = devicePixelRatio || 1;
    picture.width = Math.round(this.width * ratio);
    picture.height = Math.round(height * ratio);
    const pen = picture.getContext("2d");
    pen.scale(ratio, ratio);
    pen.font = `11px ${getComputedStyle(this.root).fontFamily}`;
    const style = getComputedStyle(this.root);
    const soft = style.getPropertyValue("--soft");
    this.labels = this._labels(pen);
    this._axis(pen, soft, style.getPropertyValue("--line"));
    if (recording.feet) this._footfalls(pen, theme, soft, style.getPropertyValue("--row"));
    else this._altitude(pen, theme, soft);
    this.time = this.now;
  }

  /** Return the width of the labels, the names of feet or altitudes, pixels. */
  _labels(pen) {
    const { recording } = this;
    let names = recording.clip.feet?.names;
    if (!names) {
      const heights = recording.values.centre.filter((_, i) => i % 3 === 2);
      this.low = heights.reduce((least, one) => Math.min(least, one));
      this.high = Math.max(heights.reduce((most, one) => Math.max(most, one)), this.low + 1e-6);
      names = [this.low, this.high].map(lengthText);
    }
    const widest = Math.max(...names.map((name) => pen.measureText(name.slice(0, 40)).width));
    return Math.ceil(Math.min(widest, WIDEST_LABEL)) + 10;
  }

  /** @param {CanvasRenderingContext2D} pen @param {string} soft @param {string} line */
  _axis(pen, soft, line) {
    const room = (this.width - this.labels - EDGE) / (this.seconds || 1);
    const step = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100].find((one) => one * room > 56) ?? 500;
    pen.fillStyle = soft;
    pen.strokeStyle = line;
    pen.textAlign = "center";
    pen.textBaseline = "alphabetic";
    const end = this.seconds + 1 / this.recording.frameRate; // a frame lasts until the next one
    for (let i = 0; i * step <= end + 1e-6; i++) {
      const x = Math.round(this._x(i * step)) + 0.5;
      pen.beginPath();
      pen.moveTo(x, 2);
      pen.lineTo(x, this.rows + 6);
      pen.stroke();
      const label = String(Number((i * step).toPrecision(6)));
      const half = pen.measureText(label).width / 2;
      const middle = Math.min(x, this.width - 1 - half);
      pen.fillText(i ? label : "0 s", middle, this.rows + AXIS + 3);
    }
  }

  _footfalls(pen, theme, soft, ground) {
    const { recording } = this;
    const { names, sides, lost } = recording.clip.feet;
    const high = this.rows / names.length;
    const colours = { left: theme.left, right: theme.right, "": theme.middle };
    const bar = Math.max(Math.min(0.66 * high, 9), 0.8 * Math.min(high, 3));
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    const every = Math.ceil(10 / high);
    names.forEach((name, foot) => {
      const y = 4 + (foot + 0.5) * high;
      pen.fillStyle = soft;
      if (foot % every === 0) pen.fillText(shortened(pen, name, this.labels - 8), this.labels - 8, y);
      pen.fillStyle = ground;
      const [start, end] = [this._x(0), this._x(recording.seconds)];
      pen.fillRect(start, y - bar / 2, end - start, bar);
      pen.fillStyle = lost[foot] ? theme.damaged : colours[sides[foot]];
      for (const [first, last] of stances(recording, foot)) {
        const from = this._x(first / recording.frameRate);
        const to = this._x(Math.min(last / recording.frameRate, recording.seconds));
        pen.fillRect(from, y - bar / 2, Math.max(to - from, 0.5), bar);
      }
    });
  }

  _altitude(pen, theme, soft) {
    const { recording } = this;
    const { centre } = recording.values;
    const heights = Array.from({ length: recording.frames }, (_, i) => centre[3 * i + 2]);
    const [low, high] = [this.low, this.high];
    const y = (value) => 10 + (this.rows - 12) * (1 - (value - low) / (high - low));
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    pen.fillStyle = soft;
    pen.fillText(lengthText(high), this.labels - 8, 10);
    pen.fillText(lengthText(low), this.labels - 8, this.rows - 2);
    pen.strokeStyle = theme.bodies[this.number % theme.bodies.length];
    pen.lineWidth = 2;
    pen.lineJoin = "round";
    pen.beginPath();
    heights.forEach((value, i) => pen.lineTo(this._x(i / recording.frameRate), y(value)));
    pen.stroke();
  }

  /** @param {PointerEvent} event */
  _held(event) {
    if (event.button) return;
    this.root.setPointerCapture(event.pointerId);
    this._to(event);
  }

  /** @param {PointerEvent} event */
  _to(event) {
    const x = event.clientX - this.root.getBoundingClientRect().left;
    const share = (x - this.labels) / (this.width - this.labels - EDGE);
    this.seek(clamp(share, 0, 1) * this.seconds);
  }

  /** @param {KeyboardEvent} event */
  _pressed(event) {
    const frame = 1 / (this.recording?.frameRate ?? 30);
    const steps = {
      ArrowLeft: -frame,
      ArrowDown: -frame,
      ArrowRight: frame,
      ArrowUp: frame,
      PageDown: -1,
      PageUp: 1,
      Home: -Infinity,
      End: Infinity,
    };
    const step = steps[event.key];
    if (step === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    event.stopPropagation();
    this.seek(clamp(this.now + step * (event.shiftKey ? 10 : 1), 0, this.seconds));
  }
}

/**
 * Return the stances of a foot, each as the first frame and the frame after the last.
 * @param {Recording} recording
 * @param {number} foot
 */
function stances(recording, foot) {
  const { touching } = recording.values;
  const found = [];
  let since = -1;
  for (let frame = 0; frame <= recording.frames; frame++) {
    const on = frame < recording.frames && touching[frame * recording.feet + foot] > 0.5;
    if (on && since < 0) since = frame;
    if (!on && since >= 0) found.push([since, frame]);
    if (!on) since = -1;
  }
  return found;
}

/**
 * Shorten text to fit a width.
 * @param {CanvasRenderingContext2D} pen
 * @param {string} text
 * @param {number} width pixels
 */
function shortened(pen, text, width) {
  let shown = [...text].slice(0, 40);
  if (pen.measureText(shown.join("")).width <= width) return shown.join("");
  while (shown.length && pen.measureText(shown.join("") + "…").width > width) shown = shown.slice(0, -1);
  return shown.join("") + "…";
}
