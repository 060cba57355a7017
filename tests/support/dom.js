// As much of a browser's document as a report asks for; what it doesn't know throws.
class Node {
  constructor(tag) {
    this.tagName = tag.toUpperCase(); this.children = []; this.attributes = {}; this.heard = {};
    this.classes = new Set(); this.text = ""; this.value = ""; this.parent = null;
    this.clientWidth = 600; this.clientHeight = 300; this.scrollHeight = 300; this.offsetTop = 0;
    const own = this.classes;
    this.classList = {
      toggle: (name, on) => { if (on === undefined ? !own.has(name) : on) own.add(name); else own.delete(name); },
      contains: (name) => own.has(name),
    };
  }
  setAttribute(key, value) {
    if (String(value).includes("NaN") || value === undefined) throw new Error(`${this.tagName} ${key}=${value}`);
    this.attributes[key] = String(value);
    if (key === "class") String(value).split(" ").forEach((name) => this.classes.add(name));
  }
  getAttribute(key) { return key in this.attributes ? this.attributes[key] : null; }
  append(...nodes) { for (const node of nodes) { this.children.push(node); node.parent = this; } }
  remove() { this.parent.children = this.parent.children.filter((node) => node !== this); }
  get firstChild() { return this.children[0] || null; }
  get parentElement() { return this.parent; }
  set textContent(text) { this.children = []; this.text = String(text); }
  get textContent() { return this.text + this.children.map((node) => node.textContent).join(""); }
  addEventListener(name, listener) { (this.heard[name] = this.heard[name] || []).push(listener); }
  fire(name, event) { for (const listener of this.heard[name] || []) listener({ target: this, preventDefault() {}, ...event }); }
  getBoundingClientRect() { return { left: 0, top: 0, width: 600, height: 300 }; }
  setPointerCapture() {}
  closest() { return null; }
  matches() { return false; }
  all() { return [this, ...this.children.flatMap((node) => node.all())]; }
  querySelectorAll(selector) {
    const match = /^([a-z]*)(?:\.([a-z]+))?(?:\[([a-z-]+)\])?$/.exec(selector);
    if (!match) throw new Error(`selector ${selector}`);
    const [, tag, css, attribute] = match;
    return this.all().filter((node) => (!tag || node.tagName === tag.toUpperCase()) &&
      (!css || node.classes.has(css)) && (!attribute || attribute in node.attributes));
  }
  querySelector(selector) { return this.querySelectorAll(selector)[0] || null; }
}

const frames = [];
const body = new Node("body"), ids = {};
const document = {
  body, heard: {},
  getElementById: (id) => { if (!(id in ids)) throw new Error(`no element ${id}`); return ids[id]; },
  createElement: (tag) => new Node(tag),
  createElementNS: (space, tag) => new Node(tag),
  querySelector: (selector) => body.querySelector(selector),
  querySelectorAll: (selector) => body.querySelectorAll(selector),
  addEventListener: Node.prototype.addEventListener,
  fire: Node.prototype.fire,
};
const window = { innerHeight: 800, heard: {}, addEventListener: Node.prototype.addEventListener, fire: Node.prototype.fire };
const location = { hash: "" };
const performance = { now: () => 0 };
const requestAnimationFrame = (callback) => frames.push(callback);

// `elements` are [tag, attributes] of the page, as its HTML has them.
function build(elements) {
  for (const [tag, attributes] of elements) {
    const node = new Node(tag);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    if (attributes.id) ids[attributes.id] = node;
    if ("value" in attributes) node.value = attributes.value;
    body.append(node);
  }
}
