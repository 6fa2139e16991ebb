//! Surfaces that adapt: that they are consistent, and what changing them costs.
#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

mod consistency;
mod cost;
mod random;
mod views;
