//! Whole numbers of either sign, of which the order of magnitude is guessed beforehand.
//!
//! ```text
//! value = ± 1 b b r r r r        class      how many bits, against those of the guess: learned
//!           └─┴─┘ └─────┘        mantissa   the two bits after the leading one: learned; the rest as they are
//! ```

use super::range_coder::{Coder, Probability};

/// Classes of magnitude: from [`BELOW`] bits fewer than the guess has, to as many more; the outermost two are escapes.
const CLASSES: usize = 16;
/// Class of a number of as many bits as the guess.
const BELOW: i32 = 9;
/// Bits of the number of bits, after an escape.
const LENGTH_BITS: u32 = 6;
/// Bits of the longest number. No encoder writes one: a damaged guess must not ask for more than a word has.
const LONGEST: u32 = 63;
/// Guesses of fewer bits than this have statistics of their own; those of as many and more share theirs.
const SMALL_GUESSES: usize = 8;
/// Signs that a caller may tell apart.
pub(super) const SIGNS: usize = 9;

/// Statistics of one kind of number.
#[derive(Clone, Debug)]
pub(super) struct NumberModel {
    classes: [[Probability; CLASSES]; SMALL_GUESSES],
    mantissas: [[Probability; 4]; CLASSES],
    signs: [Probability; SIGNS],
}

impl Default for NumberModel {
    fn default() -> Self {
        Self {
            classes: [[Probability::default(); CLASSES]; SMALL_GUESSES],
            mantissas: [[Probability::default(); 4]; CLASSES],
            signs: [Probability::default(); SIGNS],
        }
    }
}

impl NumberModel {
    /// Codes a whole number that is expected to be as large as `guess`; `sign` tells kinds of expectations of its sign apart.
    #[inline]
    pub(super) fn code(&mut self, coder: &mut impl Coder, guess: f64, sign: usize, value: f64) -> f64 {
        let magnitude = coder.told(|| value.abs() as u64);
        let (length, class) = self.code_length(coder, guess, bit_length(magnitude));
        if length == 0 {
            return 0.0;
        }
        let magnitude = self.code_mantissa(coder, class, length, magnitude) as f64;
        if coder.bit(&mut self.signs[sign], value < 0.0) {
            -magnitude
        } else {
            magnitude
        }
    }

    #[inline]
    fn code_length(&mut self, coder: &mut impl Coder, guess: f64, length: u32) -> (u32, usize) {
        let expected = whole_bits(guess);
        let context = (expected as usize).min(SMALL_GUESSES - 1);
        let offset = expected as i32 - BELOW;
        let class = (length as i32 - offset).clamp(0, CLASSES as i32 - 1) as usize;
        let class = code_symbol(coder, &mut self.classes[context], class);
        if class == 0 || class == CLASSES - 1 {
            return (coder.even_bits(LENGTH_BITS, u64::from(length)) as u32, class);
        }
        (((class as i32 + offset).max(0) as u32).min(LONGEST), class)
    }

    #[inline]
    fn code_mantissa(&mut self, coder: &mut impl Coder, class: usize, length: u32, magnitude: u64) -> u64 {
        let mut read = 1;
        let learned = (length - 1).min(1);
        for place in 0..learned {
            let bit = magnitude >> (length - 2 - place) & 1 == 1;
            read = read << 1 | u64::from(coder.bit(&mut self.mantissas[class][read as usize], bit));
        }
        let rest = length - 1 - learned;
        read << rest | coder.even_bits(rest, magnitude)
    }
}

/// Codes one of as many symbols as there are probabilities, a power of two.
#[inline]
pub(super) fn code_symbol<const COUNT: usize>(
    coder: &mut impl Coder,
    probabilities: &mut [Probability; COUNT],
    symbol: usize,
) -> usize {
    let mut node = 1;
    let mut half = COUNT >> 1;
    while half > 0 {
        node = 2 * node + usize::from(coder.bit(&mut probabilities[node], symbol & half != 0));
        half >>= 1;
    }
    node - COUNT
}

/// How many bits a number has; 0 has none.
fn bit_length(number: u64) -> u32 {
    u64::BITS - number.leading_zeros()
}

/// How many bits the whole part of a number has that is not below 0: its exponent tells.
fn whole_bits(number: f64) -> u32 {
    ((number.to_bits() >> 52) as u32).saturating_sub(1022)
}
