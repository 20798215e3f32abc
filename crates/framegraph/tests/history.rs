//! Histories: what stands in for frames that do not exist, and what is kept of why.

mod common;
use common::*;
use framegraph::*;

fn setup() -> (wgpu::Device, wgpu::Queue, Kernels, Pool) {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    (device, queue, k, pool)
}

/// A temporal filter: `h@-1 -> step -> h => export`.
fn temporal<'f>(pool: &Pool, k: &Kernels, params: FrameParams, first: First) -> Plan<'f> {
    let mut fg = pool.frame(params);
    let h = fg.history_texture("h", R32, 1, first);
    let out = match h.previous[0] {
        Some(previous) => increment(&mut fg, k, "step", previous, h.current),
        None => produce(&mut fg, k, "start", h.current),
    };
    fg.export_texture("h", out);
    fg.compile().unwrap()
}

/// First frame: a clear stands in for `h@-1`. From the second on, what the frame before wrote.
#[test]
fn first_frame_clear() {
    let (device, queue, k, mut pool) = setup();
    let plan = temporal(&pool, &k, FRAME, First::Clear([0.5; 4]));
    assert_plan!(
        plan,
        "
        clear first h@-1
          h@-1: undefined -> color-target
        compute
          dispatch step 8x8x1
            h@-1: color-target -> sampled, barrier
            h: undefined -> storage-write
        end
        export h = h
        "
    );
    assert_eq!(pool.history("h"), None);
    run(&device, &queue, &mut pool, plan);
    let info = pool.history("h").unwrap();
    assert_eq!(
        info,
        HistoryInfo {
            frames: 1,
            since: 0,
            written: 0,
            reset: Reset::FirstFrame,
            numbers: vec![0],
            resets: vec![(0, Reset::FirstFrame)],
        }
    );
    let plan = temporal(
        &pool,
        &k,
        FrameParams { frame: 1, ..FRAME },
        First::Clear([0.5; 4]),
    );
    assert_plan!(
        plan,
        "
        compute
          dispatch step 8x8x1
            h@-1: kept -> sampled
            h: undefined -> storage-write
        end
        export h = h
        "
    );
    run(&device, &queue, &mut pool, plan);
    assert_eq!(pool.history("h").unwrap().written, 1);
    assert_eq!(pool.memory().history, 2 * 64 * 64 * 4);
}

/// First frame: there is no previous, and the caller declares another node. The write is kept from
/// culling although nobody can read the history yet.
#[test]
fn first_frame_skip() {
    let (device, queue, k, mut pool) = setup();
    let mut fg = pool.frame(FRAME);
    let h = fg.history_texture("h", R32, 1, First::Skip);
    assert_eq!(h.previous, [None]);
    produce(&mut fg, &k, "start", h.current);
    let plan = fg.compile().unwrap();
    assert_eq!(plan.order(), [0]);
    run(&device, &queue, &mut pool, plan);
    let mut fg = pool.frame(FRAME);
    let h = fg.history_texture("h", R32, 1, First::Skip);
    assert!(h.previous[0].is_some());
    produce(&mut fg, &k, "start", h.current);
    // Now it is known that nobody reads it.
    assert!(fg.compile().unwrap().order().is_empty());
}

/// First frame: a copy of this frame's own texture.
/// `produce -> a -> copy -> h@-1 -> sum(a, h@-1) -> h => export`
#[test]
fn first_frame_copy() {
    let (_, _, k, pool) = setup();
    let mut fg = pool.frame(FRAME);
    let a = fg.texture("a", R32);
    let a = produce(&mut fg, &k, "produce", a);
    let h = fg.history_texture("h", R32, 1, First::Copy(a));
    let mut node = fg.compute("sum", &k.sum);
    node.read("a", a).read("b", h.previous[0].unwrap());
    let out = node.overwrite("out_value", h.current);
    node.dispatch_texels([64, 64]);
    fg.export_texture("out", out);
    assert_plan!(
        fg.compile().unwrap(),
        "
        compute
          dispatch produce 8x8x1
            a: undefined -> storage-write
        end
        copy first h@-1
          a: storage-write -> copy-source, barrier
          h@-1: undefined -> copy-target
        compute, apart: `sum` waits for copy `first h@-1`, which waits for `produce`
          dispatch sum 8x8x1
            a: copy-source -> sampled, barrier
            h@-1: copy-target -> sampled, barrier
            h: undefined -> storage-write
        end
        export out = h
        "
    );
}

/// Resize, a change of the number of frames, and a reset that is asked for: the first-frame rule
/// applies again, and the reason is kept.
#[test]
fn resize_and_reset_keep_their_reason() {
    let (device, queue, k, mut pool) = setup();
    let at = |size, frame| FrameParams { size, frame };
    let clears = |plan: &Plan<'_>| plan.steps().iter().any(|s| s.kind == StepKind::Clear);
    let clear = First::Clear([0.0; 4]);
    for (frame, size, want_clear) in [
        (0, [64, 64], true),
        (1, [64, 64], false),
        (2, [32, 64], true),
        (3, [32, 64], false),
    ] {
        let plan = temporal(&pool, &k, at(size, frame), clear);
        assert_eq!(clears(&plan), want_clear, "frame {frame}");
        run(&device, &queue, &mut pool, plan);
    }
    let info = pool.history("h").unwrap();
    assert_eq!(
        info.reset.to_string(),
        "resized: 64x64 R32Float to 32x64 R32Float"
    );
    assert_eq!((info.since, info.written, info.frames), (2, 3, 1));

    pool.reset_history("h", "camera cut");
    assert_eq!(pool.history("h").unwrap().frames, 0);
    let plan = temporal(&pool, &k, at([32, 64], 4), clear);
    assert!(clears(&plan));
    run(&device, &queue, &mut pool, plan);
    let info = pool.history("h").unwrap();
    assert_eq!(info.reset.to_string(), "asked: camera cut");
    assert_eq!((info.since, info.frames), (4, 1));
    assert!(!clears(&temporal(&pool, &k, at([32, 64], 5), clear)));
}

/// Three frames back: each is filled until it exists.
#[test]
fn several_frames_back() {
    let (device, queue, k, mut pool) = setup();
    for frame in 0..5u64 {
        let mut fg = pool.frame(FrameParams { frame, ..FRAME });
        let h = fg.history_texture("h", R32, 3, First::Clear([0.0; 4]));
        for previous in h.previous.iter().flatten() {
            look(&mut fg, &k, "look", *previous);
        }
        produce(&mut fg, &k, "produce", h.current);
        let plan = fg.compile().unwrap();
        let clears = plan
            .steps()
            .iter()
            .filter(|s| s.kind == StepKind::Clear)
            .count() as u64;
        assert_eq!(clears, 3u64.saturating_sub(frame));
        run(&device, &queue, &mut pool, plan);
        assert_eq!(
            u64::from(pool.history("h").unwrap().frames),
            (frame + 1).min(3)
        );
    }
}

/// A history that only feeds itself is dead; one that is read lives through the reader.
/// `h@-1 -> step -> h` (nobody else)
#[test]
fn a_history_that_only_feeds_itself_is_dead() {
    let (_, _, k, pool) = setup();
    let mut fg = pool.frame(FRAME);
    let h = fg.history_texture("h", R32, 1, First::Clear([0.0; 4]));
    increment(&mut fg, &k, "step", h.previous[0].unwrap(), h.current);
    let plan = fg.compile().unwrap();
    assert!(plan.order().is_empty());
    assert_eq!(
        plan.warnings().len(),
        1,
        "the stand-in is not warned of: {:?}",
        plan.warnings()
    );

    let mut fg = pool.frame(FRAME);
    let h = fg.history_texture("h", R32, 1, First::Clear([0.0; 4]));
    look(&mut fg, &k, "look", h.previous[0].unwrap());
    increment(&mut fg, &k, "step", h.previous[0].unwrap(), h.current);
    assert_eq!(fg.compile().unwrap().order(), [0, 1, 2]);
}

/// Frames that read and do not write leave the history as it is, and say so.
#[test]
fn an_unwritten_history_stays() {
    let (device, queue, k, mut pool) = setup();
    let plan = temporal(&pool, &k, FRAME, First::Clear([0.0; 4]));
    run(&device, &queue, &mut pool, plan);
    let before = pool.history("h");
    let mut fg = pool.frame(FrameParams { frame: 1, ..FRAME });
    let h = fg.history_texture("h", R32, 1, First::Clear([0.0; 4]));
    look(&mut fg, &k, "look", h.previous[0].unwrap());
    let plan = fg.compile().unwrap();
    assert_eq!(
        plan.warnings()[0].to_string().lines().next().unwrap(),
        "warning[FG103]: the history `h` is read and not written: it stays as it is"
    );
    run(&device, &queue, &mut pool, plan);
    assert_eq!(pool.history("h"), before);
}

/// A part left unwritten would be read as stale content by a later frame.
#[test]
fn a_partly_written_history_is_an_error() {
    let (_, _, k, pool) = setup();
    let mut fg = pool.frame(FRAME);
    let h = fg.history_texture("h", R32.with_mips(2), 1, First::Clear([0.0; 4]));
    produce(&mut fg, &k, "mip 0", h.current.mip(0));
    fg.history_texture("h", R32, 1, First::Skip);
    let errors = fg.compile().err().unwrap();
    let codes: Vec<_> = errors.iter().map(|e| e.code).collect();
    assert_eq!(codes, [Code::DuplicateKey, Code::PartialHistory]);
}

/// Plans that no longer fit the pool are refused.
#[test]
fn outdated_plans_are_refused() {
    let (device, queue, k, mut pool) = setup();
    let clear = First::Clear([0.0; 4]);
    let (one, two) = (
        temporal(&pool, &k, FRAME, clear),
        temporal(&pool, &k, FRAME, clear),
    );
    run(&device, &queue, &mut pool, one);
    let mut encoder = device.create_command_encoder(&Default::default());
    assert_eq!(
        two.encode(&mut encoder, &mut pool),
        Err(EncodeError::Outdated)
    );
    let plan = temporal(&pool, &k, FRAME, clear);
    let mut other = Pool::new(&device, &queue);
    assert_eq!(
        plan.encode(&mut encoder, &mut other),
        Err(EncodeError::OtherPool)
    );
}

/// Looking at a history with more usage than it was made with keeps its contents and state.
#[test]
fn more_usage_resets_nothing() {
    let (device, queue, k, mut pool) = setup();
    let plan = temporal(&pool, &k, FRAME, First::Clear([0.0; 4]));
    run(&device, &queue, &mut pool, plan);
    let mut fg = pool.frame(FrameParams { frame: 1, ..FRAME });
    let desc = R32.with_usage(wgpu::TextureUsages::RENDER_ATTACHMENT);
    let h = fg.history_texture("h", desc, 1, First::Clear([0.0; 4]));
    let out = increment(&mut fg, &k, "step", h.previous[0].unwrap(), h.current);
    fg.export_texture("h", out);
    let plan = fg.compile().unwrap();
    assert!(plan.steps().iter().all(|s| s.kind != StepKind::Clear));
    run(&device, &queue, &mut pool, plan);
    assert_eq!(pool.history("h").unwrap().since, 0);
}

/// A graph resets a history that it declares afterwards; one that it does not declare, for the frame that
/// does. `First::Skip` then leaves a gap, and it can be read where the gap is and why.
/// `h@-1, h@-2 -> look; produce -> h` in every frame but the fourth
#[test]
fn gaps_and_their_reasons_are_readable() {
    let (device, queue, k, mut pool) = setup();
    let mut frame = |frame: u64, reset: Option<&str>, declare: bool| {
        let mut fg = pool.frame(FrameParams { frame, ..FRAME });
        if let Some(reason) = reset {
            fg.reset_history("h", reason);
        }
        let mut there = Vec::new();
        if declare {
            let h = fg.history_texture("h", R32, 2, First::Skip);
            for previous in h.previous.iter() {
                there.push(previous.is_some());
                previous.iter().for_each(|p| look(&mut fg, &k, "look", *p));
            }
            produce(&mut fg, &k, "produce", h.current);
        }
        let plan = fg.compile().unwrap();
        run(&device, &queue, &mut pool, plan);
        (there, pool.history("h").unwrap())
    };
    assert_eq!(frame(0, None, true).0, [false, false]);
    assert_eq!(frame(1, None, true).0, [true, false]);
    let (there, info) = frame(2, None, true);
    assert_eq!((there, info.numbers), (vec![true, true], vec![2, 1]));
    frame(3, None, false);
    let (there, info) = frame(4, None, true);
    assert_eq!(
        (there, info.numbers),
        (vec![true, true], vec![4, 2]),
        "3 did not write it"
    );
    let (there, info) = frame(5, Some("camera cut"), true);
    assert_eq!((there, info.numbers), (vec![false, false], vec![5]));
    let (_, info) = frame(6, Some("new scene"), false);
    assert_eq!((info.frames, info.numbers), (0, vec![]));
    let (there, info) = frame(7, None, true);
    assert_eq!((there, &info.numbers), (vec![false, false], &vec![7]));
    let why: Vec<String> = info
        .resets
        .iter()
        .map(|(n, r)| format!("{n} {r}"))
        .collect();
    assert_eq!(
        why,
        ["0 first frame", "5 asked: camera cut", "7 asked: new scene"]
    );
    for n in 8..20 {
        frame(n, Some("again"), true);
    }
    let (_, info) = frame(20, None, true);
    assert_eq!(
        (info.resets.len(), info.resets[7].0, info.since),
        (8, 19, 19)
    );
}
