//! What a file has that an older one has not: both are cut where their content says (W. Xia and others, *FastCDC*, 2020), so that
//! what is the same in both is the same pieces, wherever it stands.
//!
//! ```text
//! old file ─▶ hashes of its pieces      new file ─▶ its pieces in order; those that are not in the old one     write
//! old file ─▶ pieces by their hashes,   pieces that are new ─▶ new file, hashed again                          join
//! ```

use std::collections::{HashMap, HashSet};
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;

use anyhow::Context;
use fastcdc::v2020::StreamCDC;

use super::super::folder::Sum;
use super::super::unusable::Unusable;

/// Bytes of a piece: at least, mostly, at most. Tiles are larger than most pieces, so that one that stays is mostly found.
const BYTES: [usize; 3] = [1 << 10, 1 << 12, 1 << 16];
/// Pieces of the new file in order, a line each: hash and bytes.
const ORDER: &str = "pieces.txt";
/// Pieces that are new, one after the other.
const PIECES: &str = "pieces";

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
    let mut added: HashMap<Sum, Vec<u8>> = HashMap::new();
    for line in order.lines() {
        let piece = parse(&line?)?;
        let mut data = vec![0; piece.bytes as usize];
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

/// Calls `take` with each piece of a file, where it is and what is in it.
fn each(path: &Path, mut take: impl FnMut(Sum, u64, &[u8]) -> anyhow::Result<()>) -> anyhow::Result<()> {
    let file = File::open(path).with_context(|| path.display().to_string())?;
    let [least, usual, most] = BYTES;
    for chunk in StreamCDC::new(BufReader::new(file), least, usual, most) {
        let chunk = chunk.map_err(|error| anyhow::anyhow!("{}: {error}", path.display()))?;
        take(Sum::of(&chunk.data), chunk.offset, &chunk.data)?;
    }
    Ok(())
}

fn open(path: &Path) -> Result<File, Unusable> {
    File::open(path).map_err(|error| Unusable(format!("{}: {error}", path.display())))
}

fn parse(line: &str) -> Result<Sum, Unusable> {
    let of_line = || {
        let (sha256, bytes) = line.split_once(' ')?;
        let bytes = bytes.parse().ok().filter(|bytes| *bytes <= BYTES[2] as u64)?;
        Some(Sum {
            sha256: sha256.to_owned(),
            bytes,
        })
    };
    of_line().ok_or_else(|| Unusable(format!("{ORDER}: `{line}` is no piece")))
}
