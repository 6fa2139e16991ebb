//! What an operator can set: by flags, by variables of the environment, by a file; the first that says something counts.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Parser, ValueEnum};
use figment::Figment;
use figment::providers::{Format, Serialized, Toml};
use serde::{Deserialize, Serialize};

/// Serves terrain archives made by terrain-ingest.
///
/// Open the printed address in a browser to fly over the terrain. CesiumJS and other clients of quantized-mesh take
/// http://HOST:PORT/NAME as the address of their terrain, NAME being the archive's file name without its ending; clients of 3D Tiles
/// take http://HOST:PORT/NAME/3d-tiles/tileset.json.
#[derive(Debug, Parser, Serialize)]
#[command(
    version,
    after_help = "Examples:\n  terrain-server fault.pmtiles\n  terrain-server /srv/terrain --listen 0.0.0.0:80 --access-log text\n  \
        terrain-server s3://bucket/alps.pmtiles\n\n\
        In CesiumJS:\n  viewer.terrainProvider = await Cesium.CesiumTerrainProvider.fromUrl(\n    \
        'http://127.0.0.1:8080/fault', { requestVertexNormals: true })\n\n\
        A settings file has the names of the flags, with _ for -, in TOML: archives = [\"/srv/terrain\"], max_connections = 500.\n\n\
        SIGHUP looks at the archives again at once. SIGTERM and Ctrl-C answer what was asked, then stop.\n\n\
        Exit codes: 0 after Ctrl-C or SIGTERM, 2 when an archive or the settings cannot be read or the address cannot be listened on."
)]
pub struct Given {
    /// Archives, each served under its file name without its ending, at paths or addresses (s3://, gs://, az://, https://; how to reach a
    /// bucket is taken from the environment, as each cloud's own tools do), and folders, whose files that end in .pmtiles are served.
    #[arg(value_name = "ARCHIVE|FOLDER|ADDRESS")]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    archives: Vec<PathBuf>,

    /// File of settings.
    #[arg(long, value_name = "FILE", env = "TERRAIN_SETTINGS")]
    #[serde(skip)]
    settings: Option<PathBuf>,

    /// Where to listen [default: 127.0.0.1:8080]. Port 0 takes any free port; 0.0.0.0 makes the server reachable from other machines.
    #[arg(long, value_name = "ADDRESS:PORT", env = "TERRAIN_LISTEN")]
    #[serde(skip_serializing_if = "Option::is_none")]
    listen: Option<SocketAddr>,

    /// Path before all paths, for a server behind a proxy that passes them on: /terrain.
    #[arg(long, value_name = "PATH", env = "TERRAIN_BASE_PATH")]
    #[serde(skip_serializing_if = "Option::is_none")]
    base_path: Option<String>,

    /// Address that clients reach the server at, for documents that have to tell it [default: that of each request's Host].
    #[arg(long, value_name = "URL", env = "TERRAIN_PUBLIC_URL")]
    #[serde(skip_serializing_if = "Option::is_none")]
    public_url: Option<String>,

    /// Origins whose pages may read answers [default: all]; may be given several times.
    #[arg(long, value_name = "ORIGIN", env = "TERRAIN_ALLOW_ORIGIN", value_delimiter = ',')]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    allow_origin: Vec<String>,

    /// Answers nobody who does not show this token: Authorization: Bearer TOKEN. Better not given as a flag, which others can see.
    #[arg(long, env = "TERRAIN_TOKEN", hide_env_values = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    token: Option<String>,

    /// Lines of the access log, on standard output [default: off].
    #[arg(long, value_enum, env = "TERRAIN_ACCESS_LOG")]
    #[serde(skip_serializing_if = "Option::is_none")]
    access_log: Option<AccessLog>,

    /// Seconds from one look at the archives to the next [default: 2]; 0 looks on SIGHUP only.
    #[arg(long, value_name = "SECONDS", env = "TERRAIN_LOOK_EVERY")]
    #[serde(skip_serializing_if = "Option::is_none")]
    look_every: Option<u64>,

    /// Encoded tiles and documents kept in memory, MiB [default: 256].
    #[arg(long, value_name = "MIB", env = "TERRAIN_CACHE")]
    #[serde(skip_serializing_if = "Option::is_none")]
    cache: Option<u64>,

    /// Most connections at once [default: 10000, or what the system allows]; others wait.
    #[arg(long, value_name = "COUNT", env = "TERRAIN_MAX_CONNECTIONS")]
    #[serde(skip_serializing_if = "Option::is_none")]
    max_connections: Option<usize>,

    /// Seconds in which a request's headers must come, counted from the answer before: idle connections end, too [default: 15].
    #[arg(long, value_name = "SECONDS", env = "TERRAIN_HEADER_TIMEOUT")]
    #[serde(skip_serializing_if = "Option::is_none")]
    header_timeout: Option<u64>,

    /// Seconds in which a request must be answered, its body read [default: 30].
    #[arg(long, value_name = "SECONDS", env = "TERRAIN_ANSWER_TIMEOUT")]
    #[serde(skip_serializing_if = "Option::is_none")]
    answer_timeout: Option<u64>,

    /// Seconds without a byte taken after which a client that reads an answer is left [default: 30].
    #[arg(long, value_name = "SECONDS", env = "TERRAIN_WRITE_TIMEOUT")]
    #[serde(skip_serializing_if = "Option::is_none")]
    write_timeout: Option<u64>,

    /// Most bytes of a request's headers, KiB [default: 16].
    #[arg(long, value_name = "KIB", env = "TERRAIN_MAX_HEADERS")]
    #[serde(skip_serializing_if = "Option::is_none")]
    max_headers: Option<usize>,

    /// Most bytes of a request's body, KiB [default: 1024].
    #[arg(long, value_name = "KIB", env = "TERRAIN_MAX_BODY")]
    #[serde(skip_serializing_if = "Option::is_none")]
    max_body: Option<usize>,

    /// Seconds for what was asked to be answered when the server is to stop [default: 10].
    #[arg(long, value_name = "SECONDS", env = "TERRAIN_STOP_WITHIN")]
    #[serde(skip_serializing_if = "Option::is_none")]
    stop_within: Option<u64>,
}

/// In which form an access log is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AccessLog {
    /// Not at all.
    #[default]
    Off,
    /// A line for people.
    Text,
    /// A line of JSON.
    Json,
}

/// All settings, each the one that was given or its default; [`Given`] says what they mean.
#[expect(missing_docs, reason = "they stand with the flags")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    pub archives: Vec<PathBuf>,
    pub listen: SocketAddr,
    pub base_path: String,
    pub public_url: Option<String>,
    pub allow_origin: Vec<String>,
    pub token: Option<String>,
    pub access_log: AccessLog,
    pub look_every: u64,
    pub cache: u64,
    pub max_connections: usize,
    pub header_timeout: u64,
    pub answer_timeout: u64,
    pub write_timeout: u64,
    pub max_headers: usize,
    pub max_body: usize,
    pub stop_within: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            archives: Vec::new(),
            listen: SocketAddr::from(([127, 0, 0, 1], 8080)),
            base_path: String::new(),
            public_url: None,
            allow_origin: Vec::new(),
            token: None,
            access_log: AccessLog::Off,
            look_every: 2,
            cache: 256,
            max_connections: 10_000,
            header_timeout: 15,
            answer_timeout: 30,
            write_timeout: 30,
            max_headers: 16,
            max_body: 1024,
            stop_within: 10,
        }
    }
}

impl Settings {
    /// What was given on the command line and in the environment, then what the file says.
    ///
    /// # Errors
    /// When the file cannot be read or has a name that is not known, or there is nothing to serve.
    pub fn from_given(given: &Given) -> anyhow::Result<Self> {
        let mut layers = Figment::from(Serialized::defaults(Self::default()));
        if let Some(path) = &given.settings {
            check_readable(path)?;
            layers = layers.merge(Toml::file_exact(path));
        }
        let settings: Self = layers.merge(Serialized::defaults(given)).extract()?;
        settings.check()?;
        Ok(settings)
    }

    fn check(&self) -> anyhow::Result<()> {
        let base = &self.base_path;
        anyhow::ensure!(
            !self.archives.is_empty(),
            "no archive and no folder is given; --help tells how"
        );
        anyhow::ensure!(
            base.is_empty()
                || base.len() > 1 && base.starts_with('/') && !base.ends_with('/') && !base.contains(['{', '*']),
            "the base path begins with / and does not end with it: /terrain"
        );
        anyhow::ensure!(self.max_connections > 0, "no connection is allowed");
        anyhow::ensure!(self.max_headers >= 8, "headers need 8 KiB at least");
        Ok(())
    }
}

fn check_readable(path: &Path) -> anyhow::Result<()> {
    std::fs::File::open(path)
        .map(drop)
        .with_context(|| format!("{}", path.display()))
}
