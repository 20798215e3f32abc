//! Members of `Params` and the comments beside them: parameters.

use std::sync::Mutex;

use framegraph::{BindingKind, Member, MemberType, Reflection, Scalar};

use super::interned;
use super::mistake::{Mistake, wrong};
use super::scan::{Scanned, Text};
use crate::context::PassInfo;
use crate::kernel_plan::{Fill, fill_of};
use crate::params::{ParamDef, ParamKind, Value};

pub(super) const PARAM_HELP: &str = "write `// DEFAULT in MIN..MAX, UNIT; what it is` beside it, or `// NAME of NAME | NAME; what it is` for a choice";

/// The parameters that the uniforms of the shader ask for.
pub(super) fn params(
    scanned: &Scanned<'_>,
    reflection: &Reflection,
    info: &PassInfo,
    mistakes: &mut Vec<Mistake>,
) -> Vec<ParamDef> {
    let mut defs: Vec<ParamDef> = Vec::new();
    for binding in reflection.bindings.iter().filter(|b| b.group == 0) {
        let BindingKind::Uniform(layout) = &binding.kind else {
            continue;
        };
        for member in &layout.members {
            let line = scanned.members.iter().find(|m| m.name.text == member.name);
            let comment = line.and_then(|line| line.comment.as_ref());
            let fill = match fill_of(member, info) {
                Ok(fill) => fill,
                Err(message) => {
                    mistakes.push(Mistake {
                        message,
                        at: scanned.place(&member.name),
                        help: String::new(),
                    });
                    continue;
                }
            };
            match (fill != Fill::ByHand, comment) {
                (true, None) => {}
                // A remark is welcome; what reads as a parameter would never get its value.
                (true, Some(comment)) => {
                    if param(member, comment).is_ok() {
                        let message = format!("`{}` is what every shader can ask for", member.name);
                        let help = "give the parameter another name";
                        mistakes.push(wrong(&message, &comment.span, help));
                    }
                }
                (false, None) => {
                    let message = format!(
                        "nothing fills the member `{}`, and it has no default",
                        member.name
                    );
                    mistakes.push(Mistake {
                        message,
                        at: scanned.place(&member.name),
                        help: PARAM_HELP.to_owned(),
                    });
                }
                (false, Some(comment)) => match param(member, comment) {
                    Ok(def) => defs.push(def),
                    Err(mistake) => mistakes.push(mistake),
                },
            }
        }
    }
    defs
}

/// `DEFAULT in MIN..MAX, UNIT; about` or `DEFAULT of NAME | NAME; about`
fn param(member: &Member, comment: &Text<'_>) -> Result<ParamDef, Mistake> {
    let wrong = |what: &str| {
        let message = format!("the parameter `{}` {what}", member.name);
        wrong(&message, &comment.span, PARAM_HELP)
    };
    let (stated, about) = comment.text.split_once(';').unwrap_or((comment.text, ""));
    // A vector's default has commas of its own.
    let end = match stated.starts_with('(') {
        true => stated.find(')').map(|i| i + 1),
        false => stated.find([',', ' ']),
    };
    let end = end.unwrap_or(stated.len());
    let (default, rest) = stated.split_at(end);
    let (range, unit) = rest.split_once(',').unwrap_or((rest, ""));
    let (mut range_stated, mut choices) = (None, None);
    match range.trim().split_once(' ') {
        None if range.trim().is_empty() => {}
        Some(("in", range)) => range_stated = Some(range),
        Some(("of", names)) => choices = Some(names),
        _ => return Err(wrong("has something between its default and its unit")),
    }
    let (kind, default) = match choices {
        Some(names) => choice(&member.ty, default.trim(), names),
        None => value(&member.ty, default.trim()),
    }
    .ok_or_else(|| wrong(&format!("has no default of its type, {}", ty(&member.ty))))?;
    let range = match range_stated {
        None => None,
        Some(range) => {
            let (low, high) = range
                .split_once("..")
                .ok_or_else(|| wrong("has a range without `..`"))?;
            let bound = |text: &str| text.trim().trim_start_matches('=').parse::<f64>().ok();
            let both = bound(low)
                .zip(bound(high))
                .filter(|(low, high)| low <= high);
            Some(both.ok_or_else(|| wrong("has a range that is none"))?)
        }
    };
    let unit = Some(unit.trim())
        .filter(|unit| !unit.is_empty())
        .map(interned);
    let def = ParamDef {
        name: interned(&member.name),
        about: interned(about.trim()),
        kind,
        default,
        range,
        unit,
        structural: false,
        budget: false,
    };
    match def.check(&def.default) {
        Ok(()) => Ok(def),
        Err(e) => Err(super::mistake::wrong(
            &e.to_string(),
            &comment.span,
            PARAM_HELP,
        )),
    }
}

/// What a default of this type looks like.
fn ty(ty: &MemberType) -> &'static str {
    match ty {
        MemberType::U32 => "u32: an integer, `true`, `false`, or one `of` several names",
        MemberType::I32 => "i32: an integer",
        MemberType::F32 => "f32: a number",
        MemberType::Vec {
            scalar: Scalar::F32,
            ..
        } => "a vector: numbers in parentheses",
        _ => "which no parameter has: those are f32, i32, u32 and vectors of f32",
    }
}

fn value(ty: &MemberType, text: &str) -> Option<(ParamKind, Value)> {
    Some(match (ty, text) {
        (MemberType::U32, "true" | "false") => (ParamKind::Bool, Value::Bool(text == "true")),
        (MemberType::U32, _) => (
            ParamKind::Int { signed: false },
            Value::Int(text.parse().ok()?),
        ),
        (MemberType::I32, _) => (
            ParamKind::Int { signed: true },
            Value::Int(text.parse().ok()?),
        ),
        (MemberType::F32, _) => (ParamKind::Float, Value::Float(text.parse().ok()?)),
        (
            MemberType::Vec {
                n,
                scalar: Scalar::F32,
            },
            _,
        ) => {
            let inside = text.strip_prefix('(')?.strip_suffix(')')?;
            let values: Option<Vec<f64>> =
                inside.split(',').map(|x| x.trim().parse().ok()).collect();
            (ParamKind::Vector(*n as usize), Value::Vector(values?))
        }
        _ => return None,
    })
}

/// In the shader a choice is its position in the list, from 0.
fn choice(ty: &MemberType, default: &str, names: &str) -> Option<(ParamKind, Value)> {
    let names: Vec<&str> = names.split('|').map(str::trim).collect();
    let is_name = |name: &&str| {
        let mut letters = name.chars();
        letters.next().is_some_and(char::is_alphabetic)
            && letters.all(|c| c.is_alphanumeric() || c == '_')
    };
    if *ty != MemberType::U32 || !names.iter().all(is_name) {
        return None;
    }
    let kind = ParamKind::Choice(kept(&names));
    Some((kind, Value::Choice(default.to_owned())))
}

/// The choices for as long as the program runs, each list once, as [`interned`].
fn kept(names: &[&str]) -> &'static [(&'static str, &'static str)] {
    type Choices = &'static [(&'static str, &'static str)];
    static ALL: Mutex<Vec<Choices>> = Mutex::new(Vec::new());
    let mut all = ALL
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    let same = |known: &&Choices| {
        known
            .iter()
            .map(|(name, _)| *name)
            .eq(names.iter().copied())
    };
    if let Some(found) = all.iter().find(same) {
        return found;
    }
    let choices: Vec<_> = names.iter().map(|name| (interned(name), "")).collect();
    let choices: Choices = Box::leak(choices.into_boxed_slice());
    all.push(choices);
    choices
}
