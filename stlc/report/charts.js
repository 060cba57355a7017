// Small charts over time, all with the same moment marked.
function scaleOf(chart) {
  const every = [...chart.curves.flatMap((c) => c.values), ...chart.levels].filter((v) => v !== null);
  for (const band of chart.bands) every.push(band.low, ...(band.high === null ? [] : [band.high]));
  const to = chart.log ? (v) => Math.log10(Math.max(v, 1e-12)) : (v) => v;
  const values = every.map(to);
  let low = Math.min(...values), high = Math.max(...values);
  if (!(high - low > 1e-9 * Math.max(1, Math.abs(high)))) { low -= 1; high += 1; }
  const pad = 0.06 * (high - low);
  return { to, low: low - pad, high: high + pad };
}

function ticksOf(chart, scale) {
  if (chart.log) {
    const found = [], every = Math.max(1, Math.ceil((scale.high - scale.low) / 4));
    for (let e = Math.ceil(scale.low); e <= scale.high; e += every) found.push([e, `1e${e}`]);
    return found;
  }
  const step = niceStep(scale.high - scale.low, 4), found = [];
  for (let v = Math.ceil(scale.low / step) * step; v <= scale.high; v += step) found.push([v, shown(+v.toPrecision(6))]);
  return found;
}

function pathOf(values, X, Y, hold) {
  let d = "", gap = true;
  values.forEach((v, k) => {
    if (v === null) { gap = true; return; }
    d += `${gap ? "M" : "L"}${X(k).toFixed(1)},${Y(v).toFixed(1)}`;
    if (hold) d += `H${X(k + 1).toFixed(1)}`;
    gap = false;
  });
  return d;
}

function timeTicks(svg, X, y) {
  const whole = T * DATA.step, per = whole >= 7200 ? 3600 : whole >= 600 ? 60 : 1;
  const unit = { 3600: "h", 60: "min", 1: "s" }[per], step = niceStep(whole / per, 6);
  for (let s = 0; s <= whole / per + 1e-9; s += step) {
    const at = X((s * per) / DATA.step), far = s + step > whole / per + 1e-9;
    const anchor = s === 0 ? "start" : "middle";
    draw("text", { x: at, y, "text-anchor": far ? "end" : anchor, text: far ? `${shown(s)} ${unit}` : shown(s) }, svg);
  }
}

function scrub(svg, back) {
  const go = (event) => {
    const box = svg.getBoundingClientRect();
    seek(back(event.clientX - box.left));
  };
  svg.addEventListener("pointerdown", (event) => { svg.setPointerCapture(event.pointerId); go(event); });
  svg.addEventListener("pointermove", (event) => { if (event.buttons) go(event); });
}

function drawChart(root, chart) {
  const card = make("figure", { class: "card" }, root);
  const head = make("figcaption", {}, card);
  make("b", { text: chart.unit ? `${chart.title} [${chart.unit}]` : chart.title }, head);
  make("span", { class: "what", text: chart.what }, head);
  const legend = make("div", { class: "legend" }, card);
  const wide = Math.max(card.clientWidth - 24, 200), tall = 120, left = 46;
  const X = (k) => left + ((wide - left - 8) * k) / Math.max(T, 1);
  const scale = scaleOf(chart);
  const Y = (v) => 6 + ((tall - 26) * (scale.high - scale.to(v))) / (scale.high - scale.low);
  const svg = draw("svg", { width: wide, height: tall, class: "chart" }, card);
  chart.bands.forEach((band, k) => drawBand(svg, band, wide - 70 * (k % 3), left, Y, scale, wide));
  for (const [v, text] of ticksOf(chart, scale)) {
    const y = Y(chart.log ? 10 ** v : v);
    draw("line", { x1: left, x2: wide - 8, y1: y, y2: y, class: "rule" }, svg);
    draw("text", { x: left - 5, y: y + 3.5, "text-anchor": "end", text }, svg);
  }
  for (const level of chart.levels)
    draw("line", { x1: left, x2: wide - 8, y1: Y(level), y2: Y(level), class: "level" }, svg);
  timeTicks(svg, X, tall - 4);
  for (const c of chart.curves)
    draw("path", { d: pathOf(c.values, X, Y, chart.hold), stroke: c.colour, class: "curve" }, svg);
  const now = draw("line", { y1: 4, y2: tall - 18, class: "now" }, svg);
  const readings = chart.curves.map((c) => reading(legend, c));
  const move = (t) => {
    now.setAttribute("x1", X(t));
    now.setAttribute("x2", X(t));
    chart.curves.forEach((c, k) => { readings[k].textContent = shown(between(c.values, t, chart.hold)); });
  };
  scrub(svg, (x) => ((x - left) / (wide - left - 8)) * T);
  return move;
}

function drawBand(svg, band, right, left, Y, scale, wide) {
  const top = Y(band.high === null ? scale.high : band.high), bottom = Y(band.low);
  draw("rect", { x: left, width: wide - left - 8, y: top, height: Math.max(bottom - top, 0), class: `band ${band.kind}` }, svg);
  draw("text", { x: right - 12, y: (top + bottom) / 2 + 3, "text-anchor": "end", text: band.name }, svg);
}

function reading(legend, curve) {
  const item = make("span", {}, legend);
  make("i", { style: `background:${curve.colour}` }, item);
  make("span", { text: `${curve.name} ` }, item);
  return make("b", {}, item);
}

let chartMovers = [];
function drawCharts() {
  const root = document.getElementById("charts");
  clear(root);
  chartMovers = DATA.charts.map((chart) => drawChart(root, chart));
  chartMovers.forEach((move) => move(state.t));
}
onTime((t) => chartMovers.forEach((move) => move(t)));
