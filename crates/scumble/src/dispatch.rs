//! One dispatch of a pass: everything bound by name, with what the pass gives by hand in front.

use std::sync::Arc;

use framegraph::{Buffer, ComputeKernel, ComputeNode, Size, Texture, View};

use crate::diagnostics::hint;
use crate::frame_state::Side;
use crate::kernel_plan::{Fill, KernelPlan, Source, UniformPlan, builtin_value, member_hint};
use crate::pass_frame::{PassFrame, RecordError};
use crate::uniform::{UniformValue, wgsl_member_type};

/// One dispatch; see [`PassFrame::dispatch`]. Nothing happens before [`Dispatch::over`],
/// [`Dispatch::workgroups`] or [`Dispatch::indirect`].
#[must_use = "end it with `over`, `workgroups` or `indirect`"]
pub struct Dispatch<'d, 'a, 'f> {
    node: ComputeNode<'d, 'f>,
    side: &'d mut Side<'a, 'f>,
    plan: Option<Arc<KernelPlan>>,
    /// Bindings given by hand: index into the plan's.
    bound: Vec<bool>,
    /// Members given by hand: index of the uniform's binding and of the member.
    set: Vec<((usize, usize), UniformValue)>,
    mistake: Option<RecordError>,
}

impl<'d, 'a, 'f> Dispatch<'d, 'a, 'f> {
    #[track_caller]
    pub(crate) fn new(
        frame: &'d mut PassFrame<'a, 'f>,
        label: &'static str,
        kernel: &'d ComputeKernel,
    ) -> Self {
        let PassFrame { graph, side } = frame;
        let (plan, mistake) = match side.plan(kernel) {
            Ok(plan) => (Some(plan), None),
            Err(error) => (None, Some(error.into())),
        };
        // All textures are made before the node borrows the graph.
        for slot in plan.iter().flat_map(|plan| &plan.bindings) {
            match slot.source {
                Source::Input(i, format) if side.inputs[i].is_none() => {
                    side.stand_ins.get(graph, side.device, format);
                }
                Source::Output(i, _) if is_dummy(side, i) => {
                    let desc = side
                        .info
                        .desc_of(&side.info.outputs[i], Size::Absolute([1, 1]));
                    let dummy = &mut side.outputs[i].dummy;
                    dummy.get_or_insert_with(|| graph.texture("unread output", desc));
                }
                Source::Output(i, _) => {
                    side.output(graph, i);
                }
                _ => {}
            }
        }
        let bound = vec![false; plan.as_ref().map_or(0, |plan| plan.bindings.len())];
        let label = side.label(label);
        Dispatch {
            node: graph.compute(label, kernel),
            side,
            plan,
            bound,
            set: Vec::new(),
            mistake,
        }
    }

    /// The shader reads this texture, or this part of it.
    #[track_caller]
    pub fn texture(mut self, binding: &str, texture: impl Into<View>) -> Self {
        self.by_hand(binding);
        self.node.read(binding, texture);
        self
    }

    /// The shader writes every texel of this texture that lives; gives its next version.
    #[track_caller]
    pub fn write(mut self, binding: &str, texture: impl Into<View>) -> (Self, Texture) {
        self.by_hand(binding);
        let next = self.node.overwrite(binding, texture);
        (self, next)
    }

    /// The shader writes some texels of this texture, or reads and writes it; gives its next version.
    #[track_caller]
    pub fn modify(mut self, binding: &str, texture: impl Into<View>) -> (Self, Texture) {
        self.by_hand(binding);
        let next = self.node.modify(binding, texture);
        (self, next)
    }

    /// The shader reads this buffer.
    #[track_caller]
    pub fn buffer(mut self, binding: &str, buffer: Buffer) -> Self {
        self.by_hand(binding);
        self.node.read_buffer(binding, buffer);
        self
    }

    /// The shader writes all of this buffer; gives its next version.
    #[track_caller]
    pub fn write_buffer(mut self, binding: &str, buffer: Buffer) -> (Self, Buffer) {
        self.by_hand(binding);
        let next = self.node.overwrite_buffer(binding, buffer);
        (self, next)
    }

    /// The shader reads and writes this buffer, or writes some of it; gives its next version.
    #[track_caller]
    pub fn modify_buffer(mut self, binding: &str, buffer: Buffer) -> (Self, Buffer) {
        self.by_hand(binding);
        let next = self.node.modify_buffer(binding, buffer);
        (self, next)
    }

    /// A sampler other than the clamping linear one (nearest, for a name with `nearest` in it).
    #[track_caller]
    pub fn sampler(mut self, binding: &str, desc: &wgpu::SamplerDescriptor<'_>) -> Self {
        self.by_hand(binding);
        self.node.sampler(binding, desc);
        self
    }

    /// A hand-made bind group, such as a scene's.
    #[track_caller]
    pub fn group(mut self, index: u32, group: &wgpu::BindGroup) -> Self {
        self.node.bind_group(index, group);
        self
    }

    /// A member of `params` that no parameter and no built-in fills, or another value for one of theirs.
    pub fn set(mut self, member: &str, value: impl Into<UniformValue>) -> Self {
        let (Some(plan), value) = (self.plan.clone(), value.into()) else {
            return self;
        };
        let mut unknown = None;
        for (i, slot) in plan.bindings.iter().enumerate() {
            let Source::Uniform(uniform) = &slot.source else {
                continue;
            };
            match settable(uniform, plan.file(), member, &value) {
                Ok(m) => {
                    self.set.push(((i, m), value));
                    return self;
                }
                Err(error) => unknown = Some(error),
            }
        }
        let none = || RecordError::Set {
            file: plan.file().to_owned(),
            message: format!("`set(\"{member}\", …)` on a kernel that uses no uniform"),
        };
        self.fail(unknown.unwrap_or_else(none));
        self
    }

    /// Keeps the dispatch from culling, for a reason that the plan shows.
    pub fn side_effect(mut self, reason: &'static str) -> Self {
        self.node.side_effect(reason);
        self
    }

    /// Dispatches one thread per texel of an image of this size.
    ///
    /// # Errors
    /// A member or a binding that nothing fills, and mistakes of the calls before.
    #[track_caller]
    pub fn over(mut self, size: [u32; 2]) -> Result<(), RecordError> {
        self.bind_the_rest()?;
        self.node.dispatch_texels(size);
        Ok(())
    }

    /// Dispatches so many workgroups.
    ///
    /// # Errors
    /// See [`Dispatch::over`].
    #[track_caller]
    pub fn workgroups(mut self, count: [u32; 3]) -> Result<(), RecordError> {
        self.bind_the_rest()?;
        self.node.dispatch(count);
        Ok(())
    }

    /// Dispatches as many workgroups as three `u32` at byte `offset` of `arguments` say.
    ///
    /// # Errors
    /// See [`Dispatch::over`].
    #[track_caller]
    pub fn indirect(mut self, arguments: Buffer, offset: u64) -> Result<(), RecordError> {
        self.bind_the_rest()?;
        self.node.dispatch_indirect(arguments, offset);
        Ok(())
    }

    fn fail(&mut self, error: RecordError) {
        self.mistake.get_or_insert(error);
    }

    /// Takes a binding out of what is bound by name. The graph reports a name that is none.
    fn by_hand(&mut self, binding: &str) {
        let slots = self.plan.iter().flat_map(|plan| &plan.bindings);
        if let Some(i) = slots.into_iter().position(|slot| slot.name == binding) {
            self.bound[i] = true;
        }
    }

    #[track_caller]
    fn bind_the_rest(&mut self) -> Result<(), RecordError> {
        if let Some(mistake) = self.mistake.take() {
            return Err(mistake);
        }
        let Some(plan) = self.plan.clone() else {
            return Ok(());
        };
        for (i, slot) in plan.bindings.iter().enumerate() {
            if self.bound[i] {
                continue;
            }
            let name = slot.name.as_str();
            match &slot.source {
                Source::Input(input, format) => {
                    let texture =
                        self.side.inputs[*input].or_else(|| self.side.stand_ins.imported(*format));
                    if let Some(texture) = texture {
                        self.node.read(name, texture);
                    }
                }
                Source::Output(output, reads) => self.bind_output(name, *output, *reads),
                Source::Sampler { linear } => {
                    let filter = if *linear {
                        wgpu::FilterMode::Linear
                    } else {
                        wgpu::FilterMode::Nearest
                    };
                    let desc = wgpu::SamplerDescriptor {
                        mag_filter: filter,
                        min_filter: filter,
                        ..Default::default()
                    };
                    self.node.sampler(name, &desc);
                }
                Source::Uniform(uniform) => {
                    let own = self.set.iter().filter(|((binding, _), _)| *binding == i);
                    let own: Vec<_> = own.map(|((_, member), value)| (*member, *value)).collect();
                    let bytes = self.side.uniform_bytes(uniform, plan.file(), name, &own)?;
                    self.node.uniform(name, &bytes);
                }
                Source::ByHand => {
                    let info = self.side.info;
                    let outputs: Vec<String> = info
                        .outputs
                        .iter()
                        .map(|p| format!("out_{}", p.name))
                        .collect();
                    let ports = info
                        .inputs
                        .iter()
                        .map(|p| p.name)
                        .chain(outputs.iter().map(String::as_str));
                    let hint = hint(name, ports);
                    return Err(RecordError::Unbound {
                        file: plan.file().into(),
                        binding: name.into(),
                        hint,
                    });
                }
            }
        }
        Ok(())
    }

    #[track_caller]
    fn bind_output(&mut self, name: &str, i: usize, reads: bool) {
        let dummy = is_dummy(self.side, i);
        let slot = &mut self.side.outputs[i];
        let Some(texture) = (if dummy { slot.dummy } else { slot.texture }) else {
            return;
        };
        // The first write is the only one that may forget what was there.
        if dummy {
            slot.dummy = Some(self.node.overwrite(name, texture));
        } else {
            let next = match reads || slot.written {
                true => self.node.modify(name, texture),
                false => self.node.overwrite(name, texture),
            };
            slot.set(next, false);
        }
    }
}

/// Whether a dispatch writes an output to a stand-in: it is optional, nobody reads it, and the pass did not ask for it.
fn is_dummy(side: &Side<'_, '_>, i: usize) -> bool {
    let slot = &side.outputs[i];
    side.info.outputs[i].optional && !slot.wanted && slot.texture.is_none()
}

/// The member that `set` means.
pub(crate) fn settable(
    plan: &UniformPlan,
    file: &str,
    member: &str,
    value: &UniformValue,
) -> Result<usize, RecordError> {
    let error = |message| RecordError::Set {
        file: file.to_owned(),
        message,
    };
    let Some(i) = plan.members.iter().position(|m| m.member.name == member) else {
        let hint = hint(member, plan.members.iter().map(|m| m.member.name.as_str()));
        return Err(error(format!(
            "`set` names `{member}`, which the uniform does not have{hint}"
        )));
    };
    let ty = &plan.members[i].member.ty;
    if !value.fits(ty) {
        let (ty, given) = (wgsl_member_type(ty), value.wgsl_type());
        return Err(error(format!(
            "`set` gives a {given} to `{member}`, which is {ty}"
        )));
    }
    Ok(i)
}

impl Side<'_, '_> {
    /// Fills a uniform; `set` holds members given by hand.
    pub(crate) fn uniform_bytes(
        &self,
        plan: &UniformPlan,
        file: &str,
        binding: &str,
        set: &[(usize, UniformValue)],
    ) -> Result<Vec<u8>, RecordError> {
        let mut bytes = vec![0; plan.size as usize];
        for (i, m) in plan.members.iter().enumerate() {
            let by_hand = set
                .iter()
                .rev()
                .find(|(member, _)| *member == i)
                .map(|(_, value)| *value);
            let value = match (by_hand, m.fill) {
                (Some(value), _) => Some(value),
                (None, Fill::Param(p)) => {
                    let def = &self.info.defs[p];
                    self.params
                        .get(def.name)
                        .and_then(|value| UniformValue::of_param(def, &value))
                }
                (None, Fill::Builtin(builtin)) => {
                    Some(builtin_value(builtin, self.info, self.shared))
                }
                (None, Fill::Has(input)) => Some(self.inputs[input].is_some().into()),
                (None, Fill::Wants(output)) => Some(self.outputs[output].wanted.into()),
                (None, Fill::ByHand) => None,
            };
            let Some(value) = value else {
                let (member, hint) = (
                    m.member.name.clone(),
                    member_hint(&m.member.name, self.info),
                );
                return Err(RecordError::Unfilled {
                    file: file.into(),
                    binding: binding.into(),
                    member,
                    hint,
                });
            };
            value.put(&mut bytes, m.member.offset);
        }
        Ok(bytes)
    }
}
