// The map: drawn anew for the width there is, moved by time.
const map = { root: document.getElementById("map"), movers: [] };
const RAMP = [[200, 80, 0], [225, 190, 40], [0, 114, 178]]; // poor, just so, good

function qualityColour(q) {
  if (q === null) return "#999";
  const at = clamp(q, 0, 1) * 2, k = Math.min(Math.floor(at), 1), f = at - k;
  const mix = RAMP[k].map((c, i) => Math.round(c + f * (RAMP[k + 1][i] - c)));
  return `rgb(${mix.join(",")})`;
}

function place(agent, t) {
  const at = t * agent.per, k = Math.min(Math.floor(at), agent.path.length - 1);
  const a = agent.path[k], b = agent.path[Math.min(k + 1, agent.path.length - 1)];
  return a.map((x, i) => x + (at - k) * (b[i] - x));
}

function placeOf(name, t) {
  const agent = DATA.scene.agents.find((one) => one.name === name);
  if (agent) return place(agent, t);
  const station = DATA.scene.stations.find((one) => one.name === name);
  return station ? station.at : null;
}

function frameAt(frames, t) {
  const k = Math.min(Math.floor(t), frames.length - 1), next = frames[Math.min(k + 1, frames.length - 1)];
  const now = frames[k], f = t - k;
  const alike = now.length === next.length &&
    now.every((p, i) => p.length === next[i].length && p.every((r, j) => r.length === next[i][j].length));
  if (!alike || f <= 0) return now;
  return now.map((p, i) => p.map((ring, j) => ring.map((c, m) => {
    const d = next[i][j][m];
    return [c[0] + f * (d[0] - c[0]), c[1] + f * (d[1] - c[1])];
  })));
}

function drawMap() {
  clear(map.root);
  map.movers = [];
  const scene = DATA.scene;
  if (!scene.box) return;
  const [x0, y0, x1, y1] = scene.box;
  document.body.classList.toggle("wide", x1 - x0 > 2 * (y1 - y0));
  const wide = map.root.clientWidth || 600, tall = Math.max(320, window.innerHeight * 0.68);
  const scale = Math.min(wide / (x1 - x0), tall / (y1 - y0));
  const height = Math.max(scale * (y1 - y0), 90);
  const ox = (wide - scale * (x1 - x0)) / 2, oy = (height - scale * (y1 - y0)) / 2;
  map.X = (p) => ox + scale * (p[0] - x0);
  map.Y = (p) => height - oy - scale * (p[1] - y0);
  map.xy = (p) => `${map.X(p).toFixed(1)},${map.Y(p).toFixed(1)}`;
  map.scale = scale;
  const svg = draw("svg", { width: wide, height, viewBox: `0 0 ${wide} ${height}`, role: "img" }, map.root);
  draw("title", { text: "Map of the mission" }, svg);
  grid(svg, scene.box, wide, height);
  if (scene.workspace) draw("path", { d: ring(scene.workspace), class: "workspace" }, svg);
  for (const one of scene.places) drawPlace(svg, one);
  for (const wall of scene.walls) {
    const g = draw("g", { class: "wall", "data-name": wall.name, tabindex: 0 }, svg);
    draw("title", { text: wall.name }, g);
    for (const points of wall.lines) draw("polyline", { points: points.map(map.xy).join(" ") }, g);
  }
  const joined = draw("g", {}, svg);
  for (const agent of scene.agents) {
    const points = agent.path.map(map.xy).join(" ");
    draw("polyline", { points, class: "path", stroke: agent.colour, "data-name": agent.name }, svg);
  }
  const ghosts = draw("g", { class: "ghosts" }, svg);
  for (const station of scene.stations) drawStation(svg, station);
  for (const agent of scene.agents) drawAgent(svg, agent);
  for (const link of scene.links) drawLink(joined, link);
  map.ghosts = ghosts;
  map.movers.forEach((move) => move(state.t));
  showFocus(state.focus);
}

const ring = (points) => "M" + points.map(map.xy).join("L") + "Z";
const shape = (frame) => frame.map((polygon) => polygon.map(ring).join("")).join("");

function grid(svg, box, wide, height) {
  const step = niceStep(Math.max(box[2] - box[0], box[3] - box[1]), 6);
  const g = draw("g", { class: "grid" }, svg);
  for (let x = Math.ceil(box[0] / step) * step; x <= box[2]; x += step) {
    const at = map.X([x, 0]);
    draw("line", { x1: at, x2: at, y1: 0, y2: height }, g);
    if (at > 14 && at < wide - 34) draw("text", { x: at + 3, y: height - 4, text: shown(x) }, g);
  }
  for (let y = Math.ceil(box[1] / step) * step; y <= box[3]; y += step) {
    const at = map.Y([0, y]);
    draw("line", { x1: 0, x2: wide, y1: at, y2: at }, g);
    if (at > 14 && at < height - 18) draw("text", { x: 3, y: at - 3, text: shown(y) }, g);
  }
  draw("text", { x: wide - 5, y: height - 4, "text-anchor": "end", text: "m" }, g);
}

function drawPlace(svg, one) {
  const g = draw("g", { class: one.kind, "data-name": one.name, tabindex: 0 }, svg);
  draw("title", { text: one.heights ? `${one.name}, ${one.heights} high` : one.name }, g);
  const grown = one.inflate && draw("path", { class: "buffer", "stroke-width": 2 * one.inflate * map.scale }, g);
  const body = draw("path", { class: "body", "fill-rule": "evenodd" }, g);
  const label = draw("text", { class: "name", text: one.name }, g);
  const move = (t) => {
    const frame = frameAt(one.frames, t), d = shape(frame), corners = frame.flat(2);
    body.setAttribute("d", d);
    if (grown) grown.setAttribute("d", d);
    const xs = corners.map(map.X), ys = corners.map(map.Y);
    const roomy = Math.max(...xs) - Math.min(...xs) > 7 * one.name.length;
    label.setAttribute("x", (Math.min(...xs) + Math.max(...xs)) / 2);
    label.setAttribute("y", roomy ? (Math.min(...ys) + Math.max(...ys)) / 2 + 4 : Math.min(...ys) - 4);
  };
  move(state.t);
  if (one.frames.length > 1) map.movers.push(move);
  pointed(g, () => focusName(one.name));
}

function drawStation(svg, station) {
  const g = draw("g", { class: "station", "data-name": station.name, tabindex: 0 }, svg);
  const x = map.X(station.at), y = map.Y(station.at);
  draw("path", { d: `M${x},${y - 8}l7,13h-14Z` }, g);
  draw("text", { x: x + 10, y: y + 5, text: station.name }, g);
  pointed(g, () => focusName(station.name));
}

function drawAgent(svg, agent) {
  const g = draw("g", { class: "agent", "data-name": agent.name, tabindex: 0 }, svg);
  const trail = draw("polyline", { class: "trail", stroke: agent.colour }, g);
  const mark = draw("g", {}, g);
  draw("circle", { r: 7, fill: agent.colour }, mark);
  const label = draw("text", { x: 10, y: -8, style: `fill:${agent.colour}` }, mark);
  map.movers.push((t) => {
    const here = place(agent, t), k = Math.floor(t * agent.per + 1e-9);
    trail.setAttribute("points", [...agent.path.slice(0, k + 1), here].map(map.xy).join(" "));
    mark.setAttribute("transform", `translate(${map.xy(here)})`);
    label.textContent = agent.flies ? `${agent.name} ${shown(+here[2].toFixed(1))} m up` : agent.name;
  });
  pointed(g, () => focusName(agent.name));
}

function drawLink(parent, link) {
  const g = draw("g", { class: link.asked ? "link asked" : "link", "data-link": link.ends.join(" ") }, parent);
  const line = draw("line", {}, g), title = draw("title", {}, g);
  map.movers.push((t) => {
    const [a, b] = link.ends.map((name) => placeOf(name, t));
    if (!a || !b) return;
    const value = between(link.value, t);
    const set = { x1: map.X(a), y1: map.Y(a), x2: map.X(b), y2: map.Y(b), stroke: qualityColour(between(link.quality, t)) };
    for (const [key, v] of Object.entries(set)) line.setAttribute(key, v);
    title.textContent = `${link.ends.join(" – ")}: ${link.of} ${shown(value)} ${link.unit}`;
  });
}

// What is in focus stands out, with a ring where its agents are when it is decided.
function showFocus(what) {
  const names = what ? what.names : [];
  map.root.classList.toggle("focused", names.length > 0);
  for (const node of map.root.querySelectorAll("[data-name]"))
    node.classList.toggle("lit", names.includes(node.getAttribute("data-name")));
  for (const node of map.root.querySelectorAll("[data-link]"))
    node.classList.toggle("lit", node.getAttribute("data-link").split(" ").every((n) => names.includes(n)));
  if (!map.ghosts) return;
  clear(map.ghosts);
  if (!what || what.needs.length !== 1) return;
  const need = DATA.needs[what.needs[0]];
  for (const agent of DATA.scene.agents) {
    if (need.step === null || !need.about.includes(agent.name)) continue;
    const at = place(agent, need.step);
    draw("circle", { cx: map.X(at), cy: map.Y(at), r: 12, stroke: agent.colour }, map.ghosts);
    draw("text", { x: map.X(at) + 14, y: map.Y(at) + 16, text: `step ${need.step}` }, map.ghosts);
  }
}

function mapKey() {
  const root = document.getElementById("key"), links = DATA.scene.links;
  if (!links.length || !DATA.scene.box) return;
  const asked = links.some((link) => link.asked);
  const words = asked ? ["misses what is asked", "just so", "exceeds it"] : ["worst", "links", "best"];
  make("span", { text: words[0] }, root);
  make("i", { class: "ramp", title: "quality of links" }, root);
  make("span", { text: words[2] }, root);
  make("small", { text: `${links[0].of}${asked ? "; the middle is the level asked for" : ""}` }, root);
}

onTime((t) => map.movers.forEach((move) => move(t)));
onFocus(showFocus);
