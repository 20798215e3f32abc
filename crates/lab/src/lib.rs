#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod balance;
mod baseline;
mod budget;
mod calibrate;
mod cell;
pub mod device;
mod error;
mod experiment;
mod images;
mod key;
mod measure;
mod mistakes;
mod output;
mod plan;
mod record;
mod render;
mod report;
mod results;
mod runner;
mod scene;
mod stage;
mod statistics;
mod student;

pub use baseline::{Allowance, Baseline, BaselineError, Rise};
pub use budget::{Spending, budget_params, spend, spending, spent_params};
pub use device::{DeviceError, Gpu};
pub use error::LabError;
pub use experiment::{
    Ablate, Budget, CameraPath, Experiment, Factor, GraphChoice, Measure, Motion, ReferenceChoice,
};
pub use images::{Images, full_error};
pub use key::Key;
pub use measure::{Exposed, Flickering, Guide, exposure};
pub use plan::{CameraDesign, Design, Factorial, Plan, Sweep, SweepPoint, Variant, VariantDesign};
pub use record::{FrameRecord, Record};
pub use render::{FrameError, read_image, render_frame};
pub use results::{EffectsOf, Failure, Index, MetricSummary, Results, Spent, Summary, merge};
pub use runner::{Event, Runner, Shard, measure_speed};
pub use scene::{NoCamera, find_camera, load_scene, seen_from};
pub use statistics::{Effect, Estimate, LEVEL, effects, quantile};
pub use student::student_t;
