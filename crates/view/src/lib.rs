#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod background;
pub mod budget;
mod changes;
mod clock;
pub mod compare;
pub mod display;
pub mod drawing;
mod error;
mod fly;
mod gui;
pub mod interface;
mod message;
mod options;
mod panel;
mod rows;
mod running;
mod save;
mod screen;
mod screenshot;
mod shaders;
mod stage;
mod view;
mod watch;
mod window;
mod written;

pub use changes::{Changes, Set};
pub use clock::Clock;
pub use error::ViewError;
pub use fly::{Fly, Held};
pub use message::Message;
pub use options::{Options, Start};
pub use panel::{Asked, panel};
pub use running::{Running, StartError};
pub use save::{SaveError, edited, variant};
pub use screen::{Screen, Wanted};
pub use screenshot::{ScreenshotError, screenshot};
pub use shaders::read_shaders;
pub use stage::Stage;
pub use view::View;
pub use watch::{INTERVAL, Watch};
pub use window::run;
