//! Passes that are only a WGSL file.
//!
//! ```wgsl
//! // Brightens an image.
//! //   out = gain value
//! struct Params {
//!     gain: f32, // 2.0 in 0..10, EV; factor on every channel
//!     frame_index: u32,
//! }
//! @group(0) @binding(0) var<uniform> params: Params;
//! // port value: any, any; the image
//! @group(0) @binding(1) var value: texture_2d<f32>;
//! // port value: any, any; brighter
//! @group(0) @binding(2) var out_value: texture_storage_2d<{{value.format}}, write>;
//!
//! @compute @workgroup_size(8, 8)
//! fn main(@builtin(global_invocation_id) id: vec3u) {
//!     textureStore(out_value, id.xy, params.gain * textureLoad(value, id.xy, 0));
//! }
//! ```
//!
//! - The comment at the top says what it is: its first line in short.
//! - `// port NAME: SIGNAL, RESOLUTION; what it is` stands at or above its binding. `SIGNAL` is a signal
//!   of the registry or `any`, `RESOLUTION` is `full`, `grid` or `any`. A binding called `out_NAME` is an
//!   output. Before the `;`, after commas, an input may be `optional`, have a `source NAME`, and say what
//!   a read of the previous frame gets when there is none: `first skip`, `first copy NAME` (of another
//!   input), `first VALUE`, `first (R, G, B, A)`. An output may be `precise`, `precise if kept`, and
//!   `alters` where its values are others than the input's even for a constant image.
//! - `// DEFAULT in MIN..MAX, UNIT; what it is` beside a member of `Params` makes it a parameter;
//!   range, unit and text may be left out. `true` and `false` make a `u32` a truth value,
//!   `// NAME of NAME | NAME; what it is` makes it a choice: the position in the list, from 0. Angles
//!   (unit `deg`) are radians in the shader. Members that every shader can ask for need no comment.
//! - `main` runs once per texel of the first output.
//! - An output with an input of its name and signal is that input when the pass is bypassed, resampled
//!   where the resolution differs.

mod mistake;
mod params;
mod ports;
mod read;
mod scan;

use std::path::Path;
use std::sync::Mutex;

use framegraph::ComputeKernel;

use crate::context::{BuildContext, BuildError};
use crate::diagnostics::{Diagnostic, Diagnostics, SourceFile, Span, code};
use crate::file::read_text;
use crate::params::ErasedParams;
use crate::pass::{AnyPass, Bypass, Filter};
use crate::pass_frame::{PassFrame, RecordError};
use crate::port::Port;
use crate::registry::{PassType, Registry, WgslLoader, WgslPassError};

/// Makes a kind of pass from the text of a WGSL file; `name` is its name in messages.
///
/// # Errors
/// Everything that is wrong with the file, with its place.
pub fn wgsl_pass(
    name: &str,
    text: &str,
    registry: &Registry,
) -> Result<PassType, Vec<WgslPassError>> {
    let facts = read::read(name, text, registry)?;
    let output = facts.outputs[0].name;
    let (file, source) = (name.to_owned(), text.to_owned());
    let build =
        move |ctx: &BuildContext<'_>, _: &ErasedParams| -> Result<Box<dyn AnyPass>, BuildError> {
            let kernel = ctx.kernel(&file, &source, "main")?;
            Ok(Box::new(WgslPass { kernel, output }))
        };
    let mut ty = PassType::from_build(name, build);
    ty.bypass = bypass(&facts.inputs, &facts.outputs);
    ty.about = facts.about;
    ty.readme = facts.readme;
    ty.inputs = facts.inputs;
    ty.outputs = facts.outputs;
    ty.defaults = ErasedParams::dynamic(facts.params);
    ty.text = Some(text.to_owned());
    Ok(ty)
}

/// Reads the pass that a WGSL file is, under the name of its path.
///
/// ```no_run
/// # fn main() -> Result<(), scumble::Diagnostics> {
/// let filter = scumble::read_wgsl_pass("my-filter.wgsl", &scumble::Registry::new())?;
/// println!("{}: {}", filter.name, filter.about);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// Every mistake in the file, with its place; that it cannot be read.
pub fn read_wgsl_pass(
    path: impl AsRef<Path>,
    registry: &Registry,
) -> Result<PassType, Diagnostics> {
    let (path, mut diagnostics) = (path.as_ref(), Diagnostics::new());
    let Some(text) = read_text(path, None, &mut diagnostics) else {
        return Err(diagnostics);
    };
    wgsl_pass_of(&path.display().to_string(), text, registry, wgsl_pass)
}

/// What a loader makes of a text, its errors at their places.
pub(crate) fn wgsl_pass_of(
    name: &str,
    text: String,
    registry: &Registry,
    loader: WgslLoader,
) -> Result<PassType, Diagnostics> {
    let source = SourceFile::new(name, text);
    let diagnostic = |error: WgslPassError| {
        let mut diagnostic = Diagnostic::new(code::WGSL_PASS, error.message);
        if let Some(range) = error.span {
            diagnostic = diagnostic.at(&Span::new(&source, range), "");
        }
        diagnostic.help = error.help;
        diagnostic
    };
    loader(source.name(), source.text(), registry).map_err(|errors| {
        let mut all = Diagnostics::new();
        errors.into_iter().for_each(|e| all.push(diagnostic(e)));
        all
    })
}

struct WgslPass {
    kernel: ComputeKernel,
    output: &'static str,
}

impl AnyPass for WgslPass {
    fn record(
        &mut self,
        _: &ErasedParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.size_of(self.output);
        frame.dispatch("main", &self.kernel).over(size)
    }
}

fn bypass(inputs: &[Port], outputs: &[Port]) -> Vec<Bypass> {
    let mut rules = Vec::new();
    for output in outputs {
        let same = |input: &&Port| input.name == output.name && input.signal == output.signal;
        if let Some(input) = inputs.iter().find(same) {
            rules.push(if input.resolution == output.resolution {
                Bypass::alias(output.name, input.name)
            } else {
                Bypass::resample(output.name, input.name, Filter::Linear)
            });
        }
    }
    rules
}

/// The text for as long as the program runs. Names of ports and parameters live that long; each is
/// kept once, however often its file is read again.
fn interned(text: &str) -> &'static str {
    static ALL: Mutex<Vec<&'static str>> = Mutex::new(Vec::new());
    let mut all = ALL
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    if let Some(found) = all.iter().find(|known| **known == text) {
        return found;
    }
    let kept: &'static str = Box::leak(text.to_owned().into_boxed_str());
    all.push(kept);
    kept
}
