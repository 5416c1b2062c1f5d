"use strict";
// Draws the plots of a report and redraws them as the native controls change. Data and library
// travel in the page, compressed; nothing is fetched.
(async () => {
  const byId = (id) => document.getElementById(id);

  async function unpacked(id) {
    const bytes = Uint8Array.from(atob(byId(id).textContent), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  }

  if (!("DecompressionStream" in window)) {
    for (const note of document.querySelectorAll(".waiting")) {
      note.textContent = "This browser is too old for the plots; the tables hold their numbers.";
    }
    return;
  }
  const data = JSON.parse(await unpacked("data"));
  const library = document.createElement("script");
  library.textContent = await unpacked("library");
  document.head.append(library);
  for (const note of document.querySelectorAll(".waiting")) note.remove();

  // colours and symbols of the methods: tablegen/studies/report/method_styles.py
  const FAMILIES = data.families;
  const darkScheme = window.matchMedia("(prefers-color-scheme: dark)");
  const narrow = window.matchMedia("(max-width: 40rem)");
  let printing = false;
  const isDark = () => darkScheme.matches && !printing;
  const colour = (family) => {
    const known = FAMILIES[family] || FAMILIES["direct simulation"];
    return isDark() ? known.dark : known.light;
  };
  const ink = () => (isDark() ? "#e9ecef" : "#1b1f24");
  const lines = () => (isDark() ? "#3d454d" : "#d5d9de");
  const floorFill = () => (isDark() ? "rgba(233,236,239,0.16)" : "rgba(27,31,36,0.12)");

  function axis(title, more) {
    return Object.assign(
      {
        title: { text: title, standoff: 8 }, gridcolor: lines(), linecolor: ink(), zeroline: false,
        ticks: "outside", tickcolor: lines(), automargin: true, exponentformat: "power",
        fixedrange: true,
      },
      more,
    );
  }
  // Ticks at 1, 2 and 5 times the powers of ten, or at these alone over many decades, in words.
  function plainNumber(value) {
    for (const [unit, scale] of [["M", 1e6], ["k", 1e3]]) {
      if (value >= scale) return `${Number((value / scale).toPrecision(2))}${unit}`;
    }
    return value >= 1e-4 ? String(Number(value.toPrecision(2))) : value.toExponential(0);
  }
  function logAxis(title, values) {
    const low = Math.min(...values), high = Math.max(...values);
    const ratio = high / low;
    const steps = ratio > 300 ? [1] : ratio > 8 ? [1, 2, 5] : [1, 1.5, 2, 3, 4, 5, 7];
    const ticks = [];
    for (let k = Math.floor(Math.log10(low)) - 1; k <= Math.ceil(Math.log10(high)); k += 1) {
      for (const step of steps) ticks.push(step * 10 ** k);
    }
    const room = Math.max(0.08, 0.06 * Math.log10(high / low));
    return axis(title, {
      type: "log", tickvals: ticks, ticktext: ticks.map(plainNumber),
      range: [Math.log10(low) - room, Math.log10(high) + room],
    });
  }

  function layout(x, y, more) {
    return Object.assign(
      {
        xaxis: x, yaxis: y, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
        font: { color: ink(), size: 13, family: "system-ui, DejaVu Sans, sans-serif" },
        margin: { l: 60, r: 12, t: 12, b: 48 }, dragmode: false, hovermode: "closest",
        legend: {
          orientation: "h", y: narrow.matches ? -0.28 : -0.22, yanchor: "top", x: 0, font: { size: 12 },
        },
      },
      more,
    );
  }
  const OPTIONS = { displayModeBar: false, responsive: true, scrollZoom: false };

  function show(id, traces, shape, label) {
    const place = byId(id);
    if (label) place.setAttribute("aria-label", label);
    // a page that is about to be printed does not wait for a plot to adapt
    Object.assign(shape, printing ? { width: place.clientWidth, autosize: false } : { autosize: true });
    return Plotly.react(place, traces, shape, OPTIONS);
  }
  const chosen = (id) => byId(id).value;
  const words = (id) => byId(id).selectedOptions[0].textContent;

  // -- accuracy map ---------------------------------------------------------------------------
  function drawMap() {
    const metric = chosen("map-metric"), limit = data.declared[metric];
    const map = data.atlas, columns = map.speed.length;
    const roots = map.alpha_deg.map(Math.sqrt);
    const z = map.speed.map((_, j) => roots.map((_, i) => map.points[i * columns + j][metric]));
    const text = z.map((row) => row.map((value) => value.toPrecision(2)));
    const stored = data.stored;
    const all = z.flat().concat(stored[metric]);
    const scale = {
      zmin: metric === "auc" ? 0.5 : 0, zmax: Math.max(limit, ...all), colorscale: "Viridis",
    };
    const heat = Object.assign(
      {
        type: "heatmap", x: roots, y: map.speed, z, customdata: z.map(() => map.alpha_deg), xgap: 1,
        ygap: 1, colorbar: { title: { text: data.short[metric], side: "right" }, thickness: 12 },
        hovertemplate: "%{customdata}°, %{y} m/s: %{z:.4f}<extra></extra>",
      },
      narrow.matches ? {} : { text, texttemplate: "%{text}", textfont: { size: 11 } },
      scale,
    );
    const dots = {
      type: "scatter", mode: "markers", x: stored.alpha_deg.map(Math.sqrt), y: stored.speed,
      name: "stored in the table", customdata: stored.alpha_deg.map((a, k) => [a, stored[metric][k]]),
      hovertemplate: "stored: %{customdata[0]:.2f}°, %{y:.1f} m/s: %{customdata[1]:.4f}<extra></extra>",
      marker: {
        color: stored[metric], cmin: scale.zmin, cmax: scale.zmax, colorscale: "Viridis", size: 11,
        symbol: "circle", line: { color: "#ffffff", width: 2 },
      },
    };
    const ticks = [0.5, 2, 5, 10, 20, 30, 45, 60, 75, 90];
    const x = axis(narrow.matches ? "impact angle α₁ [°]" : "impact angle α₁ [°], spaced by its square root", {
      tickvals: ticks.map(Math.sqrt), ticktext: ticks.map(String), showgrid: false,
    });
    show("plot-map", [heat, dots], layout(x, axis("speed V [m/s]", { showgrid: false })),
      `Map of ${words("map-metric")} over angle and speed; declared at most ${limit}; the table below has every number.`);
  }

  // -- marginals and joint views --------------------------------------------------------------
  const densities = (counts, low, high, total) => {
    const width = (high - low) / counts.length;
    return counts.map((n) => n / (total * width));
  };
  const centres = (low, high, bins) =>
    Array.from({ length: bins }, (_, i) => low + ((i + 0.5) * (high - low)) / bins);

  function drawMarginal(id, view, name) {
    const k = data.components.indexOf(name), low = view.low[k], high = view.high[k];
    const x = centres(low, high, view.direct[name].length);
    const curves = [
      { family: "direct simulation", counts: view.direct[name], fill: "tozeroy", dash: "solid" },
      { family: "table", counts: view.table[name], fill: "none", dash: "solid" },
    ].map((c) => ({
      type: "scatter", mode: "lines", name: c.family, x, y: densities(c.counts, low, high, view.count),
      line: { shape: "hvh", color: colour(c.family), width: c.fill === "none" ? 2 : 0.5 },
      fill: c.fill, fillcolor: floorFill(),
      hovertemplate: `${c.family}: %{y:.3f} at %{x:.3f}<extra></extra>`,
    }));
    const box = layout(axis(data.labels[name], { zeroline: false }), axis("density", { rangemode: "tozero" }));
    show(id, curves, box, `Density of ${data.plain[name]}, table beside direct, at ${view.alpha_deg}° and ${view.speed} m/s`);
  }

  function square(counts, flip) {
    const n = Math.round(Math.sqrt(counts.length));
    // rows of a heat map are its vertical axis
    return Array.from({ length: n }, (_, j) =>
      Array.from({ length: n }, (_, i) => (flip ? counts[j * n + i] : counts[i * n + j])));
  }

  function drawJoint(view, first, second) {
    const order = data.components;
    const flip = order.indexOf(first) > order.indexOf(second);
    const key = flip ? `${second} ${first}` : `${first} ${second}`;
    const i = order.indexOf(first), j = order.indexOf(second);
    const direct = square(view.direct[key], flip), table = square(view.table[key], flip);
    const n = direct.length;
    const x = centres(view.low[i], view.high[i], n), y = centres(view.low[j], view.high[j], n);
    const top = Math.max(...direct.flat(), ...table.flat());
    const root = (rows) => rows.map((row) => row.map((c) => Math.sqrt(c / top)));
    const sigma = direct.map((row, r) =>
      row.map((c, s) => (c + table[r][s] ? (table[r][s] - c) / Math.sqrt(c + table[r][s]) : 0)));
    const where = `${view.alpha_deg}° and ${view.speed} m/s`;
    const pair = `${data.plain[first]} and ${data.plain[second]}`;
    const box = () => layout(axis(data.labels[first], { showgrid: false }), axis(data.labels[second], { showgrid: false }));
    const heat = (z, more) => Object.assign({ type: "heatmap", x, y, z, showscale: false }, more);
    const shade = { colorscale: "Viridis", zmin: 0, zmax: 1, hovertemplate: "%{x:.3f}, %{y:.3f}<extra></extra>" };
    show("joint-direct", [heat(root(direct), shade)], box(), `Joint density of ${pair}, direct simulation, at ${where}`);
    show("joint-table", [heat(root(table), shade)], box(), `Joint density of ${pair}, table, at ${where}`);
    const gap = { colorscale: [[0, isDark() ? "#6fb7ff" : "#2166ac"], [0.5, isDark() ? "#20262c" : "#f4f4f4"], [1, isDark() ? "#ff7f6b" : "#b2182b"]], zmin: -5, zmax: 5, showscale: true, colorbar: { thickness: 10, title: { text: "standard errors", side: "right" } }, hovertemplate: "%{x:.3f}, %{y:.3f}: %{z:.1f} standard errors<extra></extra>" };
    show("joint-gap", [heat(sigma, gap)], box(), `Table minus direct in standard errors, ${pair}, at ${where}`);
    const flat = sigma.flat().filter((_, c) => direct.flat()[c] + table.flat()[c] >= 20);
    const beyond = flat.filter((s) => Math.abs(s) > 3).length;
    byId("joint-note").textContent =
      `At ${where}, ${beyond} of ${flat.length} cells of ${pair} with 20 states or more differ by ` +
      `more than 3 standard errors; chance alone gives ${(0.0027 * flat.length).toFixed(1)}.`;
  }

  function drawViews() {
    const view = data.views[Number(chosen("view-condition"))];
    const first = chosen("view-first"), second = chosen("view-second");
    for (const [own, other] of [["view-first", second], ["view-second", first]]) {
      for (const option of byId(own).options) option.disabled = option.value === other;
    }
    drawMarginal("marginal-first", view, first);
    drawMarginal("marginal-second", view, second);
    drawJoint(view, first, second);
  }

  // -- error against cost ---------------------------------------------------------------------
  const COSTS = {
    nanoseconds: "run time of a draw, one thread [ns]",
    bytes: "what a draw reads [bytes]",
    setup_seconds: "set-up or generation [worker s]",
  };
  function bars(points, metric) {
    const e = points.map((p) => p.errors[metric]);
    return {
      type: "data", symmetric: false, thickness: 1.2, width: 4,
      array: e.map((v) => v.high - v.mean), arrayminus: e.map((v) => v.mean - v.low),
    };
  }
  function floorShapes(floor, metric) {
    const band = floor[metric];
    return {
      shapes: [
        { type: "rect", xref: "paper", x0: 0, x1: 1, yref: "y", y0: band.low, y1: band.high, fillcolor: floorFill(), line: { width: 0 }, layer: "below" },
        { type: "line", xref: "paper", x0: 0, x1: 1, yref: "y", y0: band.mean, y1: band.mean, line: { color: ink(), width: 1, dash: "dot" }, layer: "below" },
      ],
    };
  }
  const ends = (points, metric) =>
    points.flatMap((p) => [p.errors[metric].low, p.errors[metric].high]).filter((e) => e > 0);
  const errorAxis = (metric, title, points, floor) =>
    metric === "auc"
      ? axis(title)
      : logAxis(title, ends(points, metric).concat(floor ? [floor[metric].low, floor[metric].high] : []));
  const usable = (runners, cost) => runners.filter((r) => r[cost] > 0);
  const hover = (r, metric) =>
    `<b>${r.family}</b><br>${r.name}<br>${r.nanoseconds.toFixed(0)} ns, ${r.bytes.toLocaleString("en")} bytes, ` +
    `set-up ${r.setup_seconds.toPrecision(2)} s<br>error ${r.errors[metric].mean.toPrecision(3)}`;

  function drawRace() {
    const race = data.races[Number(chosen("race-condition"))];
    const metric = chosen("race-metric"), cost = chosen("race-cost");
    const families = [...new Set(race.runners.map((r) => r.family))];
    const traces = families.map((family) => {
      const points = usable(race.runners.filter((r) => r.family === family), cost);
      return {
        type: "scatter", mode: "markers", name: family, x: points.map((p) => p[cost]),
        y: points.map((p) => p.errors[metric].mean), error_y: bars(points, metric),
        marker: { color: colour(family), symbol: FAMILIES[family].symbol, size: family === "table" ? 14 : 10 },
        text: points.map((p) => hover(p, metric)), hovertemplate: "%{text}<extra></extra>",
      };
    }).filter((t) => t.x.length);
    const title = words("race-metric");
    show("plot-race", traces, layout(logAxis(COSTS[cost], usable(race.runners, cost).map((r) => r[cost])), errorAxis(metric, data.short[metric], race.runners, race.floor), floorShapes(race.floor, metric)),
      `${title} against ${COSTS[cost]} of every way at ${race.alpha_deg}° and ${race.speed} m/s, with the noise floor`);
  }

  const VARIED = { base: "base", nodes: "nodes", components: "components", knots: "knots" };
  const SYMBOLS = { base: "star", nodes: "square", components: "circle", knots: "triangle-up" };
  const SWEEP = ["table", "Gaussian mixture", "independent marginals", "vine copula"];
  function drawDesigns() {
    const race = data.designs, metric = chosen("design-metric"), cost = chosen("design-cost");
    const traces = Object.keys(VARIED).map((varied, k) => {
      const points = usable(race.runners.filter((r) => r.settings.varied === varied), cost);
      const label = (p) => ({ base: "base", nodes: p.settings.nodes.join("×"), components: p.settings.components, knots: p.settings.quantile_knots })[varied];
      return {
        type: "scatter", mode: narrow.matches ? "markers" : "markers+text", name: VARIED[varied], x: points.map((p) => p[cost]),
        y: points.map((p) => p.errors[metric].mean), error_y: bars(points, metric),
        text: points.map((p) => String(label(p))), textposition: "top right", textfont: { size: 11 },
        marker: { color: colour(SWEEP[k]), symbol: SYMBOLS[varied], size: varied === "base" ? 14 : 10 },
        hovertext: points.map((p) => hover(p, metric)), hovertemplate: "%{hovertext}<extra></extra>",
      };
    });
    const title = words("design-metric");
    show("plot-designs", traces, layout(logAxis(COSTS[cost], usable(race.runners, cost).map((r) => r[cost])), errorAxis(metric, data.short[metric], race.runners, race.floor), floorShapes(race.floor, metric)),
      `${title} against ${COSTS[cost]} of tables of other sizes, with the noise floor`);
  }

  function drawSizes() {
    const metric = chosen("size-metric");
    const traces = ["direct simulation", "table"].map((family) => {
      const points = data.sizes.filter((s) => s.family === family);
      return {
        type: "scatter", mode: "lines+markers", name: family, x: points.map((p) => 1e3 * p.seconds),
        y: points.map((p) => p.errors[metric].mean), error_y: bars(points, metric),
        line: { color: colour(family) }, marker: { symbol: FAMILIES[family].symbol, size: 8 },
        text: points.map((p) => `${family}, ${p.count.toLocaleString("en")} states`), hovertemplate: "%{text}: %{y:.4f}<extra></extra>",
      };
    });
    show("plot-sizes", traces, layout(logAxis("run time of the sample, one thread [ms]", data.sizes.map((s) => 1e3 * s.seconds)), logAxis(data.short[metric], ends(data.sizes, metric))),
      `${words("size-metric")} of samples of growing size against their run time, direct simulation and table`);
  }

  function drawNumerics() {
    const dashes = ["solid", "dash", "dot"];
    const angles = [...new Set(data.settings.map((s) => s.alpha_deg))];
    const traces = [];
    for (const [varied, family] of [["resolution", "table"], ["tolerance", "independent marginals"]]) {
      angles.forEach((angle, k) => {
        const points = data.settings.filter((s) => s.varied === varied && s.alpha_deg === angle);
        traces.push({
          type: "scatter", mode: "lines+markers", name: `${varied}, ${angle}°`, x: points.map((p) => p.nanoseconds), y: points.map((p) => p.error),
          line: { color: colour(family), dash: dashes[k % 3] },
          marker: { symbol: points.map((p) => (p.is_default ? "star" : varied === "resolution" ? "circle" : "square")), size: points.map((p) => (p.is_default ? 14 : 8)) },
          text: points.map((p) => `resolution ${p.resolution}, tolerance ${p.tolerance}`), hovertemplate: "%{text}: %{y:.1e}<extra></extra>",
        });
      });
    }
    show("plot-numerics", traces, layout(logAxis("run time of a rebound, one thread [ns]", data.settings.map((s) => s.nanoseconds)), logAxis("largest change of a statistic", data.settings.map((s) => s.error).filter((e) => e > 0))),
      "Largest change of a statistic against run time, by contact resolution and by flight tolerance; stars mark the defaults");
  }

  const PARTS = [
    [drawMap, ["map-metric"]],
    [drawViews, ["view-condition", "view-first", "view-second"]],
    [drawRace, ["race-condition", "race-metric", "race-cost"]],
    [drawDesigns, ["design-metric", "design-cost"]],
    [drawSizes, ["size-metric"]],
    [drawNumerics, []],
  ];
  const drawAll = () => PARTS.forEach(([draw]) => draw());
  for (const [draw, controls] of PARTS) {
    for (const id of controls) byId(id).addEventListener("change", draw);
  }
  drawAll();
  darkScheme.addEventListener("change", drawAll);
  narrow.addEventListener("change", drawAll);
  function forPaper(yes) {
    printing = yes;
    document.documentElement.classList.toggle("printing", yes);
    drawAll();
    if (yes) return;
    for (const plot of document.querySelectorAll(".js-plotly-plot")) Plotly.Plots.resize(plot);
  }
  window.addEventListener("beforeprint", () => forPaper(true));
  window.addEventListener("afterprint", () => forPaper(false));
  document.documentElement.dataset.ready = "yes";
})();
