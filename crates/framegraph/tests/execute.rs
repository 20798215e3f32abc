//! Graphs that are executed on a real adapter and read back.

mod common;
use common::*;
use framegraph::*;

/// ```text
/// produce -> a -> increment -> b -> sum -> out => export
///             \____________________/
/// ```
#[test]
fn a_small_graph_computes() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let k = Kernels::new(&device);
    let mut pool = Pool::new(&device, &queue);
    let mut fg = pool.frame(FRAME);
    let (a, b, out) = (
        fg.texture("a", R32),
        fg.texture("b", R32),
        fg.texture("out", R32),
    );
    let a = produce(&mut fg, &k, "produce", a);
    let b = increment(&mut fg, &k, "increment", a, b);
    let mut node = fg.compute("sum", &k.sum);
    node.read("a", a).read("b", b);
    let out = node.overwrite("out_value", out);
    node.dispatch_texels([64, 64]);
    fg.export_texture("out", out);
    let plan = fg.compile().unwrap();
    run(&device, &queue, &mut pool, plan);
    let texels = download(&device, &queue, pool.exported_texture("out").unwrap());
    assert!(texels.iter().all(|&t| t == 3.0));
}

/// ```text
/// upload -> words -> double -> words => export;  fill -> ones => export;  copy words -> twin => export
/// ```
#[test]
fn buffers_are_uploaded_filled_and_copied() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let double = kernel(
        &device,
        "double",
        "@group(0) @binding(0) var<storage, read_write> words: array<u32>;
         @group(0) @binding(1) var<uniform> factor: u32;
         @compute @workgroup_size(4) fn main(@builtin(global_invocation_id) id: vec3u) {
             words[id.x] = words[id.x] * factor;
         }",
    );
    let mut pool = Pool::new(&device, &queue);
    let mut fg = pool.frame(FRAME);
    let (words, ones, twin) = (
        fg.buffer("words", 16),
        fg.buffer("ones", 8),
        fg.buffer("twin", 16),
    );
    let words = fg.upload_buffer(
        "upload",
        words,
        bytemuck::cast_slice(&[1u32, 2, 3, 4]).to_vec(),
    );
    let mut node = fg.compute("double", &double);
    let words = node.modify_buffer("words", words);
    node.uniform("factor", bytemuck::bytes_of(&2u32));
    node.dispatch([1, 1, 1]);
    let ones = fg.fill_buffer("fill", ones, 1);
    let twin = fg.copy_buffer("copy", words, twin);
    fg.export_buffer("words", words);
    fg.export_buffer("ones", ones);
    fg.export_buffer("twin", twin);
    let plan = fg.compile().unwrap();
    run(&device, &queue, &mut pool, plan);
    let get = |key: &str| download_words(&device, &queue, pool.exported_buffer(key).unwrap());
    assert_eq!(get("words"), [2, 4, 6, 8]);
    assert_eq!(get("ones"), [1, 1]);
    assert_eq!(get("twin"), [2, 4, 6, 8]);
}

/// Adds 1 to last frame's texture, in each of four frames:
/// `count@-1 -> increment -> count => export`
#[test]
fn history_counts_frames() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let k = Kernels::new(&device);
    let mut pool = Pool::new(&device, &queue);
    for frame in 0..4 {
        let mut fg = pool.frame(FrameParams { frame, ..FRAME });
        let h = fg.history_texture("count", R32, 1, First::Clear([10.0, 0.0, 0.0, 0.0]));
        let out = increment(&mut fg, &k, "increment", h.previous[0].unwrap(), h.current);
        fg.export_texture("count", out);
        let plan = fg.compile().unwrap();
        run(&device, &queue, &mut pool, plan);
        let texels = download(&device, &queue, pool.exported_texture("count").unwrap());
        assert!(
            texels.iter().all(|&t| t == 11.0 + frame as f32),
            "frame {frame}: {}",
            texels[0]
        );
    }
}

/// clear -> copy -> bump => export, timed.
#[test]
fn every_node_is_timed() {
    let Some((device, queue)) = real(wgpu::Features::TIMESTAMP_QUERY) else {
        return;
    };
    let k = Kernels::new(&device);
    let mut pool = Pool::new(&device, &queue);
    pool.debug().timestamps = true;
    let mut fg = pool.frame(FRAME);
    let (a, b) = (fg.texture("a", R32), fg.texture("b", R32));
    let a = fg.clear_texture("clear", a, [2.0; 4]);
    let b = fg.copy_texture("copy", a, b);
    let b = bump(&mut fg, &k, "bump", b);
    fg.export_texture("b", b);
    let plan = fg.compile().unwrap();
    run(&device, &queue, &mut pool, plan);
    let timings = pool.timings();
    assert_eq!(
        timings.iter().map(|t| t.name.as_str()).collect::<Vec<_>>(),
        ["clear", "copy", "bump"]
    );
    assert!(timings[2].nanoseconds > 0, "{timings:?}");
    assert!(pool.timings().is_empty(), "read once");
    let texels = download(&device, &queue, pool.exported_texture("b").unwrap());
    assert!(texels.iter().all(|&t| t == 3.0));
}
