// Requirements: a card each, joined to the lines of the text.
let needMovers = [];

function drawNeed(root, need, k) {
  const card = make("article", { class: `need ${need.ok ? "good" : "bad"}`, tabindex: 0, "data-need": k }, root);
  const head = make("h3", {}, card);
  make("span", { class: "mark", text: need.ok ? "✓" : "✗" }, head);
  make("span", { text: need.name }, head);
  if (need.tight && need.ok) make("em", { text: "tight" }, head);
  make("b", { text: need.slack, title: "slack: robustness less margin" }, head);
  if (need.value) make("p", { text: need.value }, card);
  const step = need.step === null ? "" : ` at step ${need.step} (${seconds(need.step)})`;
  if (need.decides) {
    const line = make("p", {}, card);
    make("code", { text: need.decides }, line);
    make("span", { text: ` decides${step}` }, line);
  }
  if (need.price) make("p", { text: `more margin costs ${need.price}` }, card);
  if (need.curve) needMovers.push(drawCurve(card, need));
  pointed(card, () => focusNeeds([k]));
  card.addEventListener("click", (event) => {
    if (need.step !== null && !event.target.closest("svg")) seek(need.step);
  });
}

function drawCurve(card, need) {
  const { values, step, window: asked } = need.curve;
  const wide = Math.max(card.clientWidth - 26, 180), tall = 54;
  const svg = draw("svg", { width: wide, height: tall, class: "strip" }, card);
  const X = (k) => 6 + ((wide - 12) * k) / Math.max(T, 1);
  const finite = values.filter((v) => v !== null);
  const low = Math.min(0, ...finite), high = Math.max(0, ...finite), range = high - low || 1;
  const Y = (v) => 8 + ((tall - 22) * (high - v)) / range;
  const [a, b] = asked.map((x) => clamp(x, 0, T));
  draw("rect", { x: X(a) - 2, width: X(b) - X(a) + 4, y: 2, height: tall - 12, class: "asked" }, svg);
  draw("line", { x1: 4, x2: wide - 4, y1: Y(0), y2: Y(0), class: "zero" }, svg);
  draw("path", { d: pathOf(values, X, Y, false), class: "curve" }, svg);
  values.forEach((v, k) => {
    if (v === null || values.length > 80) return;
    draw("circle", { cx: X(k), cy: Y(v), r: 2.2, class: v >= -1e-6 ? "good" : need.ok ? "not" : "bad" }, svg);
  });
  if (values[step] !== null && values[step] !== undefined)
    draw("circle", { cx: X(step), cy: Y(values[step]), r: 5, class: "decides" }, svg);
  const now = draw("line", { y1: 2, y2: tall - 10, class: "now" }, svg);
  timeTicks(svg, X, tall - 1);
  scrub(svg, (x) => ((x - 6) / (wide - 12)) * T);
  return (t) => {
    now.setAttribute("x1", X(t));
    now.setAttribute("x2", X(t));
  };
}

function drawNeeds() {
  const root = document.getElementById("needs");
  clear(root);
  needMovers = [];
  DATA.needs.forEach((need, k) => drawNeed(root, need, k));
  needMovers.forEach((move) => move(state.t));
}

function joinText() {
  for (const line of document.querySelectorAll("li[data-needs]")) {
    const ks = line.getAttribute("data-needs").split(" ").map(Number);
    pointed(line, () => focusNeeds(ks));
    line.addEventListener("click", () => {
      const step = DATA.needs[ks[0]].step;
      if (step !== null) seek(step);
    });
  }
}

function showNeeds(what) {
  const lit = what ? what.needs : [];
  for (const card of document.querySelectorAll("[data-need]"))
    card.classList.toggle("lit", lit.includes(Number(card.getAttribute("data-need"))));
  for (const line of document.querySelectorAll("li[data-needs]")) {
    const ks = line.getAttribute("data-needs").split(" ").map(Number);
    line.classList.toggle("lit", ks.some((k) => lit.includes(k)));
  }
  showLine(document.querySelector("li.lit"));
}

// Scrolls the text alone, never the page.
function showLine(line) {
  const box = line && line.parentElement;
  if (!box || box.matches(":hover") || box.scrollHeight <= box.clientHeight) return;
  const top = line.offsetTop - box.offsetTop;
  if (top < box.scrollTop || top > box.scrollTop + box.clientHeight - 30)
    box.scrollTop = top - box.clientHeight / 2;
}

onTime((t) => needMovers.forEach((move) => move(t)));
onFocus(showNeeds);
