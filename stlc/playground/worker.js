// Python in a worker: everything comes in one message, nothing from anywhere else.
const HOME = "https://nowhere.invalid/";
let answer = null;

// From disk only a classic worker can be made, of a blob, and only modules of its own blobs be
// imported; Pyodide refuses where scripts can be, so that goes.
self.importScripts = () => { throw new Error("there are no other scripts"); };

const imported = (script) => import(URL.createObjectURL(new Blob([script], { type: "text/javascript" })));

async function begin({ asm, pyodide: script, files, lock, wheels, data }) {
  const memory = new Map(Object.entries(files));
  self.fetch = async (address) => {
    const name = String(address).split("/").pop();
    if (!memory.has(name)) throw new TypeError(`${name} is not part of this page`);
    const type = name.endsWith(".wasm") ? "application/wasm" : "application/octet-stream";
    return new Response(memory.get(name), { headers: { "Content-Type": type } });
  };
  const { default: createPyodideModule } = await imported(asm);
  const { loadPyodide } = await imported(script);
  const python = await loadPyodide({ indexURL: HOME, createPyodideModule, lockFileContents: lock });
  for (const [, wheel] of wheels) python.unpackArchive(wheel, "wheel");
  python.FS.mkdirTree("data");
  for (const [name, text] of Object.entries(data)) {
    python.FS.mkdirTree(name.slice(0, name.lastIndexOf("/")));
    python.FS.writeFile(name, text);
  }
  python.runPython("from stlc.playground.engine import abilities, answer");
  answer = python.globals.get("answer");
  const lacks = python.runPython("import json; json.dumps(abilities())");
  return { version: python.runPython("import platform; platform.python_version()"),
    abilities: JSON.parse(lacks) };
}

self.onmessage = async ({ data: { id, start, request } }) => {
  try {
    self.postMessage({ id, result: start ? await begin(start) : answer(request) });
  } catch (error) {
    self.postMessage({ id, failed: String(error.message || error) });
  }
};
