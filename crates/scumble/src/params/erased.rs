//! Parameters without their Rust type.

use std::any::Any;
use std::fmt;
use std::sync::Arc;

use super::{ParamDef, ParamError, Params, Value};

// What `ErasedParams` asks of the struct inside.
trait AnyParams: Send + Sync + fmt::Debug {
    fn defs(&self) -> &[ParamDef];
    fn get(&self, name: &str) -> Option<Value>;
    fn set(&mut self, name: &str, value: &Value) -> Result<(), ParamError>;
    fn clone_box(&self) -> Box<dyn AnyParams>;
    fn as_any(&self) -> &dyn Any;
}

// A type of its own, so that a struct of parameters has one `get` and one `set`.
#[derive(Clone)]
struct Typed<P>(P);

impl<P: fmt::Debug> fmt::Debug for Typed<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl<P: Params> AnyParams for Typed<P> {
    fn defs(&self) -> &[ParamDef] {
        P::defs()
    }

    fn get(&self, name: &str) -> Option<Value> {
        self.0.get(name)
    }

    fn set(&mut self, name: &str, value: &Value) -> Result<(), ParamError> {
        self.0.set(name, value)
    }

    fn clone_box(&self) -> Box<dyn AnyParams> {
        Box::new(self.clone())
    }

    fn as_any(&self) -> &dyn Any {
        &self.0
    }
}

/// The parameters of a pass without their Rust type. Values are as the shader gets them.
///
/// ```
/// use scumble::{ErasedParams, Value};
///
/// scumble::params! {
///     /// One number.
///     pub struct Gain {
///         /// Factor.
///         pub gain: f32 = 2.0, in 0.0..=8.0;
///     }
/// }
///
/// let mut params = ErasedParams::new(Gain::default());
/// params.set("gain", &Value::Float(3.0)).unwrap();
/// assert_eq!(params.downcast_ref::<Gain>().unwrap().gain, 3.0);
/// ```
pub struct ErasedParams(Box<dyn AnyParams>);

impl ErasedParams {
    /// Forgets the type.
    pub fn new<P: Params>(params: P) -> Self {
        Self(Box::new(Typed(params)))
    }

    /// Defaults of parameters that are defined at run time, such as those of a pass that is only a
    /// WGSL file.
    pub fn dynamic(defs: impl Into<Arc<[ParamDef]>>) -> Self {
        let defs = defs.into();
        let values = defs.iter().map(|def| def.stored(&def.default)).collect();
        Self(Box::new(DynamicParams { defs, values }))
    }

    /// The definitions, in order.
    pub fn defs(&self) -> &[ParamDef] {
        self.0.defs()
    }

    /// The definition of one parameter.
    pub fn def(&self, name: &str) -> Option<&ParamDef> {
        self.defs().iter().find(|def| def.name == name)
    }

    /// See [`Params::get`].
    pub fn get(&self, name: &str) -> Option<Value> {
        self.0.get(name)
    }

    /// See [`Params::set`].
    ///
    /// # Errors
    /// An unknown name, a value of another kind, out of range or not finite.
    pub fn set(&mut self, name: &str, value: &Value) -> Result<(), ParamError> {
        self.0.set(name, value)
    }

    /// The struct, when it is a `P`.
    pub fn downcast_ref<P: Params>(&self) -> Option<&P> {
        self.0.as_any().downcast_ref()
    }

    /// Every parameter with its value in the units of graph files.
    pub fn written(&self) -> impl Iterator<Item = (&ParamDef, Value)> {
        let values = self.defs().iter();
        values.filter_map(|def| Some((def, def.written(&self.get(def.name)?))))
    }
}

impl Clone for ErasedParams {
    fn clone(&self) -> Self {
        Self(self.0.clone_box())
    }
}

impl PartialEq for ErasedParams {
    fn eq(&self, other: &Self) -> bool {
        let names = |params: &Self| -> Vec<_> {
            let defs = params.defs().iter();
            defs.map(|def| (def.name, params.get(def.name))).collect()
        };
        names(self) == names(other)
    }
}

impl fmt::Debug for ErasedParams {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

#[derive(Clone, Debug)]
struct DynamicParams {
    defs: Arc<[ParamDef]>,
    values: Vec<Value>,
}

impl AnyParams for DynamicParams {
    fn defs(&self) -> &[ParamDef] {
        &self.defs
    }

    fn get(&self, name: &str) -> Option<Value> {
        let index = self.defs.iter().position(|def| def.name == name)?;
        self.values.get(index).cloned()
    }

    fn set(&mut self, name: &str, value: &Value) -> Result<(), ParamError> {
        let value = ParamDef::checked(&self.defs, name, value)?;
        let index = self.defs.iter().position(|def| def.name == name);
        if let Some(slot) = index.and_then(|index| self.values.get_mut(index)) {
            *slot = value;
        }
        Ok(())
    }

    fn clone_box(&self) -> Box<dyn AnyParams> {
        Box::new(self.clone())
    }

    fn as_any(&self) -> &dyn Any {
        self
    }
}
