// The panel beside the picture: title, score, terms, measures, fitness curve and challenge code.

/**
 * Return the panel beside the stage.
 * @param {object} data data of the page
 * @param {Announcer} announcer
 */
function panelOf(data, announcer) {
  const { clips } = data;
  return element(
    "aside",
    { class: "panel", "aria-label": "About this motion" },
    element("h1", {}, data.title),
    data.description ? element("p", { class: "description" }, data.description) : null,
    clips.length === 1 ? detailsOf(clips[0], data.title) : null,
    tableOf("Score", clips, "terms", (clip) => clip.score),
    curveOf(data),
    tableOf("Measures", clips, "measures"),
    glossaryOf(clips),
    codeOf(data.code, announcer),
    element("p", { class: "made" }, data.made ? `Created with ${data.made}` : ""),
  );
}

/** @param {object} clip @param {string} title title of the page, which is not repeated */
function detailsOf(clip, title) {
  const lines = [clip.title, clip.details].filter((line) => line && line !== title);
  return element("div", { class: "details" }, ...lines.map((line) => element("p", {}, line)));
}

/** @param {number} number index of a clip */
const dotOf = (number) =>
  element("span", { class: "dot", style: `background: var(--body-${number % 5})` });

/**
 * Return a table with a row for each quantity and a column for each clip.
 * @param {string} heading
 * @param {object[]} clips
 * @param {"terms" | "measures"} kind
 * @param {((clip: object) => number) | null} total
 */
function tableOf(heading, clips, kind, total = null) {
  /** @type {Map<string, {unit: string, values: Map<number, number>}>} */
  const rows = new Map();
  clips.forEach((clip, number) => {
    for (const { name, value, unit } of clip[kind] ?? []) {
      if (!rows.has(name)) rows.set(name, { unit, values: new Map() });
      rows.get(name).values.set(number, value);
    }
  });
  if (!rows.size && !total) return null;
  const digits = clips.length > 1 ? 3 : 4;
  const cellText = (value) => (value === undefined ? "" : numeral(value, digits));
  const cells = (values) => clips.map((_, i) => element("td", {}, cellText(values.get(i))));
  const [caption, tags] = tagsOf(clips);
  const columns = tags.map((tag, i) => element("th", { scope: "col" }, dotOf(i), tag));
  const head = clips.length > 1 && [
    element("thead", {}, element("tr", {}, element("td", { class: "caption" }, caption), ...columns)),
  ];
  const body = [...rows].map(([name, { unit, values }]) =>
    element(
      "tr",
      {},
      element("th", { scope: "row" }, words(name), unit ? element("small", {}, ` ${unit}`) : null),
      ...cells(values),
    ),
  );
  if (total)
    body.push(
      element(
        "tr",
        { class: "total" },
        element("th", { scope: "row" }, rows.size ? "score" : "Score", unitOf(clips[0].unit)),
        ...clips.map((clip) => element("td", {}, cellText(total(clip)))),
      ),
    );
  return element(
    "section",
    { class: "scrolls" },
    element("h2", {}, heading),
    element("table", {}, ...(head || []), element("tbody", {}, ...body)),
  );
}

const unitOf = (unit) => (unit ? element("small", {}, ` ${unit}`) : null);
const words = (name) => String(name).replaceAll("_", " ");

/**
 * Return the word that the tags of all clips begin with, or "", and the rest of each tag.
 * @param {object[]} clips
 * @returns {[string, string[]]}
 */
function tagsOf(clips) {
  const tags = clips.map((clip, i) => clip.tag || String(i + 1));
  const [word] = tags[0].split(" ");
  const alike = tags.every((tag) => /^\S+ \d+$/.test(tag) && tag.startsWith(`${word} `));
  return alike ? [word, tags.map((tag) => tag.slice(word.length + 1))] : ["", tags];
}

/** Return the meanings of the measures, as a collapsed element. */
function glossaryOf(clips) {
  const meanings = new Map();
  for (const clip of clips)
    for (const { name, help } of clip.measures ?? []) if (help) meanings.set(name, help);
  if (!meanings.size) return null;
  return element(
    "details",
    {},
    element("summary", {}, "What the measures mean"),
    element(
      "dl",
      {},
      ...[...meanings].flatMap(([name, help]) => [
        element("dt", {}, words(name)),
        element("dd", {}, help),
      ]),
    ),
  );
}

/** Return the curve of the best score, with marks at the generations of the clips. */
function curveOf({ curve, clips }) {
  const points = (curve?.best ?? [])
    .map((score, i) => [curve.generation[i], score])
    .filter(([, score]) => Number.isFinite(score));
  if (points.length < 2) return null;
  const [wide, high] = [300, 96];
  const scores = points.map(([, score]) => score);
  const [low, top] = [Math.min(...scores), Math.max(...scores)];
  const [first, last] = [points[0][0], points.at(-1)[0]];
  const x = (generation) => 6 + ((wide - 12) * (generation - first)) / (last - first || 1);
  const y = (score) => 8 + (high - 16) * (1 - (score - low) / (top - low || 1));
  const line = points.map(([generation, score]) => `${x(generation)},${y(score)}`).join(" ");
  const dots = clips.map((clip, number) => {
    const generation = Number(/generation (\d+)/.exec(clip.tag)?.[1] ?? NaN);
    if (!(generation >= first && generation <= last)) return null;
    const nearest = points.reduce((one, other) =>
      Math.abs(other[0] - generation) < Math.abs(one[0] - generation) ? other : one,
    );
    const place = { cx: x(generation), cy: y(nearest[1]), r: 5 };
    return drawing("circle", { ...place, style: `fill: var(--body-${number % 5})` });
  });
  const words_ = `Best score by generation: ${numeral(scores[0])} in generation ${first}, ${numeral(
    scores.at(-1),
  )} in generation ${last}.`;
  return element(
    "section",
    { class: "curve" },
    element("h2", {}, "Evolution"),
    drawing(
      "svg",
      { viewBox: `0 0 ${wide} ${high}`, role: "img", "aria-label": words_ },
      drawing("polyline", { points: line }),
      ...dots,
    ),
    element(
      "p",
      { class: "ends" },
      element("span", {}, `generation ${first}: ${numeral(scores[0])}`),
      element("span", {}, `${last}: ${numeral(scores.at(-1))}`),
    ),
  );
}

/** Return the challenge code with a button that copies it. */
function codeOf(code, announcer) {
  if (!code) return null;
  const text = element("textarea", {
    readonly: true,
    rows: "3",
    "aria-label": "Challenge code",
    spellcheck: "false",
  });
  text.value = code;
  const copy = async () => {
    text.select();
    try {
      await navigator.clipboard.writeText(code);
      announcer.say("Code copied.");
      status.textContent = "Copied.";
    } catch {
      status.textContent = "Selected; press Ctrl+C to copy.";
    }
  };
  const status = element("span", { class: "status", "aria-hidden": "true" });
  return element(
    "section",
    { class: "code" },
    element("h2", {}, "Challenge code"),
    element("p", {}, "Verify the score, or try to beat it: ", element("code", {}, "gaitsim verify CODE")),
    text,
    element("div", {}, element("button", { type: "button", click: copy }, "Copy the code"), status),
  );
}
