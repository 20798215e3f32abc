//! Wiring: which output each input reads, and whether they fit.
//!
//! Every function takes a whole draft and does one thing: [`connect`] finds what is not named,
//! [`spread_grids`] carries spacings along the wires, [`check`] compares the two ends of each wire,
//! [`check_bypasses`] what stands in for bypassed passes, [`order`] sorts and finds cycles.

mod bypass;
mod check;
mod connect;
mod order;

pub(crate) use bypass::{check_bypasses, is_read};
pub(crate) use check::{check, spread_grids};
pub(crate) use connect::{connect, report_open};
pub(crate) use order::order;
