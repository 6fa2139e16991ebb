//! Makes sure that there is a page to embed: a stand-in where the viewer has not been built.

use std::fs;
use std::io;
use std::path::Path;

const STAND_IN: &str = "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>Terrain server</title>\n\
    <p>The viewer is not built: run <code>npm ci &amp;&amp; npm run build</code> in <code>server/web</code>, \
    then build the server again.</p>\n<p>The tiles are served all the same: <a href=\"/tilesets\">/tilesets</a>.</p>\n</html>\n";

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-changed=web/dist");
    let dist = Path::new("web/dist");
    fs::create_dir_all(dist)?;
    let page = dist.join("index.html");
    if page.exists() {
        Ok(())
    } else {
        fs::write(page, STAND_IN)
    }
}
