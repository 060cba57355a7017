"use strict";
// The page: an editor over marks, the engine in a worker, the report in a frame.
const at = (id) => document.getElementById(id);
const text = at("text"), marks = at("marks");
let worker = null, abilities = null, calls = new Map(), count = 0, waiting = null;

const bytes = (word) => Uint8Array.from(atob(word), (c) => c.charCodeAt(0));

async function unpacked(word) {
  const flow = new Blob([bytes(word)]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(flow).arrayBuffer();
}

async function start() {
  tell("Loading Python");
  at("stop").hidden = true;
  const { scripts, files, wheels, data, lock } = STLC;
  const sources = {};
  for (const [name, word] of Object.entries(scripts)) sources[name] = await unpacked(word);
  const memory = {};
  for (const [name, { gz, word }] of Object.entries(files)) {
    memory[name] = gz ? await unpacked(word) : bytes(word).buffer;
  }
  worker = new Worker(URL.createObjectURL(new Blob([sources["worker.js"]], { type: "text/javascript" })));
  worker.onmessage = ({ data: answer }) => {
    const call = calls.get(answer.id);
    calls.delete(answer.id);
    if (call) (answer.failed ? call.fail(new Error(answer.failed)) : call.done(answer.result));
  };
  worker.onerror = (event) => tell(`The engine could not start: ${event.message}`);
  const begun = await call({
    start: {
      asm: sources["pyodide.asm.mjs"], pyodide: sources["pyodide.mjs"],
      files: memory, lock, data, wheels: wheels.map(({ name, word }) => [name, bytes(word).buffer]),
    },
  });
  abilities = begun.abilities;
  document.body.dataset.ready = begun.version;
  at("format").disabled = at("solve").disabled = false;
  tell(`stlc ${STLC.version} on Python ${begun.version}${lacking()}`);
  examine();
}

function lacking() {
  if (abilities.check.length) {
    return "; what texts mean is not checked here and only the missions of the list have plans: " +
      `this page was built without ${abilities.solve.join(", ")}`;
  }
  return abilities.solve.length ? `; nothing is solved here without ${abilities.solve.join(", ")}` : "";
}

function call(message) {
  const id = ++count;
  return new Promise((done, fail) => {
    calls.set(id, { done, fail });
    worker.postMessage({ id, ...message });
  });
}

const ask = async (request) => JSON.parse(await call({ request: JSON.stringify(request) }));
const tell = (words) => { at("state").textContent = words; };

function element(name, words, kind) {
  const made = document.createElement(name);
  if (words) made.textContent = words;
  if (kind) made.className = kind;
  return made;
}

// Spans count characters, strings here count UTF-16 units.
function units(characters) {
  let k = 0;
  for (const c of text.value) {
    if (characters-- <= 0) break;
    k += c.length;
  }
  return k;
}

function mark(problems) {
  const spans = problems.filter((p) => p.span && p.span.file === "mission.stl").map((p) => ({
    from: units(p.span.start.offset), to: units(p.span.end.offset), kind: p.severity,
  })).sort((a, b) => a.from - b.from);
  marks.textContent = "";
  let done = 0;
  for (const { from, to, kind } of spans) {
    if (from < done) continue;
    const end = Math.max(to, from + 1);
    marks.append(text.value.slice(done, from), element("mark", text.value.slice(from, end) || " ", kind));
    done = end;
  }
  marks.append(`${text.value.slice(done)}\n`);
  scroll();
}

function scroll() { marks.scrollTop = text.scrollTop; marks.scrollLeft = text.scrollLeft; }

function select(span) {
  text.focus();
  text.setSelectionRange(units(span.start.offset), units(span.end.offset));
  text.scrollTop = (span.start.line - 4) * parseFloat(getComputedStyle(text).lineHeight);
}

function list(problems, summary, depth) {
  const entries = problems.map((p) => {
    const item = element("li", "", p.severity);
    const where = p.span ? `${p.span.start.line}:${p.span.start.column} ` : "";
    const head = element("button", `${where}${p.severity}[${p.code}]: ${p.title}`);
    head.type = "button";
    if (p.span) head.onclick = () => select(p.span);
    item.append(head);
    for (const more of [p.label, p.help, ...p.notes.map((n) => n.text)]) {
      if (more) item.append(element("p", more));
    }
    return item;
  });
  if (!problems.length) {
    entries.push(depth === "meaning" ? element("li", summary, "good")
      : element("li", "No mistake of syntax; names, units and sizes are not checked here", "soft"));
  }
  at("problems").replaceChildren(...entries);
}

async function examine() {
  const asked = text.value;
  const found = await ask({ do: "examine", text: asked });
  if (asked !== text.value) return;
  mark(found.problems);
  list(found.problems, found.summary, found.depth);
  document.body.dataset.problems = String(found.problems.length);
}

function typed() {
  mark([]);
  clearTimeout(waiting);
  if (abilities) waiting = setTimeout(examine, 250);
}

async function format() {
  const answer = await ask({ do: "format", text: text.value });
  if (answer.problems) list(answer.problems, "", "syntax");
  else { text.value = answer.text; examine(); }
}

const chosen = () => STLC.examples[at("example").value];
const known = () => chosen().text === text.value && chosen().report;

function show(report, words) {
  at("said").textContent = words;
  at("report").srcdoc = report;
}

async function solve() {
  if (abilities.solve.length) {
    if (known()) showKnown();
    else at("said").textContent = "Nothing can be solved here. On a computer with Python: " +
      "pip install stlc, stlc solve mission.stl -o plan.json, stlc report mission.stl plan.json -o plan.html";
    return;
  }
  at("solve").disabled = true;
  at("stop").hidden = false;
  tell("Solving");
  const answer = await ask({ do: "solve", text: text.value });
  at("solve").disabled = false;
  at("stop").hidden = true;
  tell("");
  if (answer.report) show(answer.report, answer.said);
  else { at("said").textContent = answer.error; if (answer.problems) list(answer.problems, "", "meaning"); }
}

function showKnown() {
  show(chosen().report, "The plan that was made, certified and verified when this page was built.");
}

function choose() {
  text.value = chosen().text;
  text.scrollTop = 0;
  at("report").removeAttribute("srcdoc");
  at("said").textContent = "";
  if (known()) showKnown();
  typed();
}

at("example").append(...STLC.examples.map(({ name }, k) => {
  const option = element("option", name);
  option.value = k;
  return option;
}));
at("example").onchange = choose;
text.oninput = typed;
text.onscroll = scroll;
at("format").onclick = format;
at("solve").onclick = solve;
at("stop").onclick = () => { worker.terminate(); calls.clear(); start(); };
choose();
start().catch((error) => tell(`The engine could not start: ${error.message}`));
