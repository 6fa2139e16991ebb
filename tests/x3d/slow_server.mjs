// A web server that sends one kind of file no faster than it is told to.

import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { extname, join } from "node:path";

const TYPES = {
  ".css": "text/css",
  ".html": "text/html",
  ".js": "text/javascript",
  ".mjs": "text/javascript",
  ".wrl": "model/vrml",
  ".x3d": "model/x3d+xml",
};

/** Serves `folders`, by the first part of a path; of files with the extension `slow`, only what has been released. */
export async function serve(folders, slow) {
  const waiting = { response: undefined, bytes: undefined, sent: 0 };
  const server = createServer(async ({ url }, response) => {
    const path = decodeURIComponent(new URL(url, "http://host").pathname);
    const [first, ...rest] = path.slice(1).split("/");
    const bytes = await readFile(join(folders[first] ?? "", ...rest)).catch(() => undefined);
    if (bytes === undefined) return response.writeHead(404).end();
    response.setHeader("Content-Type", TYPES[extname(path)] ?? "application/octet-stream");
    if (extname(path) !== slow) return response.end(bytes);
    Object.assign(waiting, { response, bytes, sent: 0 });
    response.flushHeaders();
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return {
    url: `http://127.0.0.1:${server.address().port}`,
    /** Whether the slow file has been asked for. */
    isAsked: () => waiting.response !== undefined,
    /** Sends the slow file up to byte `end`. */
    sendUpTo(end) {
      waiting.response.write(waiting.bytes.subarray(waiting.sent, end));
      waiting.sent = end;
    },
    /** Sends what is left of the slow file. */
    finish() {
      waiting.response.end(waiting.bytes.subarray(waiting.sent));
      waiting.response = undefined;
    },
    close: () => server.close(),
  };
}
