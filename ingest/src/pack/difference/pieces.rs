//! What a file has that an older one has not: both are cut where their content says (W. Xia and others, *FastCDC*, 2020), so that
//! what is the same in both is the same pieces, wherever it stands.
//!
//! ```text
//! old file ─▶ hashes of its pieces      new file ─▶ its pieces in order; those that are not in the old one     write
//! old file ─▶ pieces by their hashes,   pieces that are new ─▶ new file, hashed again                          join
//! ```

use std::collections::{HashMap, HashSet};
use std::fs::{self, File};
use std::io::{BufRead, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;

use anyhow::Context;
use fastcdc::v2020::StreamCDC;
use sha2::{Digest, Sha256};

use super::super::folder::Sum;
use super::super::unusable::Unusable;

/// Bytes of a piece: at least, mostly, at most. Tiles are larger than most pieces, so that one that stays is mostly found.
const BYTES: [usize; 3] = [1 << 10, 1 << 12, 1 << 16];
/// Pieces of the new file in order, a line each: hash and bytes.
const ORDER: &str = "pieces.txt";
/// Pieces that are new, one after the other.
const PIECES: &str = "pieces";

/// A piece by what is in it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Piece {
    /// In hexadecimal digits.
    sha256: String,
    bytes: usize,
}

/// Writes what `new` has that `old` has not into the folder `output`. Gives how many pieces of the new file are in the old one, and how
/// many of the old one are not in the new one.
pub(super) fn write(old: &Path, new: &Path, output: &Path) -> anyhow::Result<[usize; 2]> {
    let mut known = HashSet::new();
    each(old, |piece, _, _| {
        known.insert(piece);
        Ok(())
    })?;
    let mut order = BufWriter::new(File::create_new(output.join(ORDER))?);
    let mut pieces = BufWriter::new(File::create_new(output.join(PIECES))?);
    let (mut kept, mut used, mut written) = (0, HashSet::new(), HashSet::new());
    each(new, |piece, _, data| {
        writeln!(order, "{} {}", piece.sha256, piece.bytes)?;
        if known.contains(&piece) {
            kept += 1;
            used.insert(piece);
        } else if written.insert(piece) {
            pieces.write_all(data)?;
        }
        Ok(())
    })?;
    order.flush()?;
    pieces.flush()?;
    Ok([kept, known.len() - used.len()])
}

/// Writes the new file as `output` from the `old` one and what [`write`] left in `difference`.
pub(super) fn join(old: &Path, difference: &Path, output: &Path) -> anyhow::Result<()> {
    let mut places = HashMap::new();
    each(old, |piece, offset, _| {
        places.entry(piece).or_insert(offset);
        Ok(())
    })?;
    let mut old = File::open(old)?;
    let mut pieces = BufReader::new(open(&difference.join(PIECES))?);
    let order = BufReader::new(open(&difference.join(ORDER))?);
    let mut whole = BufWriter::new(File::create_new(output)?);
    let mut added: HashMap<Piece, Vec<u8>> = HashMap::new();
    for line in order.lines() {
        let piece = parse(&line?)?;
        let mut data = vec![0; piece.bytes];
        if let Some(&offset) = places.get(&piece) {
            old.seek(SeekFrom::Start(offset))?;
            old.read_exact(&mut data)?;
        } else if let Some(known) = added.get(&piece) {
            data.clone_from(known);
        } else {
            let missing = |_| Unusable("the difference is not one from this older pack".to_owned());
            pieces.read_exact(&mut data).map_err(missing)?;
            added.insert(piece, data.clone());
        }
        whole.write_all(&data)?;
    }
    Ok(whole.flush()?)
}

/// Of a whole file.
pub(super) fn sum(path: &Path) -> anyhow::Result<Sum> {
    let mut hash = Sha256::new();
    let mut file = BufReader::new(File::open(path)?);
    loop {
        let data = file.fill_buf()?;
        if data.is_empty() {
            break;
        }
        hash.update(data);
        let length = data.len();
        file.consume(length);
    }
    Ok(Sum {
        bytes: fs::metadata(path)?.len(),
        sha256: hexadecimal(&hash.finalize()),
    })
}

/// Calls `take` with each piece of a file, where it is and what is in it.
fn each(path: &Path, mut take: impl FnMut(Piece, u64, &[u8]) -> anyhow::Result<()>) -> anyhow::Result<()> {
    let file = File::open(path).with_context(|| path.display().to_string())?;
    let [least, usual, most] = BYTES;
    for chunk in StreamCDC::new(BufReader::new(file), least, usual, most) {
        let chunk = chunk.map_err(|error| anyhow::anyhow!("{}: {error}", path.display()))?;
        let piece = Piece {
            sha256: hexadecimal(&Sha256::digest(&chunk.data)),
            bytes: chunk.length,
        };
        take(piece, chunk.offset, &chunk.data)?;
    }
    Ok(())
}

fn open(path: &Path) -> Result<File, Unusable> {
    File::open(path).map_err(|error| Unusable(format!("{}: {error}", path.display())))
}

fn parse(line: &str) -> Result<Piece, Unusable> {
    let of_line = || {
        let (sha256, bytes) = line.split_once(' ')?;
        let bytes = bytes.parse().ok().filter(|bytes| *bytes <= BYTES[2])?;
        Some(Piece {
            sha256: sha256.to_owned(),
            bytes,
        })
    };
    of_line().ok_or_else(|| Unusable(format!("{ORDER}: `{line}` is no piece")))
}

fn hexadecimal(hash: &[u8]) -> String {
    hash.iter().map(|byte| format!("{byte:02x}")).collect()
}
