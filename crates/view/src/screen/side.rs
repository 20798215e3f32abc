//! One graph on the screen: the port that is looked at, its picture, its times, its budget.

use super::Wanted;
use crate::budget::Budget;
use crate::display::{Display, DisplayError, Look, Meter, Range, Settings, Statistics, signal_of};
use crate::drawing::Profiler;
use scumble::{Pipeline, Resolved, Signal};

pub(super) struct Side {
    display: Display,
    meter: Meter,
    statistics: Option<Statistics>,
    pub profiler: Profiler,
    budget: Option<Budget>,
    /// What the budget was set in: reloads and the graph that they gave.
    swaps: u32,
    tapped: Option<String>,
    /// What the meter looks at.
    looked: Option<(Option<String>, Settings)>,
    /// Why nothing is shown.
    pub problem: Option<String>,
}

/// The output that a graph is for: what is ready for the screen, or else the first that there is.
fn own_picture(graph: &Resolved) -> Option<&str> {
    let mut names = graph.outputs.iter().map(|(name, _)| name.as_str());
    let display = names.clone().find(|name| *name == "display");
    display.or_else(|| names.next())
}

impl Side {
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Side, DisplayError> {
        Ok(Side {
            display: Display::new(device, queue)?,
            meter: Meter::default(),
            statistics: None,
            profiler: Profiler::default(),
            budget: None,
            swaps: 0,
            tapped: None,
            looked: None,
            problem: None,
        })
    }

    /// Before a frame is recorded; `swaps` counts the reloads of the graph.
    pub fn begin(&mut self, pipeline: &mut Pipeline, swaps: u32, wanted: &Wanted) {
        self.problem = None;
        if self.tapped != wanted.port
            && let Some(before) = self.tapped.take()
        {
            pipeline.untap(&before);
        }
        if let Some(port) = &wanted.port {
            self.tapped = Some(port.clone());
            // Once more in each frame: a reload lets go of a port that is not there, and the next may bring it back.
            self.problem = pipeline.tap(port).err().map(|error| error.to_string());
        }
        self.steer(pipeline, swaps, wanted.target());
        if wanted.drawn || wanted.budget {
            self.profiler.begin(pipeline, wanted.budget);
        } else {
            pipeline.debug().timestamps = false;
        }
    }

    /// Sets the parameters of the budget where they are not those of the last frame.
    fn steer(&mut self, pipeline: &mut Pipeline, swaps: u32, target: Option<f64>) {
        let Some(target) = target else {
            self.budget = None;
            return;
        };
        let graph = pipeline.resolved();
        let known = self.budget.take();
        let known = known.filter(|budget| budget.fits(graph));
        let is_new = known.is_none() || self.swaps != swaps;
        let mut budget = known.unwrap_or_else(|| Budget::new(graph, target));
        budget.set_target(target);
        self.swaps = swaps;
        if is_new && let Err(error) = budget.apply(pipeline) {
            self.problem = Some(error.to_string());
        }
        self.budget = Some(budget);
    }

    /// The texture that is asked for, and what it carries.
    pub fn shown<'p>(
        &self,
        pipeline: &'p Pipeline,
        port: Option<&str>,
    ) -> Option<(&'p wgpu::Texture, Signal)> {
        let graph = pipeline.resolved();
        match port {
            Some(port) => Some((pipeline.tapped(port)?, signal_of(graph, port)?)),
            None => {
                let name = own_picture(graph)?;
                Some((pipeline.output(name)?, signal_of(graph, name)?))
            }
        }
    }

    /// Linear values of what is shown.
    pub fn light<'p>(
        &self,
        pipeline: &'p Pipeline,
        port: Option<&str>,
    ) -> Option<&'p wgpu::Texture> {
        match self.shown(pipeline, port)? {
            (_, signal) if Look::of(signal) == Look::Encoded => pipeline.output("linear"),
            (texture, signal) if !Look::of(signal).is_integer() => Some(texture),
            _ => None,
        }
    }

    /// Into the encoder that has the frame.
    pub fn record(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        pipeline: &Pipeline,
        wanted: &Wanted,
    ) {
        let Some((texture, signal)) = self.shown(pipeline, wanted.port.as_deref()) else {
            if let (None, Some(port)) = (&self.problem, &wanted.port) {
                self.problem = Some(format!("`{port}` is not made in this frame"));
            }
            return;
        };
        let settings = &wanted.settings;
        let needs_range = Look::of(signal).has_range(settings.colours.is_some())
            && settings.range == Range::Measured;
        if wanted.port.is_some() || needs_range {
            let looked = Some((wanted.port.clone(), *settings));
            if self.looked != looked {
                // The range of before would be as good as none.
                self.meter.forget();
                self.statistics = None;
                self.looked = looked;
            }
            if let Err(error) = self.meter.look(device, encoder, texture, signal, settings) {
                self.problem = Some(error.to_string());
            }
        } else {
            (self.statistics, self.looked) = (None, None);
        }
        let measured = self.statistics.and_then(|found| found.range);
        if let Err(error) = self
            .display
            .paint(encoder, texture, signal, settings, measured)
        {
            self.problem = Some(error.to_string());
        }
    }

    /// After the frame was submitted.
    pub fn submitted(&mut self, device: &wgpu::Device, pipeline: &mut Pipeline) {
        self.meter.submitted();
        if let Some(milliseconds) = self.profiler.end(device, pipeline)
            && let Some(budget) = &mut self.budget
            && let Err(error) = budget.frame(pipeline, milliseconds)
        {
            self.problem = Some(error.to_string());
        }
        // A device that is lost tells so when the next frame is rendered.
        let _ = device.poll(wgpu::PollType::Poll);
        match self.meter.latest() {
            Ok(found) if self.looked.is_some() => self.statistics = found,
            Ok(_) => {}
            Err(error) => self.problem = Some(error.to_string()),
        }
    }

    /// What was painted last; `None` where nothing is shown.
    pub fn picture(&self) -> Option<&wgpu::Texture> {
        match self.problem {
            Some(_) => None,
            None => self.display.picture(),
        }
    }

    pub fn statistics(&self) -> Option<&Statistics> {
        self.statistics.as_ref()
    }

    pub fn budget(&self) -> Option<&Budget> {
        self.budget.as_ref()
    }
}
