// Runs the prototype's script without an X3D browser: what it is given and what it sends are plain objects.

import { readFile } from "node:fs/promises";
import vm from "node:vm";

const SOURCE = await readFile(new URL("../../tiles/src/x3d/multilevel.js", import.meta.url), "utf8");

class SFVec3f {
  constructor(x, y, z) {
    Object.assign(this, { x, y, z });
  }
}

/**
 * A script that streams what `send(text)` gives it, up to `close()`. `drawn()` is what the IndexedFaceSet holds, `events`
 * what the script has sent, `errors` what it told the console.
 */
export function startScript({ status = 200, origin = [0, 0, 0] } = {}) {
  let stream;
  const body = new ReadableStream({ start: (controller) => (stream = controller) });
  const [events, errors, requests] = [[], [], []];
  const [x, y, z] = origin;
  const ifs = { coord: { point: [] }, coordIndex: [] };
  const fields = { urlData: "model.lod", debug: false, origin: { x, y, z }, ifs };
  const browser = { Browser: { currentScene: { worldURL: "http://host/folder/world.x3d" } }, SFVec3f };
  const arrays = { MFVec3f: Array, MFInt32: Array };
  const fetch = async (url) => {
    requests.push(String(url));
    return { ok: status === 200, status, body };
  };
  const console = { error: (message) => errors.push(message) };
  const script = { ...fields, ...browser, ...arrays, fetch, console, URL, AbortController, TextDecoderStream };
  for (const name of ["isReady", "level_changed", "levelCount_changed"]) {
    Object.defineProperty(script, name, { set: (value) => takeEvent(name, value) });
  }
  function takeEvent(name, value) {
    events.push([name, value]);
    if (name === "isReady") script.update(value);
  }
  vm.runInContext(SOURCE, vm.createContext(script));
  script.initialize();
  return {
    script,
    events,
    errors,
    requests,
    drawn: () => ({ triangles: trianglesOf(ifs.coordIndex), positions: ifs.coord.point.map(({ x, y, z }) => [x, y, z]) }),
    send: (text) => stream.enqueue(new TextEncoder().encode(text)),
    close: () => stream.close(),
    fail: () => stream.error(new Error("the connection broke")),
    /** Lets the script read what it has been sent. */
    settle: () => new Promise((resolve) => setTimeout(resolve, 5)),
  };
}

/** Triangles of a coordIndex, each of which must end with −1. */
export function trianglesOf(coordIndex) {
  const triangles = [];
  for (let at = 0; at < coordIndex.length; at += 4) {
    if (coordIndex[at + 3] !== -1) throw new Error(`no end of a triangle at ${at + 3}`);
    triangles.push(Array.from(coordIndex.slice(at, at + 3)));
  }
  return triangles;
}
