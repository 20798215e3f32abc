//! Barriers for reads that are made as one.

mod common;
use common::*;
use framegraph::*;

/// `first -> a -> third -> c` and `second -> b -> fourth -> d`
fn two_chains<'f>(pool: &Pool, k: &Kernels) -> Plan<'f> {
    let mut fg = pool.frame(FRAME);
    let [a, b, c, d] = ["a", "b", "c", "d"].map(|name| fg.texture(name, R32));
    let a = produce(&mut fg, k, "first", a);
    let b = produce(&mut fg, k, "second", b);
    let c = increment(&mut fg, k, "third", a, c);
    let d = increment(&mut fg, k, "fourth", b, d);
    for (key, texture) in [("a", a), ("b", b), ("c", c), ("d", d)] {
        fg.export_texture(key, texture);
    }
    fg.compile().unwrap()
}

#[test]
fn what_later_dispatches_read_is_ready_with_the_first() {
    let (device, queue) = noop();
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let plan = two_chains(&pool, &k);
    assert_plan!(
        plan,
        "
        compute
          dispatch first 8x8x1
            a: undefined -> storage-write
          dispatch second 8x8x1
            b: undefined -> storage-write
          barrier a: storage-write -> sampled
          barrier b: storage-write -> sampled
          dispatch third 8x8x1
            a: storage-write -> sampled, batched
            c: undefined -> storage-write
          dispatch fourth 8x8x1
            b: storage-write -> sampled, batched
            d: undefined -> storage-write
        end
        export a = a
        export b = b
        export c = c
        export d = d
        "
    );
    assert_eq!(plan.barriers(), 1);
    pool.debug().no_batch = true;
    let plan = two_chains(&pool, &k);
    assert_eq!(plan.barriers(), 2);
    assert!(plan.steps().iter().all(|step| plan.batch(step).is_empty()));
}

/// wgpu makes a barrier for a write in front of `fourth` either way, so nothing is made for it before.
#[test]
fn a_place_with_a_write_keeps_its_barrier() {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let mut fg = pool.frame(FRAME);
    let [a, b, c, d] = ["a", "b", "c", "d"].map(|name| fg.texture(name, R32));
    let a = produce(&mut fg, &k, "first", a);
    let b = produce(&mut fg, &k, "second", b);
    let d = produce(&mut fg, &k, "before", d);
    look(&mut fg, &k, "look", d);
    let c = increment(&mut fg, &k, "third", a, c);
    let d = increment(&mut fg, &k, "fourth", b, d);
    for (key, texture) in [("a", a), ("b", b), ("c", c), ("d", d)] {
        fg.export_texture(key, texture);
    }
    let plan = fg.compile().unwrap();
    // In front of `look`, for it and `third`.
    let in_front = |step: &Step| (plan.name(step).to_owned(), plan.batch(step).len());
    let batches: Vec<_> = plan
        .steps()
        .iter()
        .map(in_front)
        .filter(|b| b.1 > 0)
        .collect();
    assert_eq!(batches, [("look".to_owned(), 2)]);
    assert_eq!(plan.barriers(), 2);
}

/// Between passes too: copies of what a compute pass has written.
#[test]
fn copies_share_a_barrier() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    for (no_batch, barriers) in [(false, 1), (true, 2)] {
        pool.debug().no_batch = no_batch;
        let mut fg = pool.frame(FRAME);
        let [a, b, c, d] = ["a", "b", "c", "d"].map(|name| fg.texture(name, R32));
        let a = produce(&mut fg, &k, "first", a);
        let b = produce(&mut fg, &k, "second", b);
        let c = fg.copy_texture("third", a, c);
        let d = fg.copy_texture("fourth", b, d);
        for (key, texture) in [("a", a), ("b", b), ("c", c), ("d", d)] {
            fg.export_texture(key, texture);
        }
        let plan = fg.compile().unwrap();
        assert_eq!(plan.barriers(), barriers, "{plan}");
        run(&device, &queue, &mut pool, plan);
        for key in ["c", "d"] {
            let texels = download(&device, &queue, pool.exported_texture(key).unwrap());
            assert!(texels.iter().all(|&x| x == 1.0), "{key}: {}", texels[0]);
        }
    }
}
