//! Reader and writer of the paper's ASCII file of a multilevel mesh (its Figures 6 and 13).
//!
//! ```text
//! file  ::= level+                                   coarsest level first
//! level ::= '{' coordinate* '}' '{' triangle* '}'    DIMENSION coordinates a vertex
//! triangle ::= index index index representative*
//! ```
//!
//! Commas count as white space, `#` begins a comment that ends with the line. After a triangle stands, corner by corner, the
//! representative of each vertex that is missing so far and has not been given one before; if the representative is
//! missing in the same way, its own follows at once.

use std::collections::HashSet;

use thiserror::Error;

use super::needed::NeededLinks;
use super::tokens::{Place, Token, Tokenizer, WordTooLong};
use super::{LevelBatch, LevelFault, MultilevelLimits, MultilevelMesh, check_before, check_distinct};

/// What is wrong with a text.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ReadFault {
    /// Not what the format wants here.
    #[error("expected {expected}, found {found}")]
    Unexpected {
        /// What may stand here.
        expected: &'static str,
        /// What does.
        found: String,
    },
    /// A word of more bytes than any number needs.
    #[error("a word that is too long to be a number")]
    WordTooLong,
    /// The numbers can be read, but are no level of a mesh.
    #[error(transparent)]
    Level(#[from] LevelFault),
}

/// Why a text is refused, and where.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{place}: {fault}")]
pub struct ReadError {
    /// Where the fault is.
    pub place: Place,
    /// What it is.
    pub fault: ReadFault,
}

impl From<WordTooLong> for ReadError {
    fn from(WordTooLong(place): WordTooLong) -> Self {
        let fault = ReadFault::WordTooLong;
        Self { place, fault }
    }
}

/// What the reader is in the middle of.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Section {
    BeforeVertices,
    Vertices,
    BeforeTriangles,
    Triangles,
}

/// Reads a multilevel mesh from text that arrives in pieces of any size; every level can be drawn as soon as its last
/// brace has been read.
#[derive(Clone, Debug)]
pub struct AsciiReader<const DIMENSION: usize = 3> {
    tokenizer: Tokenizer,
    level: LevelReader<DIMENSION>,
}

/// The level under way and the mesh it will be part of.
#[derive(Clone, Debug)]
struct LevelReader<const DIMENSION: usize> {
    mesh: MultilevelMesh<DIMENSION>,
    section: Section,
    batch: LevelBatch<DIMENSION>,
    /// Coordinates of the vertex under way.
    coordinates: Vec<f64>,
    /// Corners of the triangle under way.
    corners: Vec<u32>,
    /// Missing vertices whose representatives have to follow, the next one last.
    unrepresented: Vec<u32>,
    /// Vertices that the batch has given a representative.
    given: HashSet<u32>,
    /// The largest index that a triangle has used, and where it first stood.
    largest_used: Option<(u32, Place)>,
}

impl<const DIMENSION: usize> AsciiReader<DIMENSION> {
    /// A reader at the start of a text.
    #[must_use]
    pub fn new(limits: MultilevelLimits) -> Self {
        Self {
            tokenizer: Tokenizer::new(),
            level: LevelReader::new(limits),
        }
    }

    /// Reads the next piece of the text.
    ///
    /// # Errors
    /// The first fault, with its place in the whole text; nothing more can be read then, but the levels before it stay.
    pub fn push(&mut self, piece: &[u8]) -> Result<(), ReadError> {
        let level = &mut self.level;
        self.tokenizer.push(piece, |token, place| level.take(token, place))
    }

    /// What has been read so far: whole levels.
    #[must_use]
    pub fn mesh(&self) -> &MultilevelMesh<DIMENSION> {
        &self.level.mesh
    }

    /// The mesh, at the end of the text.
    ///
    /// # Errors
    /// When the text has no level, ends inside one or uses a vertex that it never gave.
    pub fn finish(mut self) -> Result<MultilevelMesh<DIMENSION>, ReadError> {
        let level = &mut self.level;
        self.tokenizer.finish(|token, place| level.take(token, place))?;
        self.level.finish(self.tokenizer.place())
    }
}

impl<const DIMENSION: usize> MultilevelMesh<DIMENSION> {
    /// Reads a whole text at once.
    ///
    /// # Errors
    /// The first fault, with its line and column.
    pub fn from_ascii(text: &str, limits: MultilevelLimits) -> Result<Self, ReadError> {
        let mut reader = AsciiReader::new(limits);
        reader.push(text.as_bytes())?;
        reader.finish()
    }
}

impl<const DIMENSION: usize> LevelReader<DIMENSION> {
    fn new(limits: MultilevelLimits) -> Self {
        Self {
            mesh: MultilevelMesh::new(limits),
            section: Section::BeforeVertices,
            batch: LevelBatch::default(),
            coordinates: Vec::with_capacity(DIMENSION),
            corners: Vec::with_capacity(3),
            unrepresented: Vec::new(),
            given: HashSet::new(),
            largest_used: None,
        }
    }

    fn take(&mut self, token: Token<'_>, place: Place) -> Result<(), ReadError> {
        match (self.section, token) {
            (Section::BeforeVertices, Token::Open) => self.section = Section::Vertices,
            (Section::BeforeTriangles, Token::Open) => self.section = Section::Triangles,
            (Section::Vertices, Token::Word(word)) => self.take_coordinate(word, place)?,
            (Section::Triangles, Token::Word(word)) => self.take_index(word, place)?,
            (Section::Vertices, Token::Close) if self.coordinates.is_empty() => {
                self.section = Section::BeforeTriangles;
            }
            (Section::Triangles, Token::Close) if self.corners.is_empty() && self.unrepresented.is_empty() => {
                self.end_level(place)?;
            }
            _ => return Err(self.unexpected(&describe(token), place)),
        }
        Ok(())
    }

    fn take_coordinate(&mut self, word: &str, place: Place) -> Result<(), ReadError> {
        let coordinate: f64 = word.parse().map_err(|_| self.unexpected(word, place))?;
        if !coordinate.is_finite() {
            return Err(at(place)(LevelFault::NotFinite));
        }
        self.coordinates.push(coordinate);
        if let Ok(position) = <[f64; DIMENSION]>::try_from(self.coordinates.as_slice()) {
            self.coordinates.clear();
            self.batch.positions.push(position);
            self.check_room().map_err(at(place))?;
        }
        Ok(())
    }

    fn take_index(&mut self, word: &str, place: Place) -> Result<(), ReadError> {
        let index: u32 = word.parse().map_err(|_| self.unexpected(word, place))?;
        match self.unrepresented.pop() {
            Some(vertex) => self.take_representative(vertex, index).map_err(at(place)),
            None => self.take_corner(index, place).map_err(at(place)),
        }
    }

    fn take_representative(&mut self, vertex: u32, representative: u32) -> Result<(), LevelFault> {
        check_before(representative, vertex)?;
        self.batch.representatives.push((vertex, representative));
        self.given.insert(vertex);
        self.unrepresented.retain(|&other| other != vertex);
        if self.is_unrepresented(representative) {
            self.unrepresented.push(representative);
        }
        Ok(())
    }

    fn take_corner(&mut self, corner: u32, place: Place) -> Result<(), LevelFault> {
        self.mesh.check_index(corner)?;
        if self.largest_used.is_none_or(|(largest, _)| corner > largest) {
            self.largest_used = Some((corner, place));
        }
        self.corners.push(corner);
        let Ok(triangle) = <[u32; 3]>::try_from(self.corners.as_slice()) else {
            return Ok(());
        };
        self.corners.clear();
        check_distinct(triangle)?;
        self.batch.triangles.push(triangle);
        let missing = triangle
            .into_iter()
            .rev()
            .filter(|&corner| self.is_unrepresented(corner));
        self.unrepresented = missing.collect();
        self.check_room()
    }

    fn check_room(&self) -> Result<(), LevelFault> {
        self.mesh
            .check_room(self.batch.positions.len(), self.batch.triangles.len())
    }

    fn is_unrepresented(&self, vertex: u32) -> bool {
        let present = self.mesh.positions.len() + self.batch.positions.len();
        vertex as usize >= present && !self.given.contains(&vertex) && self.mesh.representative(vertex).is_none()
    }

    fn end_level(&mut self, place: Place) -> Result<(), ReadError> {
        self.section = Section::BeforeVertices;
        self.given.clear();
        let batch = std::mem::take(&mut self.batch);
        self.mesh.add_level(batch).map_err(|error| at(place)(error.fault))
    }

    fn finish(self, end: Place) -> Result<MultilevelMesh<DIMENSION>, ReadError> {
        if self.section != Section::BeforeVertices || self.mesh.level_count() == 0 {
            return Err(self.unexpected("the end of the text", end));
        }
        let largest = self.largest_used.map_or(end, |(_, place)| place);
        self.mesh.check_complete().map_err(at(largest))?;
        Ok(self.mesh)
    }

    fn unexpected(&self, found: &str, place: Place) -> ReadError {
        let expected = match self.section {
            Section::BeforeVertices => "'{' and the vertices of a level",
            Section::Vertices if self.coordinates.is_empty() => "a vertex's first coordinate or '}'",
            Section::Vertices => "a vertex's next coordinate",
            Section::BeforeTriangles => "'{' and the triangles of the level",
            Section::Triangles if !self.unrepresented.is_empty() => "the representative of a vertex that is missing",
            Section::Triangles if self.corners.is_empty() => "a triangle's first corner or '}'",
            Section::Triangles => "a triangle's next corner",
        };
        let found = found.to_owned();
        ReadError {
            place,
            fault: ReadFault::Unexpected { expected, found },
        }
    }
}

fn at(place: Place) -> impl Fn(LevelFault) -> ReadError {
    move |fault| ReadError {
        place,
        fault: fault.into(),
    }
}

fn describe(token: Token<'_>) -> String {
    match token {
        Token::Open => "'{'".to_owned(),
        Token::Close => "'}'".to_owned(),
        Token::Word(word) => word.to_owned(),
    }
}

/// The mesh as text, with the representatives that its levels need and no others. Numbers are written so that reading gives
/// the same ones back.
#[must_use]
pub fn to_ascii<const DIMENSION: usize>(mesh: &MultilevelMesh<DIMENSION>) -> String {
    let mut text = format!("#{}-level progressive mesh\n", mesh.level_count());
    let mut links = NeededLinks::new(mesh);
    for level in (0..mesh.level_count()).rev() {
        let (vertices, triangles) = mesh.level_range(level);
        let rows = mesh.positions[vertices].iter().map(|position| row(position.iter()));
        push_batch(&mut text, &format!("level {level} vertices"), rows);
        let rows = triangles.map(|triangle| {
            let mut numbers = mesh.triangles[triangle].to_vec();
            links.visit(level, triangle, |_, representative| numbers.push(representative));
            row(numbers.iter())
        });
        push_batch(&mut text, &format!("level {level} triangles"), rows);
    }
    text
}

fn push_batch(text: &mut String, title: &str, rows: impl Iterator<Item = String>) {
    let rows: Vec<String> = rows.collect();
    let count = rows.len();
    let rows = rows.join(",\n");
    text.push_str(&format!("{{#{title} ({count})\n{rows}}}\n"));
}

fn row<T: std::fmt::Debug>(numbers: impl Iterator<Item = T>) -> String {
    let numbers: Vec<String> = numbers.map(|number| format!("{number:?}")).collect();
    numbers.join(", ")
}

#[cfg(test)]
#[path = "ascii_tests.rs"]
mod tests;
