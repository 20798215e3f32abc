//! The Rust types that a parameter may have.

use super::{ParamKind, Value};

/// A Rust type that a parameter may have.
pub trait ParamType: Sized {
    /// What kind of value it takes.
    fn kind() -> ParamKind;
    /// The value without its type.
    fn to_value(&self) -> Value;
    /// The value with its type; `None` when it is of another kind or does not fit.
    fn from_value(value: &Value) -> Option<Self>;
    /// The default as the struct holds it, from the one written in the definition.
    fn stored_default(written: Self, _unit: Option<&str>) -> Self {
        written
    }
}

/// An enum made by [`choice!`](crate::choice!).
pub trait ChoiceType: Sized + Copy {
    /// Names and what they mean, in order.
    const CHOICES: &'static [(&'static str, &'static str)];
    /// The position in the list: what the shader gets.
    fn index(self) -> u32;
    /// The choice called `name`.
    fn from_name(name: &str) -> Option<Self>;
}

/// What may stand after `in` in [`params!`](crate::params!).
pub trait IntoRange {
    /// Least and greatest value.
    fn into_range(self) -> (f64, f64);
}

impl<T: Into<f64> + Copy> IntoRange for std::ops::RangeInclusive<T> {
    fn into_range(self) -> (f64, f64) {
        ((*self.start()).into(), (*self.end()).into())
    }
}

impl ParamType for bool {
    fn kind() -> ParamKind {
        ParamKind::Bool
    }

    fn to_value(&self) -> Value {
        Value::Bool(*self)
    }

    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Bool(value) => Some(*value),
            _ => None,
        }
    }
}

impl ParamType for u32 {
    fn kind() -> ParamKind {
        ParamKind::Int { signed: false }
    }

    fn to_value(&self) -> Value {
        Value::Int(i64::from(*self))
    }

    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Int(value) => u32::try_from(*value).ok(),
            _ => None,
        }
    }
}

impl ParamType for i32 {
    fn kind() -> ParamKind {
        ParamKind::Int { signed: true }
    }

    fn to_value(&self) -> Value {
        Value::Int(i64::from(*self))
    }

    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Int(value) => i32::try_from(*value).ok(),
            _ => None,
        }
    }
}

impl ParamType for f32 {
    fn kind() -> ParamKind {
        ParamKind::Float
    }

    fn to_value(&self) -> Value {
        Value::Float(f64::from(*self))
    }

    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Float(value) => Some(*value as f32),
            _ => None,
        }
    }

    fn stored_default(written: Self, unit: Option<&str>) -> Self {
        match unit {
            Some("deg") => written.to_radians(),
            _ => written,
        }
    }
}

impl<const N: usize> ParamType for [f32; N] {
    fn kind() -> ParamKind {
        ParamKind::Vector(N)
    }

    fn to_value(&self) -> Value {
        Value::Vector(self.iter().map(|x| f64::from(*x)).collect())
    }

    fn from_value(value: &Value) -> Option<Self> {
        let Value::Vector(values) = value else {
            return None;
        };
        let values: Vec<f32> = values.iter().map(|x| *x as f32).collect();
        values.try_into().ok()
    }

    fn stored_default(written: Self, unit: Option<&str>) -> Self {
        written.map(|x| f32::stored_default(x, unit))
    }
}
