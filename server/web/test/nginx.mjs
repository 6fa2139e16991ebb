// A folder served by nginx, as a web server for files that knows nothing of terrain.

import { spawn } from "node:child_process";
import { once } from "node:events";
import { mkdtemp, rm, writeFile } from "node:fs/promises";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";

/** The address of a folder, the program's log of requests, and what ends it. It adds headers to its answers. */
export async function serveByNginx(folder, headers = {}) {
  const port = await freePort();
  const home = await mkdtemp(join(tmpdir(), "terrain-nginx-"));
  const log = join(home, "requests");
  await writeFile(join(home, "nginx.conf"), configuration(home, folder, port, log, headers));
  const nginx = spawn("nginx", ["-e", "stderr", "-p", home, "-c", join(home, "nginx.conf")], { stdio: ["ignore", "ignore", "inherit"] });
  const url = `http://127.0.0.1:${port}/`;
  await waitUntilAnswered(url);
  const stop = async () => {
    nginx.kill("SIGQUIT");
    await once(nginx, "exit");
    await rm(home, { recursive: true });
  };
  return { url, log, stop };
}

function configuration(home, folder, port, log, headers) {
  const added = Object.entries(headers).map(([name, value]) => `add_header ${name} "${value}";`);
  const temporary = ["client_body", "proxy", "fastcgi", "uwsgi", "scgi"].map((kind) => `${kind}_temp_path ${home}/${kind};`);
  return `daemon off; pid ${home}/pid; events {}
    ${process.getuid() === 0 ? "user root;" : ""}
    http {
      ${temporary.join(" ")}
      log_format plain "$status $request_uri $body_bytes_sent";
      access_log ${log} plain;
      types { text/html html; text/css css; text/javascript js; application/json json; }
      ${added.join(" ")}
      gzip on; gzip_types text/javascript;
      server { listen 127.0.0.1:${port}; root ${folder}; }
    }`;
}

async function freePort() {
  const server = createServer().listen(0, "127.0.0.1");
  await once(server, "listening");
  const { port } = server.address();
  server.close();
  await once(server, "close");
  return port;
}

async function waitUntilAnswered(url) {
  for (let tries = 0; tries < 100; tries++) {
    if (await fetch(url).then(() => true, () => false)) return;
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
  throw new Error("nginx does not answer: is it installed?");
}
