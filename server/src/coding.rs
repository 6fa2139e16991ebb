//! Content codings (RFC 9110, 8.4): which one a client takes, and bytes in it.

use std::io::{self, Read, Write};

use axum::body::Bytes;
use axum::http::{HeaderMap, header};
use flate2::Compression;
use flate2::write::GzEncoder;

/// Brotli's quality and window (2^22 bytes): more costs ten times the time for some 5 %.
const BROTLI: (u32, u32) = (5, 22);
/// Of zstd's 22 levels the one from which on it gets slow.
const ZSTD_LEVEL: i32 = 9;

/// How a body is compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Coding {
    Identity,
    Brotli,
    Zstd,
    Gzip,
}

impl Coding {
    /// Best first, where a client takes several equally well.
    const COMPRESSED: [Self; 3] = [Self::Brotli, Self::Zstd, Self::Gzip];

    /// Its name in Content-Encoding.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Identity => "identity",
            Self::Brotli => "br",
            Self::Zstd => "zstd",
            Self::Gzip => "gzip",
        }
    }

    /// The one that the client's Accept-Encoding gives the greatest weight.
    pub(crate) fn accepted(headers: &HeaderMap) -> Self {
        let weights = weights(headers);
        let weight = |coding: Self| {
            let named = |name: &str| {
                weights
                    .iter()
                    .find(|(other, _)| other == name)
                    .map(|(_, weight)| *weight)
            };
            let alias = (coding == Self::Gzip).then(|| named("x-gzip")).flatten();
            named(coding.name()).or(alias).or(named("*")).unwrap_or(0.0)
        };
        let best = Self::COMPRESSED
            .into_iter()
            .reduce(|best, other| if weight(other) > weight(best) { other } else { best })
            .filter(|best| weight(*best) > 0.0);
        best.unwrap_or(Self::Identity)
    }

    /// `bytes` in this coding.
    pub(crate) fn encode(self, bytes: Bytes) -> io::Result<Bytes> {
        match self {
            Self::Identity => Ok(bytes),
            Self::Gzip => {
                let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
                encoder.write_all(&bytes)?;
                Ok(encoder.finish()?.into())
            }
            Self::Zstd => Ok(zstd::bulk::compress(&bytes, ZSTD_LEVEL)?.into()),
            Self::Brotli => {
                let mut encoded = Vec::new();
                brotli::CompressorReader::new(&bytes[..], 4096, BROTLI.0, BROTLI.1).read_to_end(&mut encoded)?;
                Ok(encoded.into())
            }
        }
    }
}

/// Names of codings in lower case, and their weights.
fn weights(headers: &HeaderMap) -> Vec<(String, f32)> {
    let values = headers
        .get_all(header::ACCEPT_ENCODING)
        .into_iter()
        .filter_map(|value| value.to_str().ok());
    let weighted = |coding: &str| {
        let (name, parameter) = coding.split_once(';').unwrap_or((coding, ""));
        let weight = parameter
            .trim()
            .strip_prefix("q=")
            .and_then(|weight| weight.parse().ok());
        (name.trim().to_ascii_lowercase(), weight.unwrap_or(1.0))
    };
    values.flat_map(|value| value.split(',')).map(weighted).collect()
}
