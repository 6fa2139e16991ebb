// Runs the prototype's script without an X3D browser: what it is given and what it sends are plain objects.

import { readFile } from "node:fs/promises";
import vm from "node:vm";

const SOURCE = await readFile(new URL("../../tiles/src/formats/x3d/multilevel.js", import.meta.url), "utf8");

class SFVec3f {
  constructor(x, y, z) {
    Object.assign(this, { x, y, z });
  }
}

/** What an X3D browser gives the script; whatever the script does to it goes into `seen`. */
function browserFor(seen, { status = 200, origin = [0, 0, 0], debug = false }) {
  const [x, y, z] = origin;
  const currentScene = { worldURL: "http://host/folder/world.x3d" };
  const fetch = async (url) => {
    seen.requests.push(String(url));
    return { ok: status === 200, status, body: seen.body };
  };
  return {
    ...{ urlData: "model.lod", debug, origin: { x, y, z }, ifs: seen.ifs },
    ...{ SFVec3f, MFVec3f: Array, MFInt32: Array },
    Browser: { currentScene, println: (line) => seen.printed.push(line) },
    console: { error: (line) => seen.errors.push(line) },
    ...{ fetch, URL, AbortController, TextDecoderStream },
  };
}

/** Takes the events that the script sends; the ROUTE of the prototype turns `isReady` into `update`. */
function connect(script, events) {
  const take = (name, value) => {
    events.push([name, value]);
    if (name === "isReady") script.update(value);
  };
  for (const name of ["isReady", "level_changed", "levelCount_changed"]) {
    Object.defineProperty(script, name, { set: (value) => take(name, value) });
  }
}

/**
 * A script that streams what `send(text)` gives it, up to `close()` or `fail()`. `drawn()` is what the IndexedFaceSet holds,
 * `events` what the script has sent, `errors` and `printed` what it told the console and the browser, `requests` what it
 * asked a server for.
 */
export function startScript(options = {}) {
  let stream;
  const body = new ReadableStream({ start: (controller) => (stream = controller) });
  const ifs = { coord: { point: [] }, coordIndex: [] };
  const seen = { body, ifs, events: [], errors: [], printed: [], requests: [] };
  const script = browserFor(seen, options);
  connect(script, seen.events);
  vm.runInContext(SOURCE, vm.createContext(script));
  script.initialize();
  return {
    ...seen,
    script,
    drawn: () => ({ triangles: trianglesOf(ifs.coordIndex), positions: ifs.coord.point.map(({ x, y, z }) => [x, y, z]) }),
    send: (text) => stream.enqueue(new TextEncoder().encode(text)),
    close: () => stream.close(),
    fail: () => stream.error(new Error("the connection broke")),
    /** Lets the script read what it has been sent. */
    settle: () => new Promise((resolve) => setTimeout(resolve, 5)),
  };
}

/** Triangles of a coordIndex, each of which must end with −1. */
function trianglesOf(coordIndex) {
  const triangles = [];
  for (let at = 0; at < coordIndex.length; at += 4) {
    if (coordIndex[at + 3] !== -1) throw new Error(`no end of a triangle at ${at + 3}`);
    triangles.push(Array.from(coordIndex.slice(at, at + 3)));
  }
  return triangles;
}
