//! What is known about one parameter, and its values without their Rust type.

use std::fmt;

/// The value of a parameter without its Rust type.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `true` or `false`.
    Bool(bool),
    /// An integer, signed or not.
    Int(i64),
    /// A number.
    Float(f64),
    /// A vector or colour.
    Vector(Vec<f64>),
    /// The name of a choice.
    Choice(String),
}

/// What kind of value a parameter takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParamKind {
    /// `true` or `false`.
    Bool,
    /// A 32-bit integer.
    Int {
        /// Whether it may be negative.
        signed: bool,
    },
    /// A 32-bit floating point number.
    Float,
    /// A list of that many 32-bit floating point numbers.
    Vector(usize),
    /// One of these names, each with what it means.
    Choice(&'static [(&'static str, &'static str)]),
}

/// Everything that is known about one parameter: its documentation, check and widget come from here.
#[derive(Clone, Debug, PartialEq)]
pub struct ParamDef {
    /// Its name, in graph files, on the command line and in the shader's `Params`.
    pub name: &'static str,
    /// What it does, from its doc comment.
    pub about: &'static str,
    /// What kind of value it takes.
    pub kind: ParamKind,
    /// The default, in the units of graph files.
    pub default: Value,
    /// Least and greatest value (of each component), in the units of graph files.
    pub range: Option<(f64, f64)>,
    /// The unit, for example `px` or `deg`.
    pub unit: Option<&'static str>,
    /// Whether a change rebuilds the pass.
    pub structural: bool,
    /// Whether it is the number of samples that a tracer spends.
    pub budget: bool,
}

/// Why a parameter cannot have a value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ParamError {
    /// There is none of that name.
    #[error("there is no parameter `{name}`")]
    Unknown {
        /// The name asked for.
        name: String,
        /// The nearest name that exists.
        nearest: Option<String>,
    },
    /// A value of another kind.
    #[error("`{name}` takes {expected}, and got {found}")]
    Kind {
        /// The parameter.
        name: String,
        /// What it takes.
        expected: String,
        /// What was given.
        found: String,
    },
    /// Below or above the range, or not finite.
    #[error("`{name}` must be {range}, and got {found}")]
    Range {
        /// The parameter.
        name: String,
        /// The range, with its unit.
        range: String,
        /// What was given.
        found: String,
    },
    /// Not one of the choices.
    #[error("`{name}` has no choice `{found}`")]
    Choice {
        /// The parameter.
        name: String,
        /// What was given.
        found: String,
        /// What could have been given.
        choices: Vec<String>,
        /// The nearest of them.
        nearest: Option<String>,
    },
}

impl ParamError {
    /// The error for a name that is not among `defs`.
    pub fn unknown(name: &str, defs: &[ParamDef]) -> Self {
        Self::Unknown {
            name: name.to_owned(),
            nearest: crate::diagnostics::nearest(name, defs.iter().map(|def| def.name))
                .map(str::to_owned),
        }
    }
}

impl ParamDef {
    /// The definition called `name`, by which `value` (as stored, see [`ParamDef::stored`]) is
    /// checked; gives the value, with an integer made a number where one is expected.
    ///
    /// # Errors
    /// An unknown name, a value of another kind, out of range or not finite.
    pub fn checked(defs: &[ParamDef], name: &str, value: &Value) -> Result<Value, ParamError> {
        let Some(def) = defs.iter().find(|def| def.name == name) else {
            return Err(ParamError::unknown(name, defs));
        };
        def.check(&def.written(value))?;
        Ok(def.coerced(value))
    }

    /// Checks a value in the units of graph files.
    ///
    /// # Errors
    /// A value of another kind, out of range or not finite.
    pub fn check(&self, value: &Value) -> Result<(), ParamError> {
        match (self.kind, &self.coerced(value)) {
            (ParamKind::Bool, Value::Bool(_)) => Ok(()),
            (ParamKind::Int { signed }, Value::Int(n)) => {
                let (low, high) = match signed {
                    true => (i64::from(i32::MIN), i64::from(i32::MAX)),
                    false => (0, i64::from(u32::MAX)),
                };
                let (low, high) = self.range.map_or((low, high), |(a, b)| {
                    (low.max(a.ceil() as i64), high.min(b.floor() as i64))
                });
                match (low..=high).contains(n) {
                    true => Ok(()),
                    false => Err(self.out_of_range(Some((low as f64, high as f64)), value)),
                }
            }
            (ParamKind::Float, Value::Float(x)) => self.check_number(*x, value),
            (ParamKind::Vector(n), Value::Vector(v)) if v.len() == n => {
                v.iter().try_for_each(|x| self.check_number(*x, value))
            }
            (ParamKind::Choice(choices), Value::Choice(name)) => {
                if choices.iter().any(|(choice, _)| choice == name) {
                    return Ok(());
                }
                let names = || choices.iter().map(|(choice, _)| *choice);
                Err(ParamError::Choice {
                    name: self.name.to_owned(),
                    found: name.clone(),
                    choices: names().map(str::to_owned).collect(),
                    nearest: crate::diagnostics::nearest(name, names()).map(str::to_owned),
                })
            }
            _ => Err(ParamError::Kind {
                name: self.name.to_owned(),
                expected: self.kind.to_string(),
                found: value.described(),
            }),
        }
    }

    // Compared as f32, which is how the value is stored: a bound that went through radians and back
    // is still inside.
    fn check_number(&self, x: f64, value: &Value) -> Result<(), ParamError> {
        let single = x as f32;
        let inside = self
            .range
            .is_none_or(|(low, high)| (low as f32..=high as f32).contains(&single));
        match single.is_finite() && inside {
            true => Ok(()),
            false => Err(self.out_of_range(self.range, value)),
        }
    }

    fn out_of_range(&self, range: Option<(f64, f64)>, value: &Value) -> ParamError {
        let unit = self.unit.map_or(String::new(), |unit| format!(" {unit}"));
        ParamError::Range {
            name: self.name.to_owned(),
            range: match range {
                Some((low, high)) => format!("from {low} to {high}{unit}"),
                None => "a finite number".to_owned(),
            },
            found: value.to_string(),
        }
    }

    fn coerced(&self, value: &Value) -> Value {
        match (self.kind, value) {
            (ParamKind::Float, Value::Int(n)) => Value::Float(*n as f64),
            _ => value.clone(),
        }
    }

    /// The value as the struct and the shader hold it, from one in the units of graph files.
    pub fn stored(&self, value: &Value) -> Value {
        self.converted(value, |degrees| f64::from((degrees as f32).to_radians()))
    }

    /// The value in the units of graph files, from one as the struct and the shader hold it.
    pub fn written(&self, value: &Value) -> Value {
        self.converted(value, |radians| {
            // 60 degrees shall come back as 60 and not as 60.000004, where both are the same f32.
            let degrees = radians.to_degrees();
            let short = (degrees * 1e4).round() / 1e4;
            match (short as f32).to_radians() == radians as f32 {
                true => short,
                false => degrees,
            }
        })
    }

    fn converted(&self, value: &Value, angle: impl Fn(f64) -> f64) -> Value {
        let value = self.coerced(value);
        match value {
            Value::Float(x) if self.unit == Some("deg") => Value::Float(angle(x)),
            Value::Vector(v) if self.unit == Some("deg") => {
                Value::Vector(v.into_iter().map(angle).collect())
            }
            other => other,
        }
    }
}

impl Value {
    /// The value with its kind, for messages: "the number 2.5".
    pub fn described(&self) -> String {
        match self {
            Self::Bool(_) => format!("the truth value {self}"),
            Self::Int(_) => format!("the integer {self}"),
            Self::Float(_) => format!("the number {self}"),
            Self::Vector(v) => format!("{} numbers", v.len()),
            Self::Choice(name) => format!("the name `{name}`"),
        }
    }
}

/// As a graph file writes it.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bool(value) => write!(f, "{value}"),
            Self::Int(value) => write!(f, "{value}"),
            // Parameters are f32: the shortest text that gives the same f32.
            Self::Float(value) => write!(f, "{:?}", *value as f32),
            Self::Vector(values) => {
                f.write_str("(")?;
                for (i, value) in values.iter().enumerate() {
                    let comma = if i == 0 { "" } else { ", " };
                    write!(f, "{comma}{:?}", *value as f32)?;
                }
                f.write_str(")")
            }
            Self::Choice(name) => f.write_str(name),
        }
    }
}

impl fmt::Display for ParamKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bool => f.write_str("true or false"),
            Self::Int { signed: true } => f.write_str("an integer"),
            Self::Int { signed: false } => f.write_str("an integer from 0"),
            Self::Float => f.write_str("a number"),
            Self::Vector(n) => write!(f, "{n} numbers"),
            Self::Choice(choices) => {
                f.write_str("one of ")?;
                for (i, (name, _)) in choices.iter().enumerate() {
                    let comma = if i == 0 { "" } else { ", " };
                    write!(f, "{comma}{name}")?;
                }
                Ok(())
            }
        }
    }
}
