//! A frame declared to the graph.

use std::collections::HashMap;

use framegraph::*;

use crate::frame::{Frame, Job, Node, Resource, Role, Shape, StandIn, Use};
use crate::kernels::{In, Kernels, LOOKERS, Out, WRITERS};
use crate::model::uploaded;
use crate::program::Rule;

#[derive(Clone, Copy)]
pub enum Handle {
    Texture(Texture),
    Buffer(Buffer),
}

/// The latest handle of each resource.
pub type Handles = HashMap<usize, Handle>;

impl Handle {
    pub fn texture(self) -> Texture {
        match self {
            Handle::Texture(texture) => texture,
            Handle::Buffer(_) => panic!("a texture is asked for"),
        }
    }

    pub fn buffer(self) -> Buffer {
        match self {
            Handle::Buffer(buffer) => buffer,
            Handle::Texture(_) => panic!("a buffer is asked for"),
        }
    }
}

/// An import as the engine has it.
pub enum Real {
    Texture(wgpu::Texture),
    Buffer(wgpu::Buffer),
}

/// What lives outside the graph.
pub struct Outside<'a> {
    pub kernels: &'a Kernels,
    pub imports: &'a [Real],
    /// What lookers leave what they saw in.
    pub observed: &'a wgpu::BindGroup,
}

pub fn desc(shape: Shape) -> TextureDesc {
    let Shape::Texture { size, mips, layers } = shape else {
        panic!("a texture is asked for");
    };
    TextureDesc::d2(wgpu::TextureFormat::R32Uint, Size::Absolute(size))
        .with_mips(mips)
        .with_layers(layers)
}

fn bytes(shape: Shape) -> u64 {
    4 * u64::from(shape.words().unwrap_or(0))
}

/// Declares the whole frame.
pub fn declare<'f>(
    mut fg: FrameGraph<'f>,
    frame: &Frame,
    outside: &Outside<'_>,
) -> (FrameGraph<'f>, Handles) {
    let mut handles = Handles::new();
    for (i, r) in frame.resources.iter().enumerate() {
        if let Some(handle) = begin(&mut fg, r, outside) {
            handles.insert(i, handle);
        }
    }
    for node in &frame.nodes[..frame.sources] {
        record(&mut fg, frame, node, &mut handles, outside);
    }
    for h in &frame.histories {
        let shape = frame.resources[h.current].shape;
        let source = h.source.map(|s| handles[&s]);
        match shape {
            Shape::Texture { .. } => {
                let first = match (h.first, source) {
                    (Rule::Copy, Some(source)) => First::Copy(source.texture()),
                    (Rule::Skip, _) => First::Skip,
                    _ => First::Clear([h.value.into(); 4]),
                };
                let made = fg.history_texture(&h.key, desc(shape), h.frames, first);
                handles.insert(h.current, Handle::Texture(made.current));
                for (i, t) in h.previous.iter().zip(made.previous) {
                    assert_eq!(i.is_some(), t.is_some(), "what is skipped");
                    handles.extend(i.zip(t.map(Handle::Texture)));
                }
            }
            Shape::Buffer { .. } => {
                let first = match (h.first, source) {
                    (Rule::Copy, Some(source)) => FirstBuffer::Copy(source.buffer()),
                    (Rule::Skip, _) => FirstBuffer::Skip,
                    _ => FirstBuffer::Fill(h.value),
                };
                let made = fg.history_buffer(&h.key, bytes(shape), h.frames, first);
                handles.insert(h.current, Handle::Buffer(made.current));
                for (i, b) in h.previous.iter().zip(made.previous) {
                    assert_eq!(i.is_some(), b.is_some(), "what is skipped");
                    handles.extend(i.zip(b.map(Handle::Buffer)));
                }
            }
        }
    }
    for node in frame.nodes[frame.sources..].iter().filter(|n| !n.implicit) {
        record(&mut fg, frame, node, &mut handles, outside);
    }
    for &i in &frame.exports {
        let key = &frame.resources[i].name;
        match handles[&i] {
            Handle::Texture(texture) => fg.export_texture(key, texture),
            Handle::Buffer(buffer) => fg.export_buffer(key, buffer),
        }
    }
    (fg, handles)
}

/// Transients and imports; histories come later.
fn begin(fg: &mut FrameGraph<'_>, r: &Resource, outside: &Outside<'_>) -> Option<Handle> {
    Some(match (r.role, r.shape) {
        (Role::Transient, Shape::Texture { .. }) => {
            Handle::Texture(fg.texture(&r.name, desc(r.shape)))
        }
        (Role::Transient, Shape::Buffer { .. }) => {
            Handle::Buffer(fg.buffer(&r.name, bytes(r.shape)))
        }
        (Role::Import(i), _) => match &outside.imports[i] {
            Real::Texture(texture) => Handle::Texture(fg.import_texture(&r.name, texture)),
            Real::Buffer(buffer) => Handle::Buffer(fg.import_buffer(&r.name, buffer)),
        },
        _ => return None,
    })
}

fn view(frame: &Frame, texture: Texture, u: &Use) -> View {
    let r = u.range;
    let view = View::from(texture);
    // Said as a whole where it is the whole.
    if r == frame.resources[u.resource].shape.whole() {
        return view;
    }
    view.mips(r.mip..r.mip + r.mips)
        .layers(r.layer..r.layer + r.layers)
}

/// Switches a node, and names what stands in; each builder has the same methods.
macro_rules! switch {
    ($builder:expr, $node:expr, $handles:expr, $made:expr) => {
        if let Some(on) = $node.switch {
            $builder.enabled_if(on);
        }
        for &(of, what) in &$node.stand_ins {
            // Not the latest of the resource, which another output of the node may have made.
            let made: &[(usize, Handle)] = $made;
            let output = made.iter().find(|m| m.0 == of).map(|m| m.1);
            match (what, output.expect("what stands in is for an output")) {
                (StandIn::Clear(value), Handle::Texture(t)) => {
                    $builder.or_clear(t, [value.into(); 4]);
                }
                (StandIn::Fill(word), Handle::Buffer(b)) => {
                    $builder.or_fill(b, word);
                }
                (StandIn::Use(from), Handle::Texture(t)) => {
                    $builder.or_use(t, $handles[&from].texture());
                }
                (StandIn::Use(from), Handle::Buffer(b)) => {
                    $builder.or_use_buffer(b, $handles[&from].buffer());
                }
                (what, _) => panic!("{what:?} is for the other kind"),
            }
        }
    };
}

fn record<'f>(
    fg: &mut FrameGraph<'f>,
    frame: &Frame,
    node: &Node,
    handles: &mut Handles,
    outside: &Outside<'_>,
) {
    let kernels = outside.kernels;
    let texture = |handles: &Handles, i: usize| handles[&node.uses[i].resource].texture();
    let buffer = |handles: &Handles, i: usize| handles[&node.uses[i].resource].buffer();
    let at = |handles: &Handles, i: usize| view(frame, texture(handles, i), &node.uses[i]);
    let next = |handles: &mut Handles, i: usize, handle: Handle| {
        handles.insert(node.uses[i].resource, handle);
    };
    let name = &node.name;
    match node.job {
        Job::Writer(row) => {
            let s = &WRITERS[row];
            let mut n = fg.compute(name, &kernels.writers[row]);
            n.uniform("params", &params(node, 0));
            bind_inputs(&mut n, frame, node, s.inputs, handles);
            let (mut most, mut made) = ([0, 0], Vec::new());
            for (o, output) in s.outputs.iter().enumerate() {
                let (i, binding) = (s.inputs.len() + o, format!("out{o}"));
                let u = &node.uses[i];
                let handle = match (output, u.mode) {
                    (Out::Buffer | Out::BufferPart | Out::BufferUpdate, Mode::Overwrite) => {
                        Handle::Buffer(n.overwrite_buffer(&binding, buffer(handles, i)))
                    }
                    (Out::Buffer | Out::BufferPart | Out::BufferUpdate, _) => {
                        Handle::Buffer(n.modify_buffer(&binding, buffer(handles, i)))
                    }
                    (_, Mode::Overwrite) => Handle::Texture(n.overwrite(&binding, at(handles, i))),
                    _ => Handle::Texture(n.modify(&binding, at(handles, i))),
                };
                next(handles, i, handle);
                made.push((i, handle));
                let [w, h] = frame.resources[u.resource].shape.mip_size(u.range.mip);
                most = [most[0].max(w), most[1].max(h)];
            }
            switch!(n, node, handles, &made);
            n.dispatch_texels(most);
        }
        Job::Looker(row, place) => {
            let mut n = fg.compute(name, &kernels.lookers[row]);
            n.uniform("params", &params(node, place))
                .bind_group(1, outside.observed)
                .side_effect("looks");
            bind_inputs(&mut n, frame, node, LOOKERS[row].inputs, handles);
            switch!(n, node, handles, &[]);
            n.dispatch([1, 1, 1]);
        }
        Job::Arguments => {
            let mut n = fg.compute(name, &kernels.arguments);
            n.uniform("params", &params(node, 0));
            let b = n.overwrite_buffer("out0", buffer(handles, 0));
            n.dispatch([1, 1, 1]);
            next(handles, 0, Handle::Buffer(b));
        }
        Job::Indirect => {
            let mut n = fg.compute(name, &kernels.indirect);
            n.uniform("params", &params(node, 0));
            let b = n.modify_buffer("out0", buffer(handles, 0));
            switch!(n, node, handles, &[]);
            n.dispatch_indirect(buffer(handles, 1), 0);
            next(handles, 0, Handle::Buffer(b));
        }
        Job::Raster { clear, part } => {
            let mut n = fg.raster(name, &kernels.raster);
            n.uniform("params", &params(node, part.into()))
                .read("in0", at(handles, 0));
            let load = match clear {
                Some(value) => Load::Clear(wgpu::Color {
                    r: value.into(),
                    ..wgpu::Color::BLACK
                }),
                None => Load::Load,
            };
            let t = Handle::Texture(n.color(0, at(handles, 1), load));
            next(handles, 1, t);
            switch!(n, node, handles, &[(1, t)]);
            n.draw(|pass| pass.draw(0..3, 0..1));
        }
        Job::Clear(value) => {
            let t = fg.clear_texture(name, texture(handles, 0), [value.into(); 4]);
            next(handles, 0, Handle::Texture(t));
        }
        Job::CopyTexture => {
            let t = fg.copy_texture(name, texture(handles, 0), texture(handles, 1));
            next(handles, 1, Handle::Texture(t));
        }
        Job::CopyBuffer => {
            let b = fg.copy_buffer(name, buffer(handles, 0), buffer(handles, 1));
            next(handles, 1, Handle::Buffer(b));
        }
        Job::Fill(value) => {
            let b = fg.fill_buffer(name, buffer(handles, 0), value);
            next(handles, 0, Handle::Buffer(b));
        }
        Job::Upload => {
            let words = frame.resources[node.uses[0].resource].shape.words();
            let words = uploaded(node.seed, words.unwrap_or(0));
            let bytes = bytemuck::cast_slice(&words).to_vec();
            let b = fg.upload_buffer(name, buffer(handles, 0), bytes);
            next(handles, 0, Handle::Buffer(b));
        }
        Job::ForeignTexture { whole } => {
            foreign_texture(fg, frame, node, handles, whole);
        }
        Job::ForeignBuffer => {
            let (from, to) = (buffer(handles, 0), buffer(handles, 1));
            let mut n = fg.foreign(name);
            n.read_buffer(from, wgpu::BufferUsages::COPY_SRC);
            let b = n.modify_buffer(to, wgpu::BufferUsages::COPY_DST);
            switch!(n, node, handles, &[]);
            n.record(copy_word([from, b]));
            next(handles, 1, Handle::Buffer(b));
        }
    }
}

fn bind_inputs(
    n: &mut ComputeNode<'_, '_>,
    frame: &Frame,
    node: &Node,
    inputs: &[In],
    handles: &Handles,
) {
    for (i, (input, u)) in inputs.iter().zip(&node.uses).enumerate() {
        let (binding, handle) = (format!("in{i}"), handles[&u.resource]);
        match input {
            In::Buffer | In::Uniform => n.read_buffer(&binding, handle.buffer()),
            _ => n.read(&binding, view(frame, handle.texture(), u)),
        };
    }
}

fn foreign_texture(
    fg: &mut FrameGraph<'_>,
    frame: &Frame,
    node: &Node,
    handles: &mut Handles,
    whole: bool,
) {
    let (source, target) = (&node.uses[0], &node.uses[1]);
    let [from, to] = [source, target].map(|u| handles[&u.resource].texture());
    let (a, b) = (source.range, target.range);
    let [width, height] = match whole {
        true => frame.resources[target.resource].shape.mip_size(b.mip),
        false => [1, 1],
    };
    let mut n = fg.foreign(&node.name);
    n.read(view(frame, from, source), wgpu::TextureUsages::COPY_SRC);
    let (to, usage) = (view(frame, to, target), wgpu::TextureUsages::COPY_DST);
    let made = match whole {
        true => n.overwrite(to, usage),
        false => n.modify(to, usage),
    };
    let output = Handle::Texture(made);
    handles.insert(target.resource, output);
    switch!(n, node, handles, &[(1, output)]);
    n.record(copy_texel([(from, a), (made, b)], [width, height]));
}

/// The data of a node's uniform.
pub fn params(node: &Node, place: u32) -> [u8; 16] {
    bytemuck::cast([node.seed, place, 0, 0])
}

/// The work of a foreign node: copies the first word.
pub fn copy_word(
    [from, to]: [Buffer; 2],
) -> impl FnOnce(&mut wgpu::CommandEncoder, &Resources<'_>) {
    move |encoder, resources| {
        if let (Some(from), Some(to)) = (resources.buffer(from), resources.buffer(to)) {
            encoder.copy_buffer_to_buffer(from, 0, to, 0, 4);
        }
    }
}

/// The work of a foreign node: copies some texels of one (mip, layer) to another.
pub fn copy_texel(
    [(from, a), (to, b)]: [(Texture, Subresources); 2],
    [width, height]: [u32; 2],
) -> impl FnOnce(&mut wgpu::CommandEncoder, &Resources<'_>) {
    move |encoder, resources| {
        let at = |texture, r: Subresources| wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: r.mip,
            origin: wgpu::Origin3d {
                x: 0,
                y: 0,
                z: r.layer,
            },
            aspect: wgpu::TextureAspect::All,
        };
        if let (Some(from), Some(to)) = (resources.texture(from), resources.texture(to)) {
            let size = wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            };
            encoder.copy_texture_to_texture(at(from, a), at(to, b), size);
        }
    }
}
