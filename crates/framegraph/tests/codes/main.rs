//! Each code has its page in `docs/errors`, and the example on the page yields that code: the examples
//! stand here, between their code and `end`, and the pages quote them.

#[path = "../common/mod.rs"]
mod common;
mod given;

use common::noop_with;
use framegraph::*;
use given::{DESC, Given, PARAMS};

/// Of all errors, else of all warnings.
fn codes(graph: FrameGraph<'_>) -> Vec<Code> {
    match graph.compile() {
        Err(errors) => errors.iter().map(|e| e.code).collect(),
        Ok(plan) => plan.warnings().iter().map(|w| w.code).collect(),
    }
}

/// No arm for the rest: a new code needs its page and its example.
fn example(code: Code) -> fn(&mut Pool, &Given) -> Vec<Code> {
    match code {
        Code::Stale => fg001,
        Code::ReadBeforeWrite => fg002,
        Code::OtherGraph => fg003,
        Code::UnknownBinding => fg004,
        Code::Unbound => fg005,
        Code::BoundTwice => fg006,
        Code::WrongKind => fg007,
        Code::Format => fg008,
        Code::Dimension => fg009,
        Code::OutOfRange => fg010,
        Code::UniformSize => fg011,
        Code::BufferSize => fg012,
        Code::Conflict => fg013,
        Code::Unfinished => fg014,
        Code::Copy => fg015,
        Code::DuplicateKey => fg016,
        Code::Attachment => fg017,
        Code::BindGroup => fg018,
        Code::Size => fg019,
        Code::Usage => fg020,
        Code::PartialHistory => fg021,
        Code::Dispatch => fg022,
        Code::SwitchedOff => fg023,
        Code::LateReset => fg024,
        Code::Repeat => fg025,
        Code::DeadNode => fg101,
        Code::Unread => fg102,
        Code::HistoryUnwritten => fg103,
        Code::NoTimestamps => fg104,
        Code::SplitToMeasure => fg105,
        Code::Capture => fg106,
        Code::LoadOfClear => fg107,
    }
}

#[test]
fn each_code_has_a_page_whose_example_yields_it_alone() {
    let source = include_str!("main.rs");
    for &code in Code::ALL {
        // One device can time whole passes, all others cannot measure.
        let features = match code {
            Code::SplitToMeasure => wgpu::Features::TIMESTAMP_QUERY,
            _ => wgpu::Features::empty(),
        };
        let (device, queue) = noop_with(features);
        let mut pool = Pool::new(&device, &queue);
        assert_eq!(example(code)(&mut pool, &Given::new(&device)), [code]);

        let page = code.explain();
        assert!(page.starts_with(&format!("# {code}: ")), "{page}");
        let quoted = page.split_once("```rust\n").unwrap().1;
        let quoted = quoted.split_once("```\n").unwrap().0;
        let own = source.split_once(&format!("    // {code}\n")).unwrap().1;
        let own = own.split_once("    // end\n").unwrap().0;
        let own: Vec<&str> = own
            .lines()
            .map(|l| l.strip_prefix("    ").unwrap_or(l))
            .collect();
        assert_eq!(quoted.lines().collect::<Vec<_>>(), own, "{code}");
        assert!(page.contains("\n## What to do\n"), "{code}");
    }
}

/// The list of pages names each with its title.
#[test]
fn the_list_is_complete() {
    let list = include_str!("../../docs/errors/README.md");
    for &code in Code::ALL {
        let title = code.explain().lines().next().unwrap();
        let title = title.strip_prefix(&format!("# {code}: ")).unwrap();
        let row = format!("- [{code}]({code}.md): {title}\n");
        assert!(list.contains(&row), "{row} is missing");
    }
}

fn fg001(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { fill, add, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG001
    let mut graph = pool.frame(params);
    let a = graph.texture("a", desc);
    let mut node = graph.compute("fill", fill);
    let first = node.overwrite("out", a);
    node.dispatch_texels([64, 64]);
    let mut node = graph.compute("add", add);
    let second = node.modify("value", first);
    node.dispatch_texels([64, 64]);
    graph.export_texture("result", first);
    graph.export_texture("latest", second);
    // end
    codes(graph)
}

fn fg002(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { blur, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG002
    let mut graph = pool.frame(params);
    let (a, b) = (graph.texture("a", desc), graph.texture("b", desc));
    let mut node = graph.compute("blur", blur);
    node.read("input", a);
    let b = node.overwrite("out", b);
    node.dispatch_texels([64, 64]);
    graph.export_texture("result", b);
    // end
    codes(graph)
}

fn fg003(pool: &mut Pool, _given: &Given) -> Vec<Code> {
    let desc = DESC;
    let params = PARAMS;
    // FG003
    let kept = pool.frame(params).texture("kept", desc);
    let mut graph = pool.frame(params);
    graph.clear_texture("clear", kept, [0.0; 4]);
    // end
    codes(graph)
}

fn fg004(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { blur, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG004
    let mut graph = pool.frame(params);
    let a = graph.texture("a", desc);
    let a = graph.clear_texture("clear", a, [0.0; 4]);
    let b = graph.texture("b", desc);
    let mut node = graph.compute("blur", blur);
    node.read("inptu", a);
    let b = node.overwrite("out", b);
    node.dispatch_texels([64, 64]);
    graph.export_texture("result", b);
    // end
    codes(graph)
}

fn fg005(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { fill, .. } = given;
    let params = PARAMS;
    // FG005
    let mut graph = pool.frame(params);
    let mut node = graph.compute("fill", fill);
    node.side_effect("an example");
    node.dispatch([8, 8, 1]);
    // end
    codes(graph)
}

fn fg006(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { blur, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG006
    let mut graph = pool.frame(params);
    let a = graph.texture("a", desc);
    let a = graph.clear_texture("clear", a, [0.0; 4]);
    let b = graph.texture("b", desc);
    let mut node = graph.compute("blur", blur);
    node.read("input", a).read("input", a);
    let b = node.overwrite("out", b);
    node.dispatch_texels([64, 64]);
    graph.export_texture("result", b);
    // end
    codes(graph)
}

fn fg007(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { fill, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG007
    let mut graph = pool.frame(params);
    let a = graph.texture("a", desc);
    let a = graph.clear_texture("clear", a, [0.0; 4]);
    let mut node = graph.compute("fill", fill);
    node.read("out", a);
    node.side_effect("an example");
    node.dispatch_texels([64, 64]);
    // end
    codes(graph)
}

fn fg008(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { fill, .. } = given;
    let params = PARAMS;
    // FG008
    let mut graph = pool.frame(params);
    let bytes = TextureDesc::d2(wgpu::TextureFormat::Rgba8Unorm, Size::Frame);
    let a = graph.texture("a", bytes);
    let mut node = graph.compute("fill", fill);
    let a = node.overwrite("out", a);
    node.dispatch_texels([64, 64]);
    graph.export_texture("result", a);
    // end
    codes(graph)
}

fn fg009(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { blur, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG009
    let mut graph = pool.frame(params);
    let a = graph.texture("a", desc.with_layers(2));
    let a = graph.clear_texture("clear", a, [0.0; 4]);
    let b = graph.texture("b", desc);
    let mut node = graph.compute("blur", blur);
    node.read("input", a);
    let b = node.overwrite("out", b);
    node.dispatch_texels([64, 64]);
    graph.export_texture("result", b);
    // end
    codes(graph)
}

fn fg010(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { fill, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG010
    let mut graph = pool.frame(params);
    let a = graph.texture("a", desc.with_mips(3));
    let mut node = graph.compute("fill", fill);
    node.overwrite("out", a.mip(3));
    node.dispatch_texels([8, 8]);
    // end
    codes(graph)
}

fn fg011(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { shade, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG011
    let mut graph = pool.frame(params);
    let lights = graph.buffer("lights", 64);
    let lights = graph.fill_buffer("dark", lights, 0);
    let a = graph.texture("a", desc);
    let mut node = graph.compute("shade", shade);
    node.uniform("params", &1.0f32.to_ne_bytes());
    node.read_buffer("lights", lights);
    let a = node.overwrite("out", a);
    node.dispatch_texels([64, 64]);
    graph.export_texture("result", a);
    // end
    codes(graph)
}

fn fg012(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { shade, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG012
    let mut graph = pool.frame(params);
    let lights = graph.buffer("lights", 16);
    let lights = graph.fill_buffer("dark", lights, 0);
    let a = graph.texture("a", desc);
    let mut node = graph.compute("shade", shade);
    node.uniform("params", &[0; 16]);
    node.read_buffer("lights", lights);
    let a = node.overwrite("out", a);
    node.dispatch_texels([64, 64]);
    graph.export_texture("result", a);
    // end
    codes(graph)
}

fn fg013(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { blur, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG013
    let mut graph = pool.frame(params);
    let a = graph.texture("a", desc);
    let a = graph.clear_texture("clear", a, [0.0; 4]);
    let mut node = graph.compute("blur", blur);
    node.read("input", a);
    let a = node.overwrite("out", a);
    node.dispatch_texels([64, 64]);
    graph.export_texture("result", a);
    // end
    codes(graph)
}

fn fg014(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { fill, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG014
    let mut graph = pool.frame(params);
    let a = graph.texture("a", desc);
    let mut node = graph.compute("fill", fill);
    let a = node.overwrite("out", a);
    graph.export_texture("result", a);
    // end
    codes(graph)
}

fn fg015(pool: &mut Pool, _given: &Given) -> Vec<Code> {
    let desc = DESC;
    let params = PARAMS;
    // FG015
    let mut graph = pool.frame(params);
    let a = graph.texture("a", desc);
    let a = graph.clear_texture("clear", a, [0.0; 4]);
    let size = Size::PerTexels(2);
    let half = graph.texture("half", TextureDesc { size, ..desc });
    let half = graph.copy_texture("copy", a, half);
    graph.export_texture("result", half);
    // end
    codes(graph)
}

fn fg016(pool: &mut Pool, _given: &Given) -> Vec<Code> {
    let desc = DESC;
    let params = PARAMS;
    // FG016
    let mut graph = pool.frame(params);
    let a = graph.texture("a", desc);
    let a = graph.clear_texture("clear", a, [0.0; 4]);
    graph.export_texture("result", a);
    graph.export_texture("result", a);
    // end
    codes(graph)
}

fn fg017(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { draw, .. } = given;
    let params = PARAMS;
    // FG017
    let mut graph = pool.frame(params);
    let mut node = graph.raster("draw", draw);
    node.side_effect("an example");
    node.draw(|pass| pass.draw(0..3, 0..1));
    // end
    codes(graph)
}

fn fg018(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { outside, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG018
    let mut graph = pool.frame(params);
    let a = graph.texture("a", desc);
    let mut node = graph.compute("outside", outside);
    let a = node.overwrite("out", a);
    node.dispatch([1, 1, 1]);
    graph.export_texture("result", a);
    // end
    codes(graph)
}

fn fg019(pool: &mut Pool, _given: &Given) -> Vec<Code> {
    let desc = DESC;
    let params = PARAMS;
    // FG019
    let mut graph = pool.frame(params);
    graph.texture("a", desc.with_mips(99));
    // end
    codes(graph)
}

fn fg020(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given {
        fill, sampled_only, ..
    } = given;
    let params = PARAMS;
    // FG020
    let mut graph = pool.frame(params);
    let target = graph.import_texture("target", sampled_only);
    let mut node = graph.compute("fill", fill);
    node.overwrite("out", target);
    node.dispatch_texels([64, 64]);
    // end
    codes(graph)
}

fn fg021(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { fill, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG021
    let mut graph = pool.frame(params);
    let history = graph.history_texture("h", desc.with_mips(2), 1, First::Clear([0.0; 4]));
    let mut node = graph.compute("fill", fill);
    let current = node.overwrite("out", history.current.mip(0));
    node.dispatch_texels([64, 64]);
    graph.export_texture("result", history.previous[0].unwrap_or(current));
    // end
    codes(graph)
}

fn fg022(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { fill, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG022
    let mut graph = pool.frame(params);
    let a = graph.texture("a", desc);
    let mut node = graph.compute("fill", fill);
    let a = node.overwrite("out", a);
    node.dispatch([1, 1, 100_000]);
    graph.export_texture("result", a);
    // end
    codes(graph)
}

fn fg023(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { fill, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    let lens_flare = false;
    // FG023
    let mut graph = pool.frame(params);
    let a = graph.texture("a", desc);
    let mut node = graph.compute("fill", fill);
    let a = node.overwrite("out", a);
    node.enabled_if(lens_flare);
    node.dispatch_texels([64, 64]);
    graph.export_texture("result", a);
    // end
    codes(graph)
}

fn fg024(pool: &mut Pool, _: &Given) -> Vec<Code> {
    let desc = DESC;
    let params = PARAMS;
    // FG024
    let mut graph = pool.frame(params);
    graph.history_texture("radiance", desc, 1, First::Clear([0.0; 4]));
    graph.reset_history("radiance", "camera cut");
    // end
    codes(graph)
}

fn fg025(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { device, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG025
    let mut graph = pool.frame(params);
    let a = graph.texture("a", desc);
    let a = graph.clear_texture("clear", a, [1.0; 4]);
    graph.export_texture("result", a);
    let mut encoder = device.create_command_encoder(&Default::default());
    graph.compile().unwrap().encode(&mut encoder, pool).unwrap();

    let mut again = pool.repeat(params).unwrap();
    again.clear("claer", [0.5; 4]);
    // end
    let errors = again.compile().map(|_| ()).unwrap_err();
    errors.iter().map(|e| e.code).collect()
}

fn fg101(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { fill, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG101
    let mut graph = pool.frame(params);
    let a = graph.texture("a", desc);
    let mut node = graph.compute("fill", fill);
    node.overwrite("out", a);
    node.dispatch_texels([64, 64]);
    // end
    codes(graph)
}

fn fg102(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { fill, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG102
    let mut graph = pool.frame(params);
    let a = graph.texture("a", desc.with_mips(2));
    let mut node = graph.compute("fill", fill);
    node.overwrite("out", a.mip(0));
    node.side_effect("an example");
    node.dispatch_texels([64, 64]);
    // end
    codes(graph)
}

fn fg103(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { blur, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG103
    let mut graph = pool.frame(params);
    let history = graph.history_texture("h", desc, 1, First::Clear([0.0; 4]));
    let b = graph.texture("b", desc);
    let mut node = graph.compute("blur", blur);
    if let Some(previous) = history.previous[0] {
        node.read("input", previous);
    }
    let b = node.overwrite("out", b);
    node.dispatch_texels([64, 64]);
    graph.export_texture("result", b);
    // end
    codes(graph)
}

fn fg104(pool: &mut Pool, _given: &Given) -> Vec<Code> {
    let params = PARAMS;
    // FG104
    pool.debug().timestamps = true;
    let graph = pool.frame(params);
    // end
    codes(graph)
}

fn fg105(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { fill, add, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG105
    pool.debug().timestamps = true;
    let mut graph = pool.frame(params);
    let a = graph.texture("a", desc);
    let mut node = graph.compute("fill", fill);
    let a = node.overwrite("out", a);
    node.dispatch_texels([64, 64]);
    let mut node = graph.compute("add", add);
    let a = node.modify("value", a);
    node.dispatch_texels([64, 64]);
    graph.export_texture("result", a);
    // end
    codes(graph)
}

fn fg106(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { fill, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG106
    pool.debug().capture = vec![Capture::last("radience")];
    let mut graph = pool.frame(params);
    let radiance = graph.texture("radiance", desc);
    let mut node = graph.compute("fill", fill);
    let radiance = node.overwrite("out", radiance);
    node.dispatch_texels([64, 64]);
    graph.export_texture("result", radiance);
    // end
    codes(graph)
}

fn fg107(pool: &mut Pool, given: &Given) -> Vec<Code> {
    let Given { draw, .. } = given;
    let desc = DESC;
    let params = PARAMS;
    // FG107
    let mut graph = pool.frame(params);
    let image = graph.texture("image", desc);
    let image = graph.clear_texture("clear", image, [0.0; 4]);
    let mut node = graph.raster("draw", draw);
    let image = node.color(0, image, Load::Load);
    node.draw(|pass| pass.draw(0..3, 0..1));
    graph.export_texture("result", image);
    // end
    codes(graph)
}
