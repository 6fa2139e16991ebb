//! An adaptive binary range coder, after G. Martin, *Range encoding*, 1979, in the form that LZMA made common: a probability of
//! 16 bits for each context, two bytes out whenever the range of 48 bits falls below 2^32. Products of the two stay below 2^53,
//! so that a decoder can keep all of them in doubles.
//!
//! ```text
//! low                    low + bound                       low + range
//!  ├──────── 1 ─────────────┼────────────── 0 ──────────────────┤        bound = (range / 2^16) · probability of a 1
//! ```
//! It differs in two things: a probability moves in large steps at first, so that short streams learn fast, and the end is as
//! short as it can be, for bytes after the last are read as 0.

/// Below this the range is widened by two bytes.
const LEAST_RANGE: u64 = 1 << 32;
/// The range at first.
const WHOLE_RANGE: u64 = (1 << 48) - 1;
/// Bits that go in or out together; also the even bits that fit into the range at once.
const WORD_BITS: u32 = 16;
/// Words that the decoder is ahead of what it needs.
const AHEAD: usize = 3;
/// By which power of two an answer moves a probability: the first, the second … the last for good.
const RATES: [u8; 32] = [
    1, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 6,
];
/// No probability comes nearer to 0 or 1 than so many 65,536ths.
const LEAST: i32 = 32;

/// How likely a bit is 1, learned from those before it in the same context.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probability {
    /// In 65,536ths.
    one: u16,
    /// Answers so far, up to the last of [`RATES`].
    answers: u16,
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
        let target = LEAST + (-i32::from(bit) & ((1 << 16) - 2 * LEAST));
        let one = i32::from(self.one);
        self.one = (one + ((target - one) >> RATES[usize::from(self.answers) % RATES.len()])) as u16;
        self.answers += u16::from(usize::from(self.answers) + 1 < RATES.len());
    }

    #[inline]
    fn bound(self, range: u64) -> u64 {
        (range >> WORD_BITS) * u64::from(self.one)
    }
}

/// What writes bits or reads them, so that a model is written once for both: a writer is given each value and gives it back, a
/// reader ignores what it is given.
pub(super) trait Coder {
    /// A bit whose probability is learned.
    fn bit(&mut self, probability: &mut Probability, bit: bool) -> bool;

    /// A number of at most [`WORD_BITS`] bits, each as often 1 as not.
    fn few_even_bits(&mut self, count: u32, value: u32) -> u32;

    /// What a writer is to write; a reader need not work it out.
    fn told<T: Default>(&self, value: impl FnOnce() -> T) -> T;

    /// Whether more was read than there is.
    fn is_exhausted(&self) -> bool {
        false
    }

    /// The lowest `count` bits of a number, the highest of them first, each as often 1 as not.
    #[inline]
    fn even_bits(&mut self, mut count: u32, value: u64) -> u64 {
        let mut read = 0;
        while count > WORD_BITS {
            count -= WORD_BITS;
            let part = value >> count & ((1 << WORD_BITS) - 1);
            read = read << WORD_BITS | u64::from(self.few_even_bits(WORD_BITS, part as u32));
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
    range: u64,
}

impl Encoder {
    pub(super) fn new() -> Self {
        Self {
            bytes: Vec::new(),
            low: 0,
            range: WHOLE_RANGE,
        }
    }

    /// All bytes, the last ones the roundest number in what is left of the range.
    pub(super) fn finish(mut self) -> Vec<u8> {
        let last = self.low + self.range - 1;
        let zeros = (0..=48)
            .rev()
            .find(|&zeros| last >> zeros << zeros >= self.low)
            .unwrap_or(0);
        self.low = last >> zeros << zeros;
        for _ in 0..AHEAD {
            self.shift();
        }
        let is_zero = |&&byte: &&u8| byte == 0;
        let zeros = self.bytes.iter().rev().take(2 * AHEAD).take_while(is_zero).count();
        self.bytes.truncate(self.bytes.len() - zeros);
        self.bytes
    }

    fn narrow(&mut self) {
        while self.range < LEAST_RANGE {
            self.range <<= WORD_BITS;
            self.shift();
        }
    }

    /// Moves the highest of the 48 bits of `low` out, and what it carries into the bytes before.
    fn shift(&mut self) {
        if self.low > WHOLE_RANGE {
            for byte in self.bytes.iter_mut().rev() {
                *byte = byte.wrapping_add(1);
                if *byte != 0 {
                    break;
                }
            }
        }
        self.bytes.extend(((self.low >> 32) as u16).to_be_bytes());
        self.low = (self.low & (LEAST_RANGE - 1)) << WORD_BITS;
    }
}

impl Coder for Encoder {
    fn told<T: Default>(&self, value: impl FnOnce() -> T) -> T {
        value()
    }

    fn bit(&mut self, probability: &mut Probability, bit: bool) -> bool {
        let bound = probability.bound(self.range);
        if bit {
            self.range = bound;
        } else {
            self.low += bound;
            self.range -= bound;
        }
        probability.learn(bit);
        self.narrow();
        bit
    }

    fn few_even_bits(&mut self, count: u32, value: u32) -> u32 {
        self.range >>= count;
        self.low += self.range * u64::from(value);
        self.narrow();
        value
    }
}

/// Reads bits.
#[derive(Debug)]
pub(super) struct Decoder<'a> {
    bytes: &'a [u8],
    /// The end of what may be read.
    end: usize,
    next: usize,
    code: u64,
    range: u64,
}

impl<'a> Decoder<'a> {
    /// Whatever follows `bytes` is 0; unless they are cut, then it may not be read.
    pub(super) fn new(bytes: &'a [u8], is_cut: bool) -> Self {
        let mut decoder = Self {
            bytes,
            end: bytes.len() + if is_cut { 0 } else { 2 * AHEAD },
            next: 0,
            code: 0,
            range: WHOLE_RANGE,
        };
        for _ in 0..AHEAD {
            decoder.shift();
        }
        decoder
    }

    #[inline]
    fn shift(&mut self) {
        let word = match self.bytes.get(self.next..) {
            Some(&[high, low, ..]) => u16::from_be_bytes([high, low]),
            Some(&[high]) => u16::from_be_bytes([high, 0]),
            _ => 0,
        };
        self.code = self.code << WORD_BITS | u64::from(word);
        self.next += 2;
    }

    #[inline]
    fn narrow(&mut self) {
        while self.range < LEAST_RANGE {
            self.range <<= WORD_BITS;
            self.shift();
        }
    }
}

impl Coder for Decoder<'_> {
    fn told<T: Default>(&self, _: impl FnOnce() -> T) -> T {
        T::default()
    }

    fn is_exhausted(&self) -> bool {
        self.next > self.end
    }

    #[inline]
    fn bit(&mut self, probability: &mut Probability, _: bool) -> bool {
        let bound = probability.bound(self.range);
        let bit = self.code < bound;
        let mask = u64::from(bit).wrapping_sub(1);
        self.code -= bound & mask;
        self.range = if bit { bound } else { self.range - bound };
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
        value as u32
    }
}

#[cfg(test)]
#[path = "range_coder_tests.rs"]
mod tests;
