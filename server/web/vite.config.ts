import { defineConfig } from "vite";

// Every address in the page is relative, so that it works below any path of a proxy.
export default defineConfig({
  base: "./",
  build: { target: "es2022", chunkSizeWarningLimit: 1000, rollupOptions: { input: ["index.html", "curved.html", "model.html"] } },
  server: { proxy: { "^/(tilesets$|.*/profile$|.*\\.(spt|clod|spm|png)(\\?|$))": "http://127.0.0.1:8080" } },
});
