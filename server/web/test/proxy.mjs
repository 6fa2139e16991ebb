// A server in front of another one, whose troubles a test decides.

import { once } from "node:events";
import { Agent, createServer, request } from "node:http";

/** Answers as the server at an address does, but for what `trouble` says of a request's path: see {@link Trouble}. */
export async function troubled(backend) {
  const target = new URL(backend);
  const agent = new Agent({ keepAlive: true });
  const sockets = new Set();
  const proxy = { asked: 0, trouble: () => undefined };
  const server = createServer(async (asked, answer) => {
    proxy.asked++;
    const { status, delay = 0, bytesPerSecond = Infinity, breaksAfter = Infinity } = proxy.trouble(asked.url) ?? {};
    await wait(delay);
    if (status !== undefined) return answer.writeHead(status).end();
    const options = { host: target.hostname, port: target.port, path: asked.url, method: asked.method, headers: asked.headers, agent };
    const forwarded = request(options, async (found) => {
      answer.writeHead(found.statusCode, { ...found.headers, "access-control-allow-origin": "*" });
      let left = breaksAfter;
      for await (const chunk of found) {
        for (let at = 0; at < chunk.length; at += 1024) {
          const part = chunk.subarray(at, Math.min(at + 1024, chunk.length, at + left));
          answer.write(part);
          left -= part.length;
          await wait((1000 * part.length) / bytesPerSecond);
          if (left === 0) return answer.destroy();
        }
      }
      answer.end();
    });
    forwarded.on("error", () => answer.destroy());
    asked.pipe(forwarded);
  });
  server.on("connection", (socket) => {
    sockets.add(socket);
    socket.on("error", () => {});
    socket.on("close", () => sockets.delete(socket));
  });
  await listen(server, 0);
  const { port } = server.address();
  const die = async () => {
    server.close();
    for (const socket of sockets) socket.destroy();
    await once(server, "close");
  };
  const stop = async () => {
    if (server.listening) await die();
    agent.destroy();
  };
  return Object.assign(proxy, { url: `http://127.0.0.1:${port}/`, die, comeBack: () => listen(server, port), stop });
}

/**
 * @typedef {object} Trouble
 * @property {number} [status] what is answered instead
 * @property {number} [delay] milliseconds before an answer
 * @property {number} [bytesPerSecond] of its body
 * @property {number} [breaksAfter] bytes of its body after which the connection breaks
 */

async function listen(server, port) {
  server.listen(port, "127.0.0.1");
  await once(server, "listening");
}

const wait = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));
