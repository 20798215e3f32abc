//! Parameters: one definition gives the struct, its defaults, ranges, units and documentation.
//!
//! [`params!`](crate::params!) and [`choice!`](crate::choice!) define; [`Params`] is what they
//! implement; [`ErasedParams`] is the same without the type, as a resolved graph carries it.
//!
//! **Units.** The struct, [`Params::get`] and [`Params::set`] hold what the shader gets, so angles
//! in radians. Everything an author sees is in the units of graph files, so angles in degrees: the
//! default, range and unit of a [`ParamDef`]. [`ParamDef::stored`] and [`ParamDef::written`] convert.

mod define;
mod erased;
mod kinds;
mod schema;

pub use define::{ParamDef, ParamError, ParamKind, Value};
pub use erased::ErasedParams;
pub use kinds::{ChoiceType, IntoRange, ParamType};

/// A struct of parameters, made by [`params!`](crate::params!).
pub trait Params: Default + Clone + PartialEq + std::fmt::Debug + Send + Sync + 'static {
    /// The definitions, in the order of the struct.
    fn defs() -> &'static [ParamDef];

    /// The value of one parameter as the shader gets it; `None` when there is none of that name.
    fn get(&self, name: &str) -> Option<Value>;

    /// Sets one parameter from a value as the shader gets it.
    ///
    /// # Errors
    /// An unknown name, a value of another kind, out of range or not finite.
    fn set(&mut self, name: &str, value: &Value) -> Result<(), ParamError>;
}

/// The parameters of a pass that has none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoParams;

impl Params for NoParams {
    fn defs() -> &'static [ParamDef] {
        &[]
    }

    fn get(&self, _name: &str) -> Option<Value> {
        None
    }

    fn set(&mut self, name: &str, _value: &Value) -> Result<(), ParamError> {
        Err(ParamError::unknown(name, &[]))
    }
}

/// Defines a struct of parameters.
///
/// Types are `bool`, `u32`, `i32`, `f32`, `[f32; 2]` to `[f32; 4]` and any enum of
/// [`choice!`](crate::choice!). Each parameter has a default, and may have a range and a unit; both
/// are in the units of graph files, and with `unit "deg"` the struct holds radians. `#[structural]`
/// parameters rebuild the pass when they change, all others may change every frame. `#[budget]`
/// marks the one parameter that says how many samples a tracer spends.
///
/// ```
/// scumble::choice! {
///     /// Depth term of the weight.
///     pub enum DepthTerm {
///         /// (z_p/z_q - 1)^2.
///         #[default]
///         Ratio,
///         /// ln(z_p/z_q)^2.
///         Log,
///     }
/// }
///
/// scumble::params! {
///     /// What the filter can be told.
///     pub struct FilterParams {
///         /// Weight of the depth term.
///         pub lambda_z: f32 = 1.0, in 0.0..=100.0;
///         /// Cone around the normal.
///         pub cone: f32 = 45.0, in 0.0..=90.0, unit "deg";
///         /// Distance of the taps.
///         #[structural]
///         pub radius: u32 = 2, in 1..=16, unit "px";
///         /// Which depth term.
///         pub depth_term: DepthTerm = DepthTerm::Ratio;
///     }
/// }
///
/// use scumble::{Params, Value};
/// let mut params = FilterParams::default();
/// assert_eq!(params.cone, 45f32.to_radians());
/// params.set("radius", &Value::Int(4)).unwrap();
/// assert_eq!(params.radius, 4);
/// assert!(params.set("radius", &Value::Int(99)).is_err());
/// assert_eq!(FilterParams::defs()[0].about, "Weight of the depth term.");
/// ```
#[macro_export]
macro_rules! params {
    (
        $(#[$outer:meta])*
        $vis:vis struct $name:ident {
            $(
                $(#[$($attr:tt)*])*
                pub $field:ident : $ty:ty = $default:expr $(, in $range:expr)? $(, unit $unit:literal)? ;
            )*
        }
    ) => {
        $(#[$outer])*
        #[derive(Clone, Debug, PartialEq)]
        $vis struct $name {
            $(
                #[doc = concat!($($crate::__param_doc!($($attr)*)),*)]
                pub $field: $ty,
            )*
        }

        impl ::core::default::Default for $name {
            fn default() -> Self {
                Self {
                    $($field: $crate::ParamType::stored_default(
                        $default,
                        $crate::__param_option!($($unit)?),
                    ),)*
                }
            }
        }

        impl $crate::Params for $name {
            fn defs() -> &'static [$crate::ParamDef] {
                static DEFS: ::std::sync::LazyLock<::std::vec::Vec<$crate::ParamDef>> =
                    ::std::sync::LazyLock::new(|| ::std::vec![
                        $($crate::ParamDef {
                            name: stringify!($field),
                            about: concat!($($crate::__param_doc!($($attr)*)),*).trim(),
                            kind: <$ty as $crate::ParamType>::kind(),
                            default: {
                                let value: $ty = $default;
                                $crate::ParamType::to_value(&value)
                            },
                            range: $crate::__param_option!($($crate::IntoRange::into_range($range))?),
                            unit: $crate::__param_option!($($unit)?),
                            structural: false $(|| $crate::__param_structural!($($attr)*))*,
                            budget: false $(|| $crate::__param_budget!($($attr)*))*,
                        },)*
                    ]);
                &DEFS
            }

            fn get(&self, name: &str) -> ::core::option::Option<$crate::Value> {
                match name {
                    $(stringify!($field) => Some($crate::ParamType::to_value(&self.$field)),)*
                    _ => None,
                }
            }

            fn set(
                &mut self,
                name: &str,
                value: &$crate::Value,
            ) -> ::core::result::Result<(), $crate::ParamError> {
                let value = $crate::ParamDef::checked(Self::defs(), name, value)?;
                match name {
                    $(stringify!($field) => {
                        if let Some(value) = $crate::ParamType::from_value(&value) {
                            self.$field = value;
                        }
                    })*
                    _ => {}
                }
                Ok(())
            }
        }
    };
}

/// Defines an enum that is the type of a parameter: a choice between named values. One of them is
/// marked `#[default]`.
///
/// In WGSL the value is a `u32`: the position in the list, from 0.
///
/// ```
/// scumble::choice! {
///     /// Which curve.
///     pub enum Curve {
///         /// None at all.
///         #[default]
///         Identity,
///         /// x / (1 + x).
///         Reinhard,
///     }
/// }
/// assert_eq!(Curve::Reinhard as u32, 1);
/// ```
#[macro_export]
macro_rules! choice {
    (
        $(#[$outer:meta])*
        $vis:vis enum $name:ident {
            $( $(#[$($attr:tt)*])* $variant:ident ),+ $(,)?
        }
    ) => {
        $(#[$outer])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        $vis enum $name {
            $( $(#[$($attr)*])* $variant, )+
        }

        impl $crate::ChoiceType for $name {
            const CHOICES: &'static [(&'static str, &'static str)] = &[
                $((
                    stringify!($variant),
                    concat!($($crate::__param_doc!($($attr)*)),*).trim_ascii(),
                ),)+
            ];

            fn index(self) -> u32 {
                self as u32
            }

            fn from_name(name: &str) -> ::core::option::Option<Self> {
                match name {
                    $(stringify!($variant) => Some(Self::$variant),)+
                    _ => None,
                }
            }
        }

        $crate::__choice_param_type!($name);
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __param_doc {
    (doc = $text:literal) => {
        $text
    };
    ($($other:tt)*) => {
        ""
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __param_structural {
    (structural) => {
        true
    };
    ($($other:tt)*) => {
        false
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __param_budget {
    (budget) => {
        true
    };
    ($($other:tt)*) => {
        false
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __param_option {
    () => {
        None
    };
    ($value:expr) => {
        Some($value)
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __choice_param_type {
    ($name:ident) => {
        impl $crate::ParamType for $name {
            fn kind() -> $crate::ParamKind {
                $crate::ParamKind::Choice(<Self as $crate::ChoiceType>::CHOICES)
            }

            fn to_value(&self) -> $crate::Value {
                let choices = <Self as $crate::ChoiceType>::CHOICES;
                let index = $crate::ChoiceType::index(*self) as usize;
                $crate::Value::Choice(choices[index].0.to_owned())
            }

            fn from_value(value: &$crate::Value) -> ::core::option::Option<Self> {
                match value {
                    $crate::Value::Choice(name) => <Self as $crate::ChoiceType>::from_name(name),
                    _ => None,
                }
            }
        }
    };
}

#[cfg(test)]
mod tests;
