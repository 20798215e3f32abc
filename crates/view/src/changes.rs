//! What was changed in the window, apart from the files.

use scumble::{Edits, Resolved, Value};

/// Parameters set and passes bypassed in the window: they lie over what the files say, and hold at every reload
/// while the files have such a pass and parameter.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    set: Vec<Set>,
    /// Passes and whether they are bypassed.
    bypass: Vec<(String, bool)>,
}

/// One parameter with the value that it has instead of the file's, in the units of graph files.
#[derive(Clone, Debug, PartialEq)]
pub struct Set {
    /// The pass, such as `e/atrous`.
    pub pass: String,
    /// The parameter.
    pub param: String,
    /// The value.
    pub value: Value,
}

impl Set {
    /// `pass.param`, as graph files write it.
    pub fn name(&self) -> String {
        format!("{}.{}", self.pass, self.param)
    }
}

impl Changes {
    /// Whether nothing was changed.
    pub fn is_empty(&self) -> bool {
        self.set.is_empty() && self.bypass.is_empty()
    }

    /// The parameters.
    pub fn set(&self) -> &[Set] {
        &self.set
    }

    /// The passes that are bypassed here and not in the files, or the other way round.
    pub fn bypass(&self) -> &[(String, bool)] {
        &self.bypass
    }

    /// Sets a parameter.
    pub fn put(&mut self, pass: &str, param: &str, value: Value) {
        let known = |set: &&mut Set| set.pass == pass && set.param == param;
        match self.set.iter_mut().find(known) {
            Some(set) => set.value = value,
            None => self.set.push(Set {
                pass: pass.to_owned(),
                param: param.to_owned(),
                value,
            }),
        }
    }

    /// Bypasses a pass, or takes that back.
    pub fn put_bypass(&mut self, pass: &str, bypassed: bool) {
        match self.bypass.iter_mut().find(|(name, _)| name == pass) {
            Some((_, now)) => *now = bypassed,
            None => self.bypass.push((pass.to_owned(), bypassed)),
        }
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        *self = Changes::default();
    }

    /// Forgets what says what the files say by now, and what they have no pass or parameter for; gives the latter, as a
    /// viewer reads it. `files` is the graph without these changes.
    ///
    /// ```
    /// # fn f(files: &scumble::Resolved) {
    /// let mut changes = scumble_view::Changes::default();
    /// changes.put("atrous", "levels", scumble::Value::Int(3));
    /// for lost in changes.settle(files) {
    ///     println!("{lost}"); // `atrous.levels` is no longer there
    /// }
    /// # }
    /// ```
    pub fn settle(&mut self, files: &Resolved) -> Vec<String> {
        let mut lost = Vec::new();
        self.set.retain(|set| {
            let pass = files.pass(&set.pass).map(|(_, pass)| pass);
            let found = pass.and_then(|pass| {
                let def = pass.params.def(&set.param)?;
                def.check(&set.value).ok()?;
                Some(def.written(&pass.params.get(&set.param)?))
            });
            match found {
                Some(value) => value != set.value,
                None => {
                    lost.push(format!("`{}` = {} fits no longer", set.name(), set.value));
                    false
                }
            }
        });
        self.bypass.retain(|(name, bypassed)| {
            let pass = files.pass(name).map(|(_, pass)| pass);
            match pass {
                Some(pass) => pass.bypassed != *bypassed,
                None => {
                    lost.push(format!("`{name}` is no longer there"));
                    false
                }
            }
        });
        lost
    }

    /// These changes after those of the command line. That a pass is not bypassed is no edit: see
    /// [`Changes::take_back_bypasses`].
    pub fn edits(&self, base: &Edits) -> Edits {
        let mut edits = base.clone();
        let set = self.set.iter();
        edits
            .set
            .extend(set.map(|set| (set.name(), set.value.to_string())));
        let bypassed = self.bypass.iter().filter(|(_, bypassed)| *bypassed);
        edits.bypass.extend(bypassed.map(|(name, _)| name.clone()));
        edits
    }

    /// Runs again what the files bypass and the window does not.
    pub fn take_back_bypasses(&self, graph: &mut Resolved) {
        for pass in &mut graph.passes {
            if self
                .bypass
                .iter()
                .any(|(name, on)| !on && *name == pass.name)
            {
                pass.bypassed = false;
            }
        }
    }
}
