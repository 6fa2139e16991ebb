//! Cutting the multilevel file's text, which may arrive in pieces of any size, into braces and words.
//!
//! Written by hand because the parsing crates want the whole text, or keep all that a failed attempt has read, and count
//! lines and columns from the start of a piece; here, a word of limited length is all that is kept between two pieces.

use std::fmt;

/// Longest word there may be; a number has no use for more.
const LONGEST_WORD: usize = 64;

/// A place in a text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Line, from 1.
    pub line: u32,
    /// Byte of the line, from 1.
    pub column: u32,
}

impl fmt::Display for Place {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "line {}, column {}", self.line, self.column)
    }
}

impl Place {
    const START: Self = Self { line: 1, column: 1 };

    fn after(self, byte: u8) -> Self {
        match byte {
            b'\n' => Self {
                line: self.line.saturating_add(1),
                column: 1,
            },
            _ => Self {
                column: self.column.saturating_add(1),
                ..self
            },
        }
    }
}

/// What the text is made of; commas and white space only separate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Token<'a> {
    Open,
    Close,
    Word(&'a str),
}

/// Between two pieces of the text.
#[derive(Clone, Debug)]
pub(super) struct Tokenizer {
    place: Place,
    in_comment: bool,
    word: String,
    word_place: Place,
}

/// A word too long to be a number, and where it starts.
#[derive(Debug, PartialEq)]
pub(super) struct WordTooLong(pub(super) Place);

impl Tokenizer {
    pub(super) fn new() -> Self {
        Self {
            place: Place::START,
            in_comment: false,
            word: String::new(),
            word_place: Place::START,
        }
    }

    /// Where the text read so far ends.
    pub(super) fn place(&self) -> Place {
        self.place
    }

    /// Hands the tokens of the next piece to `sink`, each with its place, up to the first error. A word at the piece's end
    /// waits for what comes next.
    pub(super) fn push<E: From<WordTooLong>>(
        &mut self,
        piece: &[u8],
        mut sink: impl FnMut(Token<'_>, Place) -> Result<(), E>,
    ) -> Result<(), E> {
        for &byte in piece {
            self.take(byte, &mut sink)?;
            self.place = self.place.after(byte);
        }
        Ok(())
    }

    /// Hands over the word that the text ends with, if it does.
    pub(super) fn finish<E>(&mut self, mut sink: impl FnMut(Token<'_>, Place) -> Result<(), E>) -> Result<(), E> {
        self.end_word(&mut sink)
    }

    fn take<E: From<WordTooLong>>(
        &mut self,
        byte: u8,
        sink: &mut impl FnMut(Token<'_>, Place) -> Result<(), E>,
    ) -> Result<(), E> {
        if self.in_comment {
            self.in_comment = byte != b'\n';
            return Ok(());
        }
        if !is_separator(byte) {
            return Ok(self.extend_word(byte)?);
        }
        self.end_word(sink)?;
        match byte {
            b'#' => self.in_comment = true,
            b'{' => sink(Token::Open, self.place)?,
            b'}' => sink(Token::Close, self.place)?,
            _ => {}
        }
        Ok(())
    }

    fn extend_word(&mut self, byte: u8) -> Result<(), WordTooLong> {
        if self.word.is_empty() {
            self.word_place = self.place;
        }
        self.word.push(char::from(byte));
        match self.word.len() <= LONGEST_WORD {
            true => Ok(()),
            false => Err(WordTooLong(self.word_place)),
        }
    }

    fn end_word<E>(&mut self, sink: &mut impl FnMut(Token<'_>, Place) -> Result<(), E>) -> Result<(), E> {
        if self.word.is_empty() {
            return Ok(());
        }
        let result = sink(Token::Word(&self.word), self.word_place);
        self.word.clear();
        result
    }
}

fn is_separator(byte: u8) -> bool {
    byte.is_ascii_whitespace() || matches!(byte, b',' | b'#' | b'{' | b'}')
}
