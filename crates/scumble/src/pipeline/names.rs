//! Names that a host gives: `pass.port`, `pass.parameter`.

use super::error::NameError;
use crate::diagnostics::hint;
use crate::resolve::Resolved;

impl Resolved {
    /// The pass (its position in [`Resolved::passes`]) and the output (its position in the pass)
    /// that `pass.port` names.
    ///
    /// # Errors
    /// No such pass or output.
    pub fn find_output(&self, name: &str) -> Result<(usize, usize), NameError> {
        let (index, port) = self.split(name)?;
        let pass = &self.passes[index];
        let outputs = || pass.ty.outputs.iter().map(|port| port.name);
        match outputs().position(|output| output == port) {
            Some(output) => Ok((index, output)),
            None => Err(NameError::NoOutput {
                pass: pass.name.clone(),
                output: port.to_owned(),
                hint: hint(port, outputs()),
            }),
        }
    }

    /// The pass and the rest of `pass.rest`; names of passes hold no dots.
    pub(super) fn split<'n>(&self, name: &'n str) -> Result<(usize, &'n str), NameError> {
        let (pass, rest) = name
            .rsplit_once('.')
            .ok_or_else(|| NameError::Form(name.to_owned()))?;
        let names = || self.passes.iter().map(|p| p.name.as_str());
        match names().position(|n| n == pass) {
            Some(i) => Ok((i, rest)),
            None => Err(NameError::Unknown {
                kind: "pass",
                name: pass.to_owned(),
                hint: hint(pass, names()),
            }),
        }
    }
}
