//! Nodes that may be off: what stands in for them, and what else stays as it is.

mod common;
use common::*;
use framegraph::*;

/// produce -> a -> increment (may be off) -> b -> look; b is a where it is off.
fn declare<'f>(pool: &Pool, k: &Kernels, on: bool) -> Plan<'f> {
    let mut fg = pool.frame(FRAME);
    let (a, b, c) = (
        fg.texture("a", R32),
        fg.texture("b", R32),
        fg.texture("c", R32),
    );
    let a = produce(&mut fg, k, "produce", a);
    let mut node = fg.compute("increment", &k.increment);
    node.read("input", a);
    let b = node.overwrite("out_value", b);
    node.enabled_if(on).or_use(b, a);
    node.dispatch_texels([64, 64]);
    let c = increment(&mut fg, k, "last", b, c);
    fg.export_texture("c", c);
    fg.compile().unwrap()
}

#[test]
fn the_plan_holds_both_ways() {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let text = |on, off| {
        dedent(&format!(
            "
            compute
              dispatch produce 8x8x1
                a: undefined -> storage-write
              dispatch increment 8x8x1, {on}
                a: storage-write -> sampled, barrier
                b: undefined -> storage-write
            end
            copy increment, {off}
              a: sampled -> copy-source, barrier
              b: storage-write -> copy-target, barrier
            compute, apart: `last` waits for copy `increment`, which waits for `increment`
              dispatch last 8x8x1
                b: copy-target -> sampled, barrier
                c: undefined -> storage-write, barrier
            end
            export c = c
            "
        ))
    };
    pretty(&declare(&pool, &k, true).to_string(), &text("on", "off"));
    pretty(&declare(&pool, &k, false).to_string(), &text("off", "on"));
    assert_eq!(pool.plans().compiled, 1);
}

/// On and off, executed: the numbers are what the node, or its stand-in, gives. Nothing new is made.
#[test]
fn what_stands_in_is_seen() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    pool.debug().clobber = true;
    for (on, value) in [(true, 3.0), (false, 2.0), (true, 3.0)] {
        let plan = declare(&pool, &k, on);
        run(&device, &queue, &mut pool, plan);
        let texels = download(&device, &queue, pool.exported_texture("c").unwrap());
        assert!(texels.iter().all(|&x| x == value), "{on}: {}", texels[0]);
    }
    assert_eq!(pool.plans().compiled, 1);
}

/// Clears of parts, fills with a word, copies of buffers, draws, foreign work, and what is modified.
#[test]
fn every_kind_of_stand_in() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let count = kernel(
        &device,
        "count",
        "@group(0) @binding(0) var<storage, read_write> words: array<u32>;
         @compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3u) { words[id.x] = 9u; }",
    );
    for on in [true, false] {
        let mut fg = pool.frame(FRAME);
        let t = fg.texture("t", R32.with_mips(2));
        let t = fg.clear_texture("clear", t, [5.0; 4]);
        let mut node = fg.compute("mip", &k.produce);
        let t = node.overwrite("out_value", t.mip(0));
        node.enabled_if(on).or_clear(t, [7.0; 4]);
        node.dispatch_texels([64, 64]);
        let mut node = fg.compute("bump", &k.bump);
        let t = node.modify("value", t.mip(0));
        node.enabled_if(on);
        node.dispatch_texels([64, 64]);
        fg.export_texture("t", t);

        let [filled, zero, copied] = ["filled", "zero", "copied"].map(|n| fg.buffer(n, 16));
        let words =
            |fg: &mut FrameGraph<'_>, buffer, how: &dyn Fn(&mut ComputeNode<'_, '_>, Buffer)| {
                let mut node = fg.compute("count", &count);
                let buffer = node.overwrite_buffer("words", buffer);
                node.enabled_if(on);
                how(&mut node, buffer);
                node.dispatch([4, 1, 1]);
                buffer
            };
        let filled = words(&mut fg, filled, &|node, b| {
            node.or_fill(b, 3);
        });
        let zero = words(&mut fg, zero, &|node, b| {
            node.or_fill(b, 0);
        });
        let copied = words(&mut fg, copied, &|node, b| {
            node.or_use_buffer(b, filled);
        });
        let foreign = fg.buffer("foreign", 16);
        let mut node = fg.foreign("foreign");
        let foreign = node.overwrite_buffer(foreign, wgpu::BufferUsages::COPY_DST);
        node.enabled_if(on).or_fill(foreign, 4);
        node.record(move |encoder, resources| {
            encoder.clear_buffer(resources.buffer(foreign).unwrap(), 0, None);
        });
        let all = [
            ("filled", filled, 9, 3),
            ("zero", zero, 9, 0),
            ("copied", copied, 9, 3),
            ("foreign", foreign, 0, 4),
        ];
        for (key, buffer, ..) in all {
            fg.export_buffer(key, buffer);
        }
        let plan = fg.compile().unwrap();
        run(&device, &queue, &mut pool, plan);
        let texels = download(&device, &queue, pool.exported_texture("t").unwrap());
        let value = if on { 2.0 } else { 7.0 };
        assert!(texels.iter().all(|&x| x == value), "{on}: {}", texels[0]);
        for (key, _, yes, no) in all {
            let words = download_words(&device, &queue, pool.exported_buffer(key).unwrap());
            assert_eq!(words, [if on { yes } else { no }; 4], "{key} {on}");
        }
    }
}

/// Memory, views and bind groups of the others are the same whether it is on or off.
#[test]
fn slots_are_stable() {
    let (device, queue) = noop();
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let mut exported = Vec::new();
    for on in [true, false, true] {
        let plan = declare(&pool, &k, on);
        run(&device, &queue, &mut pool, plan);
        exported.push(pool.exported_texture("c").unwrap().clone());
    }
    assert!(exported.iter().all(|t| *t == exported[0]));
}

/// Passes are grouped over what is off.
#[test]
fn off_steps_do_not_part_a_pass() {
    let (device, queue) =
        noop_with(wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES);
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    pool.debug().timestamps = true;
    for (on, names) in [
        (true, ["produce", "increment", "last"]),
        (false, ["produce", "increment", "last"]),
    ] {
        let plan = declare(&pool, &k, on);
        run(&device, &queue, &mut pool, plan);
        // Each node that is on is measured once: of the two `increment` exactly one is.
        let timings = pool.timings();
        let measured: Vec<_> = timings.iter().map(|t| t.name.as_str()).collect();
        assert_eq!(measured, names);
    }
}

fn messages(fg: FrameGraph<'_>) -> Vec<String> {
    let errors = fg.compile().err().map(|e| e.0).unwrap_or_default();
    let text = |e: &GraphError| format!("{} {}", e.code, e.message);
    errors.iter().map(text).collect()
}

#[test]
fn an_output_without_stand_in_must_not_be_needed() {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    // Also while it is on, so that the mistake does not wait for the frame in which it is off.
    for on in [true, false] {
        let mut fg = pool.frame(FRAME);
        let (a, b) = (fg.texture("a", R32), fg.texture("b", R32));
        let mut node = fg.compute("maybe", &k.produce);
        let a = node.overwrite("out_value", a);
        node.enabled_if(on);
        node.dispatch_texels([64, 64]);
        let b = increment(&mut fg, &k, "reader", a, b);
        fg.export_texture("a", a);
        fg.export_texture("b", b);
        assert_eq!(
            messages(fg),
            [
                "FG023 `reader` reads `a`, which `maybe` leaves without contents while it is off",
                "FG023 the export `a` takes `a`, which `maybe` leaves without contents while it is off",
            ]
        );
    }
}

/// A chain that is switched as one needs a stand-in only where it ends.
#[test]
fn readers_may_be_off_together() {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let chain = |first: bool, second: bool| {
        let mut fg = pool.frame(FRAME);
        let (a, b) = (fg.texture("a", R32), fg.texture("b", R32));
        let mut node = fg.compute("first", &k.produce);
        let a = node.overwrite("out_value", a);
        node.enabled_if(first);
        node.dispatch_texels([64, 64]);
        let mut node = fg.compute("second", &k.increment);
        node.read("input", a);
        let b = node.overwrite("out_value", b);
        node.enabled_if(second).or_clear(b, [0.0; 4]);
        node.dispatch_texels([64, 64]);
        fg.export_texture("b", b);
        messages(fg)
    };
    assert!(chain(true, true).is_empty());
    assert!(chain(false, false).is_empty());
    assert!(chain(true, false).is_empty());
    assert_eq!(pool.plans().compiled, 1);
    assert_eq!(
        chain(false, true),
        ["FG023 `second` reads `a`, which `first` leaves without contents while it is off"]
    );
}

#[test]
fn mistakes_with_stand_ins() {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let mut fg = pool.frame(FRAME);
    let (a, b) = (fg.texture("a", R32), fg.texture("b", R32.with_mips(2)));
    let a = produce(&mut fg, &k, "produce", a);
    let b = fg.clear_texture("clear", b, [0.0; 4]);
    let mut node = fg.compute("node", &k.increment);
    node.read("input", b.mip(0));
    let a = node.overwrite("out_value", a);
    node.enabled_if(true).or_use(a, b).or_clear(b, [0.0; 4]);
    node.dispatch_texels([64, 64]);
    fg.export_texture("a", a);
    assert_eq!(
        messages(fg),
        [
            "FG023 something stands in for `b`, which `node` does not overwrite",
            "FG015 `b` (64x64 R32Float 2 mips 1 layers) cannot stand in for `a` (64x64 R32Float)",
        ]
    );
}

/// What a switched node modifies is without contents where what it found was.
#[test]
fn modifying_gives_no_contents() {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let mut fg = pool.frame(FRAME);
    let (a, b) = (fg.texture("a", R32), fg.texture("b", R32));
    let mut node = fg.compute("first", &k.produce);
    let a = node.overwrite("out_value", a);
    node.enabled_if(true);
    node.dispatch_texels([64, 64]);
    let mut node = fg.compute("second", &k.bump);
    let a = node.modify("value", a);
    node.enabled_if(true);
    node.dispatch_texels([64, 64]);
    let b = increment(&mut fg, &k, "reader", a, b);
    fg.export_texture("b", b);
    assert_eq!(
        messages(fg),
        ["FG023 `reader` reads `a`, which `first` leaves without contents while it is off"]
    );
}

/// A stand-in takes what another node may have left without contents, in the frames in which it runs.
#[test]
fn stand_ins_are_readers() {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let messages = |first: bool, second: bool| {
        let mut fg = pool.frame(FRAME);
        let (a, b) = (fg.texture("a", R32), fg.texture("b", R32));
        let mut node = fg.compute("first", &k.produce);
        let a = node.overwrite("out_value", a);
        node.enabled_if(first);
        node.dispatch_texels([64, 64]);
        let mut node = fg.compute("second", &k.produce);
        let b = node.overwrite("out_value", b);
        node.enabled_if(second).or_use(b, a);
        node.dispatch_texels([64, 64]);
        fg.export_texture("b", b);
        messages(fg)
    };
    assert!(messages(true, true).is_empty());
    assert!(messages(true, false).is_empty());
    assert!(messages(false, true).is_empty());
    assert_eq!(
        messages(false, false),
        ["FG023 `second` reads `a`, which `first` leaves without contents while it is off"]
    );
    assert_eq!(pool.plans().compiled, 1);
}

#[test]
fn nothing_stands_in_for_itself() {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let mut fg = pool.frame(FRAME);
    let a = fg.texture("a", R32);
    let mut node = fg.compute("node", &k.produce);
    let a = node.overwrite("out_value", a);
    node.enabled_if(true).or_use(a, a);
    node.dispatch_texels([64, 64]);
    fg.export_texture("a", a);
    assert_eq!(
        messages(fg),
        ["FG013 `node` touches the same part of `a` twice, and writes it"]
    );
}
