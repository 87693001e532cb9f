// Elements of the page. Their text is always set as text, never as markup.

/**
 * Return an element.
 * @param {string} tag
 * @param {Record<string, any>} attributes functions are listeners, true is an empty attribute
 * @param {(Node | string | null)[]} children
 * @returns {any}
 */
function element(tag, attributes = {}, ...children) {
  return fill(document.createElement(tag), attributes, children);
}

/**
 * Return an SVG element.
 * @param {string} tag
 * @param {Record<string, any>} attributes
 * @param {(Node | string | null)[]} children
 */
function drawing(tag, attributes = {}, ...children) {
  return fill(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

function fill(made, attributes, children) {
  for (const [name, value] of Object.entries(attributes))
    if (typeof value === "function") made.addEventListener(name, value);
    else if (value === true) made.setAttribute(name, "");
    else if (value !== false && value != null) made.setAttribute(name, String(value));
  made.append(...children.filter((child) => child !== null));
  return made;
}

const ICONS = {
  play: "M7 4.5v15l13-7.5z",
  pause: "M6.5 5h4v14h-4zM13.5 5h4v14h-4z",
  theme: "M12 3a9 9 0 1 0 0 18zM12 3a9 9 0 0 1 0 18v-2a7 7 0 0 0 0-14z",
  view: "M12 2.5 20.5 7v10L12 21.5 3.5 17V7zM12 4.8 6.6 7.6 12 10.5l5.4-2.9zM5.5 9.3v6.5l5.5 2.9v-6.5zM18.5 9.3 13 12.2v6.5l5.5-2.9z",
  plus: "M11 5h2v6h6v2h-6v6h-2v-6H5v-2h6z",
  minus: "M5 11h14v2H5z",
};

/** @param {keyof ICONS} name */
function icon(name) {
  const path = drawing("path", { d: ICONS[name], "fill-rule": "evenodd" });
  return drawing("svg", { viewBox: "0 0 24 24", "aria-hidden": "true" }, path);
}

/**
 * Return a button.
 * @param {string} label accessible name
 * @param {Node | string} face
 * @param {() => void} click
 * @param {string} key key with the same action
 */
function button(label, face, click, key = "") {
  const title = key ? `${label} (${key})` : label;
  return element("button", { type: "button", "aria-label": label, title, click }, face);
}

/**
 * Replace a canvas with a message that the browser cannot draw in 3D.
 * @param {HTMLCanvasElement} canvas
 * @param {string} rest sentence on the parts of the page that work
 */
function withoutPicture(canvas, rest) {
  const words = `This browser cannot draw in 3D (WebGL 2 is missing or disabled). ${rest}`;
  canvas.replaceWith(element("p", { class: "missing", role: "alert" }, words));
}

/**
 * Format a number with at most four significant digits.
 * @param {number} value
 * @param {number} digits
 */
function numeral(value, digits = 4) {
  if (value === null || !Number.isFinite(value)) return value < 0 ? "−∞" : value > 0 ? "∞" : "–";
  const size = Math.abs(value);
  const text =
    size && (size < 1e-3 || size >= 1e6)
      ? value.toExponential(digits - 2)
      : String(Number(value.toPrecision(digits)));
  return text.replaceAll("-", "−");
}

/** @param {number} metres */
function lengthText(metres) {
  const size = Math.abs(metres);
  if (size < 0.0095) return `${numeral(1000 * metres, 2)} mm`;
  return size < 0.0995 ? `${numeral(100 * metres, 2)} cm` : `${numeral(metres, 3)} m`;
}

/** @param {number} seconds */
const secondsText = (seconds) => `${seconds.toFixed(2)} s`;

/** Announcements for screen readers. */
class Announcer {
  constructor() {
    this.root = element("div", { class: "unseen", "aria-live": "polite", role: "status" });
  }

  /** @param {string} text */
  say(text) {
    this.root.textContent = text;
  }
}

/** The current theme: the browser's, until the user chooses one. */
class Themes {
  /**
   * @param {{light: object, dark: object}} themes
   * @param {(theme: object) => void} changed
   */
  constructor(themes, changed) {
    this.themes = themes;
    this.changed = changed;
    this.preference = matchMedia("(prefers-color-scheme: dark)");
    this.name = this.preference.matches ? "dark" : "light";
    this.chosen = false;
    this.preference.addEventListener("change", () => {
      if (!this.chosen) this._set(this.preference.matches ? "dark" : "light");
    });
    document.documentElement.dataset.theme = this.name;
  }

  get theme() {
    return this.themes[this.name];
  }

  toggle() {
    this.chosen = true;
    this._set(this.name === "dark" ? "light" : "dark");
  }

  /** @param {"light" | "dark"} name */
  _set(name) {
    this.name = name;
    document.documentElement.dataset.theme = name;
    this.changed(this.theme);
  }
}
