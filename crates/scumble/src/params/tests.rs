use super::*;

crate::choice! {
    /// Depth term of the weight.
    pub enum DepthTerm {
        /// (z_p/z_q - 1)².
        #[default]
        Ratio,
        /// ln(z_p/z_q)².
        Log,
    }
}

crate::params! {
    /// One of each kind.
    pub struct Sample {
        /// First line,
        /// second line.
        pub lambda: f32 = 1.5, in 0.0..=100.0, unit "1/px";
        /// On or off.
        pub include: bool = true;
        /// Cells.
        #[structural]
        pub spacing: u32 = 16, in 1..=1024, unit "px";
        /// Offset.
        pub shift: i32 = -2;
        /// Opening.
        pub cone: f32 = 90.0, in 0.0..=90.0, unit "deg";
        /// Which.
        pub term: DepthTerm = DepthTerm::Log;
        /// Colour.
        pub tint: [f32; 3] = [1.0, 0.5, 0.25], in 0.0..=1.0;
        /// Paths.
        #[budget]
        pub samples: u32 = 1, in 1..=65536, unit "spp";
    }
}

#[test]
fn one_definition_gives_everything() {
    let def = &Sample::defs()[0];
    assert_eq!(def.about, "First line, second line.");
    assert_eq!(def.range, Some((0.0, 100.0)));
    assert_eq!(def.unit, Some("1/px"));
    let flags: Vec<_> = Sample::defs()
        .iter()
        .map(|def| (def.structural, def.budget))
        .collect();
    assert_eq!(flags[2], (true, false));
    assert_eq!(flags[7], (false, true));
    assert_eq!(flags.iter().filter(|f| **f != (false, false)).count(), 2);
    let ParamKind::Choice(choices) = Sample::defs()[5].kind else {
        panic!("a choice");
    };
    assert_eq!(choices[1], ("Log", "ln(z_p/z_q)²."));
}

#[test]
fn defaults_are_valid_and_come_back_as_written() {
    let params = ErasedParams::new(Sample::default());
    for (def, value) in params.written() {
        assert_eq!(def.check(&value), Ok(()), "{}", def.name);
        assert_eq!(value, def.default, "{}", def.name);
    }
}

#[test]
fn angles_are_degrees_outside_and_radians_inside() {
    let mut params = Sample::default();
    assert_eq!(params.cone, std::f32::consts::FRAC_PI_2);
    let def = &Sample::defs()[4];
    params.set("cone", &def.stored(&Value::Int(60))).unwrap();
    assert_eq!(params.cone, 60f32.to_radians());
    let error = params.set("cone", &def.stored(&Value::Int(91)));
    assert_eq!(
        error.unwrap_err().to_string(),
        "`cone` must be from 0 to 90 deg, and got 91.0"
    );
}

#[test]
fn each_wrong_value_is_refused_and_leaves_the_old_one() {
    let mut params = Sample::default();
    let wrong = [
        ("lambda", Value::Float(-0.1)),
        ("lambda", Value::Float(f64::NAN)),
        ("lambda", Value::Bool(true)),
        ("include", Value::Int(1)),
        ("spacing", Value::Int(0)),
        ("spacing", Value::Int(-1)),
        ("spacing", Value::Float(4.0)),
        ("shift", Value::Int(1 << 40)),
        ("term", Value::Choice("Logg".into())),
        ("tint", Value::Vector(vec![0.0, 1.0])),
        ("tint", Value::Vector(vec![0.0, 1.0, 1.5])),
        ("tintt", Value::Bool(true)),
    ];
    for (name, value) in wrong {
        assert!(params.set(name, &value).is_err(), "{name} = {value}");
    }
    assert_eq!(params, Sample::default());
}

#[test]
fn an_unknown_name_or_choice_gets_the_nearest() {
    let mut params = Sample::default();
    let unknown = params.set("samplse", &Value::Int(1)).unwrap_err();
    assert_eq!(
        unknown,
        ParamError::Unknown {
            name: "samplse".into(),
            nearest: Some("samples".into())
        }
    );
    let choice = params.set("term", &Value::Choice("log".into()));
    let ParamError::Choice { nearest, .. } = choice.unwrap_err() else {
        panic!("a choice error");
    };
    assert_eq!(nearest.as_deref(), Some("Log"));
}

#[test]
fn run_time_definitions_behave_like_a_struct() {
    let mut typed = ErasedParams::new(Sample::default());
    let mut dynamic = ErasedParams::dynamic(Sample::defs());
    assert_eq!(typed, dynamic);
    for params in [&mut typed, &mut dynamic] {
        params.set("spacing", &Value::Int(8)).unwrap();
        params.set("lambda", &Value::Int(3)).unwrap();
    }
    assert_eq!(typed, dynamic);
    assert_eq!(dynamic.get("lambda"), Some(Value::Float(3.0)));
    assert_ne!(typed, ErasedParams::new(Sample::default()));
}
