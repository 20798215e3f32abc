//! Parameters as JSON: typed values, and a JSON Schema (draft 2020-12) for tools and editors.

use serde_json::{Map, Value as Json, json};

use super::{ParamDef, ParamKind, Value};

impl Value {
    /// The value as JSON: a boolean, a number, an array of numbers, or the name of a choice.
    ///
    /// ```
    /// use scumble::Value;
    ///
    /// assert_eq!(Value::Vector(vec![0.5, 1.0]).to_json().to_string(), "[0.5,1.0]");
    /// ```
    pub fn to_json(&self) -> Json {
        match self {
            Self::Bool(value) => json!(value),
            Self::Int(value) => json!(value),
            Self::Float(value) => number(*value),
            Self::Vector(values) => values.iter().map(|value| number(*value)).collect(),
            Self::Choice(name) => json!(name),
        }
    }
}

impl ParamDef {
    /// The JSON Schema of the parameter's value as a graph file writes it. Beside the standard keys,
    /// `x-unit` is the unit, and `x-structural` says that a change rebuilds the pass.
    ///
    /// ```
    /// scumble::params! {
    ///     /// Of a blur.
    ///     pub struct BlurParams {
    ///         /// Distance of the taps.
    ///         pub radius: u32 = 2, in 1..=16, unit "px";
    ///     }
    /// }
    ///
    /// use scumble::Params;
    /// let schema = BlurParams::defs()[0].schema();
    /// assert_eq!(schema["type"], "integer");
    /// assert_eq!((&schema["minimum"], &schema["maximum"]), (&1.into(), &16.into()));
    /// ```
    pub fn schema(&self) -> Json {
        let mut schema = match self.kind {
            ParamKind::Bool => json!({"type": "boolean"}),
            ParamKind::Int { signed } => {
                let (low, high) = match signed {
                    true => (i64::from(i32::MIN), i64::from(i32::MAX)),
                    false => (0, i64::from(u32::MAX)),
                };
                let (low, high) = self.range.map_or((low, high), |(a, b)| {
                    (low.max(a.ceil() as i64), high.min(b.floor() as i64))
                });
                json!({"type": "integer", "minimum": low, "maximum": high})
            }
            ParamKind::Float => self.number_schema(),
            ParamKind::Vector(n) => json!({
                "type": "array",
                "items": self.number_schema(),
                "minItems": n,
                "maxItems": n,
            }),
            ParamKind::Choice(choices) => {
                let each = choices
                    .iter()
                    .map(|(name, about)| json!({"const": name, "description": about}));
                json!({"oneOf": each.collect::<Vec<_>>()})
            }
        };
        schema["description"] = json!(self.about);
        schema["default"] = self.default.to_json();
        schema["x-structural"] = json!(self.structural);
        if let Some(unit) = self.unit {
            schema["x-unit"] = json!(unit);
        }
        schema
    }

    fn number_schema(&self) -> Json {
        let mut schema = json!({"type": "number"});
        if let Some((low, high)) = self.range {
            for (key, bound) in [("minimum", low), ("maximum", high)] {
                if bound.is_finite() {
                    schema[key] = number(bound);
                }
            }
        }
        schema
    }

    /// The JSON Schema of the `with` of a pass that has these parameters.
    pub fn schema_of(defs: &[ParamDef]) -> Json {
        let properties: Map<String, Json> = defs
            .iter()
            .map(|def| (def.name.to_owned(), def.schema()))
            .collect();
        json!({
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            "type": "object",
            "additionalProperties": false,
            "properties": properties,
        })
    }
}

// Parameters are f32: the shortest decimal that gives the same f32, so 0.1 and not 0.10000000149.
fn number(value: f64) -> Json {
    let shortest = format!("{:?}", value as f32).parse::<f64>();
    json!(shortest.unwrap_or(value))
}

#[cfg(test)]
mod tests {
    use crate::{ParamDef, Params};
    use serde_json::json;

    crate::choice! {
        /// How.
        pub enum Mode {
            /// By distance.
            #[default]
            Near,
            /// By time.
            Fresh,
        }
    }

    crate::params! {
        /// One of each kind.
        pub struct AllKinds {
            /// A truth.
            pub on: bool = true;
            /// A count.
            #[structural]
            pub count: u32 = 3, in 1..=16, unit "px";
            /// An offset.
            pub offset: i32 = -1;
            /// A weight.
            pub weight: f32 = 0.1, in 0.0..=1.0;
            /// An angle.
            pub cone: f32 = 45.0, in 0.0..=90.0, unit "deg";
            /// A colour.
            pub tint: [f32; 3] = [1.0, 0.5, 0.1];
            /// A choice.
            pub mode: Mode = Mode::Fresh;
        }
    }

    #[test]
    fn every_kind_has_its_schema() {
        let properties = ParamDef::schema_of(AllKinds::defs());
        assert_eq!(properties["additionalProperties"], false);
        let properties = &properties["properties"];
        for (name, expected) in [
            (
                "on",
                json!({"type": "boolean", "default": true, "description": "A truth.", "x-structural": false}),
            ),
            (
                "count",
                json!({"type": "integer", "minimum": 1, "maximum": 16, "default": 3,
                    "description": "A count.", "x-structural": true, "x-unit": "px"}),
            ),
            (
                "offset",
                json!({"type": "integer", "minimum": i32::MIN, "maximum": i32::MAX, "default": -1,
                    "description": "An offset.", "x-structural": false}),
            ),
            (
                "weight",
                json!({"type": "number", "minimum": 0.0, "maximum": 1.0, "default": 0.1,
                    "description": "A weight.", "x-structural": false}),
            ),
            (
                "cone",
                json!({"type": "number", "minimum": 0.0, "maximum": 90.0, "default": 45.0,
                    "description": "An angle.", "x-structural": false, "x-unit": "deg"}),
            ),
            (
                "tint",
                json!({"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3,
                    "default": [1.0, 0.5, 0.1], "description": "A colour.", "x-structural": false}),
            ),
            (
                "mode",
                json!({"oneOf": [{"const": "Near", "description": "By distance."},
                        {"const": "Fresh", "description": "By time."}],
                    "default": "Fresh", "description": "A choice.", "x-structural": false}),
            ),
        ] {
            assert_eq!(properties[name], expected, "{name}");
        }
    }
}
