"use strict";
// What every part of the page shares: the data, the moment shown, elements, numbers.
const DATA = JSON.parse(document.getElementById("data").textContent);
const T = DATA.horizon;
const state = { t: 0, focus: null, listeners: [], focusListeners: [] };

function make(tag, attributes, parent) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes || {})) {
    if (key === "text") node.textContent = value;
    else node.setAttribute(key, value);
  }
  if (parent) parent.append(node);
  return node;
}

function draw(tag, attributes, parent) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [key, value] of Object.entries(attributes || {})) {
    if (key === "text") node.textContent = value;
    else node.setAttribute(key, value);
  }
  if (parent) parent.append(node);
  return node;
}

function clear(node) {
  while (node.firstChild) node.firstChild.remove();
}

const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

function shown(x) {
  if (x === null || x === undefined) return "–";
  if (Math.abs(x) < 1e-9) return "0";
  return Math.abs(x) >= 1e5 || Math.abs(x) < 1e-3 ? x.toExponential(2) : String(+x.toPrecision(4));
}

// The value of a list between its entries; `hold` keeps the last one.
function between(values, at, hold) {
  const last = values.length - 1;
  const k = clamp(Math.floor(at + 1e-9), 0, last);
  if (hold || k >= last) return values[k];
  const a = values[k], b = values[k + 1];
  if (a === null || b === null) return at - k < 0.5 ? a : b;
  return a + (at - k) * (b - a);
}

function seconds(t) {
  const s = t * DATA.step, whole = T * DATA.step;
  if (whole >= 7200) return (s / 3600).toFixed(2) + " h";
  if (whole >= 600) return (s / 60).toFixed(1) + " min";
  return s.toFixed(whole >= 100 ? 1 : 2) + " s";
}

function onTime(listener) { state.listeners.push(listener); }

function seek(t) {
  state.t = clamp(t, 0, T);
  for (const listener of state.listeners) listener(state.t);
}

// A focus says which requirements and names are meant, whatever was pointed at.
function onFocus(listener) { state.focusListeners.push(listener); }

function focus(needs, names) {
  state.focus = needs.length || names.length ? { needs, names } : null;
  for (const listener of state.focusListeners) listener(state.focus);
}

const focusNeeds = (ks) =>
  focus(ks, [...new Set(ks.flatMap((k) => DATA.needs[k].names))]);

function focusName(name) {
  const ks = DATA.needs.map((need, k) => (need.names.includes(name) ? k : -1));
  focus(ks.filter((k) => k >= 0), [name]);
}

// Whoever is pointed at, or reached by the keyboard, is in focus until that ends.
function pointed(node, begin) {
  const end = () => focus([], []);
  node.addEventListener("mouseenter", begin);
  node.addEventListener("mouseleave", end);
  node.addEventListener("focus", begin);
  node.addEventListener("blur", end);
}

function niceStep(range, most) {
  const rough = range / most, power = 10 ** Math.floor(Math.log10(rough));
  return [1, 2, 2.5, 5, 10].map((m) => m * power).find((s) => s >= rough * 0.999);
}
