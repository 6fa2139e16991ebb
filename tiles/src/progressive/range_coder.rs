//! An adaptive binary range coder, after G. Martin, *Range encoding*, 1979, in the form that LZMA made common: 32 bits of
//! range, a probability of 16 bits for each context, a byte out whenever the range falls below 2^24.
//!
//! ```text
//! low                    low + bound                       low + range
//!  ├──────── 1 ─────────────┼────────────── 0 ──────────────────┤        bound = (range / 2^16) · probability of a 1
//! ```
//! It differs in two things: a probability moves in large steps at first, so that short streams learn fast, and the end is as
//! short as it can be, for bytes after the last are read as 0.

/// Below this the range is widened by a byte.
const LEAST_RANGE: u32 = 1 << 24;
/// Even bits that fit into the range at once.
const EVEN_BITS: u32 = 16;
/// Bytes that the decoder is ahead of what it needs.
const AHEAD: usize = 4;
/// By which power of two an answer moves a probability: the first, the second … the last for good.
const RATES: [u8; 24] = [1, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 6];

/// How likely a bit is 1, learned from those before it in the same context.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probability {
    /// In 65,536ths.
    one: u16,
    /// Answers so far, up to the last of [`RATES`].
    answers: u8,
}

impl Default for Probability {
    fn default() -> Self {
        Self {
            one: 1 << 15,
            answers: 0,
        }
    }
}

impl Probability {
    #[inline]
    fn learn(&mut self, bit: bool) {
        let rate = RATES[usize::from(self.answers)];
        let (more, less) = ((u16::MAX - self.one) >> rate, self.one >> rate);
        self.one = if bit { self.one + more } else { self.one - less };
        self.answers += u8::from(usize::from(self.answers) + 1 < RATES.len());
    }

    #[inline]
    fn bound(self, range: u32) -> u32 {
        (range >> 16) * u32::from(self.one.max(1))
    }
}

/// What writes bits or reads them, so that a model is written once for both: a writer is given each value and gives it back, a
/// reader ignores what it is given.
pub(super) trait Coder {
    /// A bit whose probability is learned.
    fn bit(&mut self, probability: &mut Probability, bit: bool) -> bool;

    /// A number of at most [`EVEN_BITS`] bits, each as often 1 as not.
    fn few_even_bits(&mut self, count: u32, value: u32) -> u32;

    /// Whether more was read than there is.
    fn is_exhausted(&self) -> bool {
        false
    }

    /// The lowest `count` bits of a number, the highest of them first, each as often 1 as not.
    #[inline]
    fn even_bits(&mut self, mut count: u32, value: u64) -> u64 {
        let mut read = 0;
        while count > EVEN_BITS {
            count -= EVEN_BITS;
            let part = value >> count & ((1 << EVEN_BITS) - 1);
            read = read << EVEN_BITS | u64::from(self.few_even_bits(EVEN_BITS, part as u32));
        }
        let part = value & ((1 << count) - 1);
        read << count | u64::from(self.few_even_bits(count, part as u32))
    }
}

/// Writes bits.
#[derive(Debug)]
pub(super) struct Encoder {
    bytes: Vec<u8>,
    low: u64,
    range: u32,
}

impl Encoder {
    pub(super) fn new() -> Self {
        Self {
            bytes: Vec::new(),
            low: 0,
            range: u32::MAX,
        }
    }

    /// All bytes, the last ones the roundest number in what is left of the range.
    pub(super) fn finish(mut self) -> Vec<u8> {
        let last = self.low + u64::from(self.range) - 1;
        let zeros = (0..=32)
            .rev()
            .find(|&zeros| last >> zeros << zeros >= self.low)
            .unwrap_or(0);
        self.low = last >> zeros << zeros;
        for _ in 0..AHEAD {
            self.shift();
        }
        let end = self.bytes.len();
        let zeros = self
            .bytes
            .iter()
            .rev()
            .take(AHEAD)
            .take_while(|&&byte| byte == 0)
            .count();
        self.bytes.truncate(end - zeros);
        self.bytes
    }

    fn narrow(&mut self) {
        while self.range < LEAST_RANGE {
            self.range <<= 8;
            self.shift();
        }
    }

    /// Moves the highest of the 32 bits of `low` out, and what it carries into the bytes before.
    fn shift(&mut self) {
        if self.low >> 32 != 0 {
            for byte in self.bytes.iter_mut().rev() {
                *byte = byte.wrapping_add(1);
                if *byte != 0 {
                    break;
                }
            }
        }
        self.bytes.push((self.low >> 24) as u8);
        self.low = (self.low & 0x00ff_ffff) << 8;
    }
}

impl Coder for Encoder {
    fn bit(&mut self, probability: &mut Probability, bit: bool) -> bool {
        let bound = probability.bound(self.range);
        if bit {
            self.range = bound;
        } else {
            self.low += u64::from(bound);
            self.range -= bound;
        }
        probability.learn(bit);
        self.narrow();
        bit
    }

    fn few_even_bits(&mut self, count: u32, value: u32) -> u32 {
        self.range >>= count;
        self.low += u64::from(self.range) * u64::from(value);
        self.narrow();
        value
    }
}

/// Reads bits.
#[derive(Debug)]
pub(super) struct Decoder<'a> {
    bytes: &'a [u8],
    next: usize,
    code: u32,
    range: u32,
}

impl<'a> Decoder<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let mut decoder = Self {
            bytes,
            next: 0,
            code: 0,
            range: u32::MAX,
        };
        for _ in 0..AHEAD {
            decoder.shift();
        }
        decoder
    }

    #[inline]
    fn shift(&mut self) {
        self.code = self.code << 8 | u32::from(self.bytes.get(self.next).copied().unwrap_or(0));
        self.next += 1;
    }

    #[inline]
    fn narrow(&mut self) {
        while self.range < LEAST_RANGE {
            self.range <<= 8;
            self.shift();
        }
    }
}

impl Coder for Decoder<'_> {
    fn is_exhausted(&self) -> bool {
        self.next > self.bytes.len() + AHEAD
    }

    #[inline]
    fn bit(&mut self, probability: &mut Probability, _: bool) -> bool {
        let bound = probability.bound(self.range);
        let bit = self.code < bound;
        (self.code, self.range) = if bit {
            (self.code, bound)
        } else {
            (self.code - bound, self.range - bound)
        };
        probability.learn(bit);
        self.narrow();
        bit
    }

    #[inline]
    fn few_even_bits(&mut self, count: u32, _: u32) -> u32 {
        self.range >>= count;
        let value = (self.code / self.range).min((1 << count) - 1);
        self.code -= value * self.range;
        self.narrow();
        value
    }
}

#[cfg(test)]
#[path = "range_coder_tests.rs"]
mod tests;
