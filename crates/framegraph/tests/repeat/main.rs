//! A frame that was encoded, once more: what it does, what may be changed in it, and when it must be declared.

mod changes;
#[path = "../common/mod.rs"]
mod common;

use common::*;
use framegraph::*;

/// The plan comes first, so that it may be made with the pool.
pub fn submit(plan: Plan<'_>, device: &wgpu::Device, queue: &wgpu::Queue, pool: &mut Pool) {
    run(device, queue, pool, plan);
}

fn at(frame: u64) -> FrameParams {
    FrameParams { frame, ..FRAME }
}

/// h@-1 -> step -> h => export, where a clear stands in for h@-1.
fn history<'f>(pool: &Pool, k: &Kernels, params: FrameParams) -> FrameGraph<'f> {
    let mut fg = pool.frame(params);
    let h = fg.history_texture("h", R32, 1, First::Clear([0.5; 4]));
    let out = increment(&mut fg, k, "step", h.previous[0].unwrap(), h.current);
    fg.export_texture("out", out);
    fg
}

fn refused(pool: &Pool, params: FrameParams) -> RepeatError {
    pool.repeat(params).map(|_| ()).unwrap_err()
}

/// The history advances through repeats and declared frames alike, and each exports its own.
#[test]
fn histories_advance() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let mut declared = Vec::new();
    for frame in 0..8 {
        let plan = match pool.repeat(at(frame)) {
            // Frame 5 is declared although it could be repeated.
            Ok(again) if frame != 5 => again.compile().unwrap(),
            _ => {
                declared.push(frame);
                history(&pool, &k, at(frame)).compile().unwrap()
            }
        };
        submit(plan, &device, &queue, &mut pool);
        let texels = download(&device, &queue, pool.exported_texture("out").unwrap());
        let want = frame as f32 + 1.5;
        assert!(
            texels.iter().all(|&x| x == want),
            "{frame}: {} instead of {want}",
            texels[0]
        );
        let info = pool.history("h").unwrap();
        assert_eq!((info.written, info.since), (frame, 0));
    }
    // There is nothing to repeat in frame 0, and no clear any more in frame 1.
    assert_eq!(declared, [0, 1, 5]);
    assert_eq!(pool.plans().compiled, 2);
}

/// A repeat is the plan of the frame, with the same text and what it was given.
#[test]
fn it_is_the_same_plan() {
    let (device, queue) = noop();
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    for frame in 0..2 {
        let plan = history(&pool, &k, at(frame)).compile().unwrap();
        submit(plan, &device, &queue, &mut pool);
    }
    let text = |plan: &Plan<'_>| format!("{plan}{:?}{:?}", plan.warnings(), plan.memory());
    let plan = pool.repeat(at(2)).unwrap().compile().unwrap();
    let repeated = text(&plan);
    submit(plan, &device, &queue, &mut pool);
    let plan = history(&pool, &k, at(3)).compile().unwrap();
    assert_eq!(repeated, text(&plan));
    assert_eq!(pool.plans().compiled, 2);
}

#[test]
fn what_would_be_another_graph_is_refused() {
    let (device, queue) = noop();
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    assert_eq!(refused(&pool, FRAME), RepeatError::NoFrame);
    let go = |pool: &mut Pool, params| {
        let plan = history(pool, &k, params).compile().unwrap();
        run(&device, &queue, pool, plan);
    };
    go(&mut pool, FRAME);
    let (key, size) = (Label::from("h"), [32, 64]);
    let first = RepeatError::History {
        key: key.clone(),
        held: 0,
        holds: 1,
    };
    assert_eq!(refused(&pool, FRAME), first);
    assert_eq!(
        first.to_string(),
        "the history `h` holds 1 past frames and held 0 when the frame was declared: declare the frame"
    );
    go(&mut pool, at(1));
    let resized = RepeatError::Resized {
        from: [64, 64],
        to: size,
    };
    assert_eq!(refused(&pool, FrameParams { size, frame: 2 }), resized);
    assert!(resized.to_string().contains("[64, 64]"));
    // What is refused is still there.
    assert!(pool.repeat(at(2)).is_ok());

    go(&mut pool, at(2));
    pool.reset_history("h", "cut");
    let reset = refused(&pool, at(3)).to_string();
    assert_eq!(
        reset,
        "the history `h` was reset (asked: cut) since the frame was encoded: declare the frame"
    );
    go(&mut pool, at(3));
    go(&mut pool, at(4));
    pool.remove_history("h");
    assert!(refused(&pool, at(5)).to_string().contains("was removed"));
}

/// A history that nobody writes holds nothing in the next frame either.
#[test]
fn a_history_that_stays_empty_is_no_obstacle() {
    let (device, queue) = noop();
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let mut fg = pool.frame(FRAME);
    let h = fg.history_texture("h", R32, 2, First::Clear([0.5; 4]));
    look(&mut fg, &k, "look", h.previous[1].unwrap());
    let plan = fg.compile().unwrap();
    let text = plan.to_string();
    submit(plan, &device, &queue, &mut pool);
    let again = pool.repeat(at(1)).unwrap().compile().unwrap();
    assert_eq!(again.to_string(), text);
    submit(again, &device, &queue, &mut pool);
    let info = pool.history("h").unwrap();
    assert_eq!(info.resets, [(0, Reset::FirstFrame)]);
}

#[test]
fn only_the_frame_that_was_encoded_last_is_repeated() {
    let (device, queue) = noop();
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let chain = |pool: &Pool, name: &'static str| {
        let mut fg = pool.frame(FRAME);
        let a = fg.texture("a", R32);
        let a = produce(&mut fg, &k, name, a);
        fg.export_texture(name, a);
        fg
    };
    let other = |pool: &Pool| {
        let mut fg = pool.frame(FRAME);
        let a = fg.texture("b", R32);
        let a = produce(&mut fg, &k, "other", a);
        fg.export_texture("other", a);
        fg
    };
    submit(
        chain(&pool, "one").compile().unwrap(),
        &device,
        &queue,
        &mut pool,
    );
    // Graphs that are begun elsewhere and never encoded change nothing.
    drop(other(&pool).compile());
    submit(pool_repeat(&pool), &device, &queue, &mut pool);
    assert!(pool.exported_texture("one").is_some());

    submit(other(&pool).compile().unwrap(), &device, &queue, &mut pool);
    submit(pool_repeat(&pool), &device, &queue, &mut pool);
    assert!(pool.exported_texture("other").is_some());
    assert!(pool.exported_texture("one").is_none());

    // One that is begun in its place takes its lists.
    drop(other(&pool));
    assert_eq!(refused(&pool, FRAME), RepeatError::NoFrame);
    submit(other(&pool).compile().unwrap(), &device, &queue, &mut pool);
    // A repeat that is dropped ends it.
    drop(pool.repeat(FRAME).unwrap());
    assert_eq!(refused(&pool, FRAME), RepeatError::NoFrame);
}

fn pool_repeat<'f>(pool: &Pool) -> Plan<'f> {
    pool.repeat(FRAME).unwrap().compile().unwrap()
}

#[test]
fn after_a_failure_there_is_nothing_to_repeat() {
    let (device, queue) = noop();
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    for frame in 0..2 {
        let plan = history(&pool, &k, at(frame)).compile().unwrap();
        submit(plan, &device, &queue, &mut pool);
    }
    let encode = |pool: &mut Pool, plan: Plan<'_>| {
        let mut encoder = device.create_command_encoder(&Default::default());
        plan.encode(&mut encoder, pool)
    };
    // A repeat counts on the histories as a declared frame does.
    let again = pool.repeat(at(2)).unwrap().compile().unwrap();
    pool.reset_history("h", "cut");
    assert_eq!(encode(&mut pool, again), Err(EncodeError::Outdated));
    assert_eq!(refused(&pool, at(2)), RepeatError::NoFrame);

    for frame in 2..4 {
        let plan = history(&pool, &k, at(frame)).compile().unwrap();
        submit(plan, &device, &queue, &mut pool);
    }
    let again = pool.repeat(at(4)).unwrap().compile().unwrap();
    let mut other = Pool::new(&device, &queue);
    assert_eq!(encode(&mut other, again), Err(EncodeError::OtherPool));

    let plan = history(&pool, &k, at(4)).compile().unwrap();
    submit(plan, &device, &queue, &mut pool);
    let again = pool.repeat(at(5)).unwrap().compile().unwrap();
    pool.device_lost_handler()();
    assert_eq!(encode(&mut pool, again), Err(EncodeError::DeviceLost));
    assert_eq!(refused(&pool, at(5)), RepeatError::NoFrame);
}

/// Levers act on the next repeat, those that decide the plan as well as those that only look.
#[test]
fn levers_act() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    for frame in 0..2 {
        let plan = history(&pool, &k, at(frame)).compile().unwrap();
        submit(plan, &device, &queue, &mut pool);
    }
    *pool.debug() = "clobber,capture=h@-1".parse().unwrap();
    let plan = pool.repeat(at(2)).unwrap().compile().unwrap();
    submit(plan, &device, &queue, &mut pool);
    let captured = pool.captured().unwrap();
    // Two frames of increments after the clear to 0.5.
    assert_eq!(captured[0].parts[0].bytes[..4], 2.5f32.to_ne_bytes());
    assert_eq!(pool.plans().compiled, 3, "clobbering decides a plan");

    *pool.debug() = "no_cache".parse().unwrap();
    for frame in 3..6 {
        let plan = pool.repeat(at(frame)).unwrap().compile().unwrap();
        submit(plan, &device, &queue, &mut pool);
    }
    assert_eq!(pool.plans().compiled, 6, "nothing is found again");
    let texels = download(&device, &queue, pool.exported_texture("out").unwrap());
    assert!(texels.iter().all(|&x| x == 6.5), "{}", texels[0]);
}
