"use strict";
/* The two pictures: load over displacement, contact radius over load. Okabe and Ito's palette, told apart in grey too. */

const BLUE = "#0072B2", ORANGE = "#D55E00", GREEN = "#009E73", BLACK = "#000000", SKY = "#56B4E9", PINK = "#CC79A7";
const MARKS = { load: "circle", displacement: "square", machine: "diamond" };
const DATA = [[GREEN, "circle-open"], [SKY, "triangle-up-open"], [PINK, "square-open"], [BLACK, "cross-thin-open"]];
const CONFIG = { displayModeBar: false, responsive: true }; // drag to zoom, double click to go back
const FONT = { family: "system-ui, sans-serif", size: 13, color: "#222" };

/* An axis over the window of values [SI], in the unit that suits them. */
function axis(name, symbol, dimension, values, units) {
  const { factor, unit } = units.of(Math.max(...values.map(Math.abs)), dimension);
  const low = Math.min(...values) / factor, high = Math.max(...values) / factor, margin = 0.04 * (high - low || 1);
  return {
    factor, unit,
    layout: {
      title: { text: `${name} ${symbol} (${pretty(unit)})`, standoff: 8 }, range: [low - margin, high + margin],
      gridcolor: "#e6e6e6", zerolinecolor: "#aaa", linecolor: "#444", ticks: "outside", showline: true, automargin: true,
    },
  };
}

/* One picture in the element: lines of SI points, x and y each {of, name, symbol, dimension, window}. */
function draw(element, lines, x, y, units, view) {
  const across = axis(x.name, x.symbol, x.dimension, x.window, units);
  const up = axis(y.name, y.symbol, y.dimension, y.window, units);
  const traces = lines.map(({ points, ...style }) => ({
    type: "scatter", mode: "lines", showlegend: false, ...style,
    x: points.map((point) => x.of(point) / across.factor), y: points.map((point) => y.of(point) / up.factor),
    hovertemplate: `${x.symbol} = %{x:.4~g} ${pretty(across.unit)}<br>${y.symbol} = %{y:.4~g} ${pretty(up.unit)}<extra>${style.name || ""}</extra>`,
  }));
  const layout = {
    font: FONT, margin: { l: 8, r: 10, t: 8, b: 8 }, hovermode: "closest", showlegend: false,
    uirevision: [view, across.unit, up.unit, x.symbol].join(), xaxis: across.layout, yaxis: up.layout,
    paper_bgcolor: "#fff", plot_bgcolor: "#fff",
  };
  Plotly.react(element, traces, layout, CONFIG);
}

/* The lines of the curve, its pull-offs, and the measured points; `pulls`: by control, `chosen`: the one that is held. */
function linesOf({ parts, nonadhesive, band, level, pulls, chosen, measured }) {
  const lines = [];
  if (band) lines.push({ name: `${100 * level} % band`, points: band, fill: "toself", fillcolor: "rgba(213,94,0,0.16)", line: { width: 0 }, hoverinfo: "skip" });
  lines.push({ name: "nonadhesive", points: nonadhesive, line: { color: BLUE, dash: "dash", width: 1.6 } });
  for (const { stable, points } of parts) {
    lines.push({ name: stable ? "stable" : "unstable", points, line: { color: ORANGE, width: stable ? 2.6 : 2, dash: stable ? "solid" : "dot" } });
  }
  measured.forEach(({ name, points }, i) => {
    const [color, symbol] = DATA[i % DATA.length];
    lines.push({ name, points, mode: "markers", marker: { color, symbol, size: 6 } });
  });
  for (const [name, point] of Object.entries(pulls)) {
    if (point.reason) continue;
    const fill = name === chosen ? BLACK : "#fff";
    lines.push({
      name: `pull-off, ${name}`, points: [point], mode: "markers",
      marker: { symbol: MARKS[name], size: name === chosen ? 11 : 9, color: fill, line: { color: BLACK, width: 1.6 } },
    });
  }
  return lines;
}
