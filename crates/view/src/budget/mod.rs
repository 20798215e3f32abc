//! A frame time that the tracers of a graph keep to: "given a limited amount of time" (Boughida, Groueix, Boubekeur
//! 2016, section 2).
//!
//! Every tracer marks one parameter as its budget; [`Budget`] sets them all from one number of paths per pixel, which a
//! [`Controller`] steers. A change starts averages anew that may not mix, such as those of `progressive`.

mod controller;

pub use controller::{Controller, Standing};

use scumble::{NameError, Pipeline, Resolved};
use scumble_lab::{budget_params, spending, spent_params};
use std::fmt;

/// Keeps the frames of a pipeline at a time.
#[derive(Clone, Debug)]
pub struct Budget {
    controller: Controller,
    params: Vec<String>,
}

impl Budget {
    /// For this graph, from what its tracers spend now.
    pub fn new(graph: &Resolved, milliseconds: f64) -> Budget {
        // The tracer that spends least: counts that are whole have their least at one, and it alone can be set finer.
        let spent = spending(graph).into_iter().map(|spent| spent.paths);
        let paths = spent.fold(f64::INFINITY, f64::min);
        let paths = if paths.is_finite() { paths } else { 1.0 };
        Budget {
            controller: Controller::new(milliseconds, paths),
            params: budget_params(graph),
        }
    }

    /// Milliseconds that are asked for.
    pub fn target(&self) -> f64 {
        self.controller.target()
    }

    /// Asks for another time.
    pub fn set_target(&mut self, milliseconds: f64) {
        self.controller.set_target(milliseconds);
    }

    /// What it sets, as `pass.parameter`.
    pub fn params(&self) -> &[String] {
        &self.params
    }

    /// Whether a graph has the parameters that it sets, and no others.
    pub fn fits(&self, graph: &Resolved) -> bool {
        self.params == budget_params(graph)
    }

    /// How the time stands to its target.
    pub fn standing(&self) -> Standing {
        self.controller.standing()
    }

    /// A frame of the pipeline took that long: sets the parameters of the next, where that is another budget.
    /// Gives whether it did.
    ///
    /// # Errors
    /// A parameter that the graph does not take.
    pub fn frame(&mut self, pipeline: &mut Pipeline, milliseconds: f64) -> Result<bool, NameError> {
        if self.params.is_empty() {
            return Ok(false);
        }
        let graph = pipeline.resolved();
        let settings = |paths| spent_params(graph, paths);
        if self.controller.frame(milliseconds, settings).is_none() {
            return Ok(false);
        }
        self.apply(pipeline)?;
        Ok(true)
    }

    /// Sets the parameters of the present budget: at first, and when the graph was read again.
    ///
    /// # Errors
    /// A parameter that the graph does not take.
    pub fn apply(&self, pipeline: &mut Pipeline) -> Result<(), NameError> {
        for (param, value) in spent_params(pipeline.resolved(), self.controller.paths()) {
            pipeline.set_param(&param, value)?;
        }
        Ok(())
    }
}

impl fmt::Display for Budget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.params.is_empty() {
            return f.write_str("no pass of this graph has a budget");
        }
        match self.controller.median() {
            Some(median) => write!(f, "{median:.1} ms of {}", self.target())?,
            None => write!(f, "no time yet of {} ms", self.target())?,
        }
        write!(f, ", {:.3} paths a pixel", self.controller.paths())?;
        f.write_str(match self.standing() {
            Standing::Settling => ", settling",
            Standing::Reached => "",
            Standing::Floor => ": the floor, it cannot trace less",
            Standing::Cap => ": the cap, it cannot trace more",
            Standing::Coarse => ": one path more is too slow",
        })
    }
}
