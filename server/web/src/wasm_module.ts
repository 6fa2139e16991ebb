// Modules of WebAssembly: each fetched and compiled once, for this thread and for workers.

/** What gives the module at an address, which is fetched when that is first called, and again only where it failed. */
export function compiledOnce(url: URL): () => Promise<WebAssembly.Module> {
  let compiled: Promise<WebAssembly.Module> | undefined;
  return () => {
    compiled ??= compile(url).catch((error: unknown) => {
      compiled = undefined;
      throw error;
    });
    return compiled;
  };
}

async function compile(url: URL): Promise<WebAssembly.Module> {
  return WebAssembly.compile(url.protocol === "file:" ? await fileAt(url) : await bytesAt(url));
}

/** Whatever type the server says it is of. */
async function bytesAt(url: URL): Promise<ArrayBuffer> {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`the decoder is not at ${url.pathname} (HTTP ${response.status})`);
  return response.arrayBuffer();
}

/** Outside browsers, where files are not fetched. */
async function fileAt(url: URL): Promise<Uint8Array<ArrayBuffer>> {
  const module = "node:fs/promises";
  const { readFile } = (await import(/* @vite-ignore */ module)) as typeof import("node:fs/promises");
  return new Uint8Array(await readFile(url));
}
