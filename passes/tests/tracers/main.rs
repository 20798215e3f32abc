//! The tracing passes, each run through a graph and its pipeline, against closed forms, brute force and themselves.

mod common;
mod conformance;
mod determinism;
mod direct;
mod estimators;
mod gbuffer;
mod motion;
mod reflected;
mod sparse;
