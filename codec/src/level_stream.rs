//! The levels that follow a directory, decoded while their bytes come in, each as soon as it is whole.

use terrain_core::SurfacePartition;
use terrain_core::levels::partition::Level;

use crate::DecodeError;
use crate::fields::{Entry, Fields};
use crate::progressive::{LevelsDecoder, Run};

/// The levels of a file, as far as they are there.
#[derive(Debug)]
pub(crate) struct LevelStream {
    entries: Vec<Entry>,
    levels: LevelsDecoder,
    /// Bytes of the file up to the end of the last level that is whole.
    decoded: usize,
    /// Those that came after.
    waiting: Vec<u8>,
    whole: usize,
}

impl LevelStream {
    /// Begins with the first bytes of a file, of which those after the directory are left in `rest`.
    pub(crate) fn new(
        entries: Vec<Entry>,
        levels: LevelsDecoder,
        first: &[u8],
        rest: &Fields,
    ) -> Result<Self, DecodeError> {
        let start = first.len() - rest.remaining();
        let mut stream = Self {
            entries,
            levels,
            decoded: start,
            waiting: Vec::new(),
            whole: 0,
        };
        stream.add(&first[start..])?;
        Ok(stream)
    }

    /// Goes on with the bytes that come next.
    pub(crate) fn add(&mut self, bytes: &[u8]) -> Result<(), DecodeError> {
        self.waiting.extend(bytes);
        let mut end = 0;
        while let Some(entry) = self.entries.get(self.whole)
            && let Some(bytes) = self.waiting[end..].get(..entry.length)
        {
            let (is_cut, level) = (false, entry.level);
            self.levels.add(&Run { bytes, is_cut, level })?;
            end += entry.length;
            self.whole += 1;
        }
        self.waiting.drain(..end);
        self.decoded += end;
        if self.is_whole() && !self.waiting.is_empty() {
            return Err(DecodeError::OutOfRange("the number of bytes after the last level"));
        }
        Ok(())
    }

    /// Decodes what is there of the level that is not whole: nothing more comes.
    pub(crate) fn cut(&mut self) -> Result<(), DecodeError> {
        let (is_base, is_begun) = (self.whole == 0, !self.waiting.is_empty());
        if let Some(entry) = self.entries.get(self.whole)
            && (is_base || is_begun)
        {
            let (bytes, is_cut, level) = (self.waiting.as_slice(), true, entry.level);
            self.levels.add(&Run { bytes, is_cut, level })?;
        }
        Ok(())
    }

    /// The levels as the directory tells them, also those that are not there yet.
    pub(crate) fn levels(&self) -> impl Iterator<Item = Level> {
        self.entries.iter().map(|entry| entry.level)
    }

    /// What the directory tells of those that are whole.
    pub(crate) fn whole(&self) -> &[Entry] {
        &self.entries[..self.whole]
    }

    /// Bytes of the file up to the end of each level.
    pub(crate) fn ends(&self) -> impl Iterator<Item = usize> {
        let whole: usize = self.whole().iter().map(|entry| entry.length).sum();
        let start = self.decoded - whole;
        self.entries.iter().scan(start, |end, entry| {
            *end += entry.length;
            Some(*end)
        })
    }

    /// How many bytes of the file have come.
    pub(crate) fn bytes_there(&self) -> usize {
        self.decoded + self.waiting.len()
    }

    /// Whether all levels are there.
    pub(crate) fn is_whole(&self) -> bool {
        self.whole == self.entries.len()
    }

    /// An error unless all levels are there.
    pub(crate) fn check_whole(&self) -> Result<(), DecodeError> {
        if self.is_whole() {
            Ok(())
        } else {
            Err(DecodeError::Truncated(self.bytes_there()))
        }
    }

    /// What has been decoded so far.
    pub(crate) fn partition(&self) -> Result<SurfacePartition, DecodeError> {
        Ok(self.levels.partition()?)
    }

    /// The same, if nothing more comes.
    pub(crate) fn into_partition(self) -> Result<SurfacePartition, DecodeError> {
        Ok(self.levels.into_partition()?)
    }
}
