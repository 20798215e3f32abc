//! Where things move: how late a picture follows its light, what ghosts remain, and how wrong it is where a surface has just come
//! into view, with `temporal-gradient` (svgf-dynamic) and without (svgf-2018).
//!
//! By default a light is switched at a small size. `SCUMBLE_FULL=1` makes the tables of `docs/measurements/moving.md` and leaves
//! frames to look at in the folder `scumble-moving` of the system's temporary files; `SCUMBLE_SHARED` names the folder with
//! `scenes/CesiumMan.glb`, without which only `moving` is measured.

mod player;
mod stage;

use player::{Player, Reference, Shot};
use scumble::Value;
use scumble_metrics::{
    FlickerMeter, Image, Mask, Metric, error_map, ghost_energy, lag, luminance, relmse, write_png,
};
use scumble_scene::Scene;
use stage::{Moves, man, moving, unlit};

const WITHOUT: &str = "svgf-2018.ron";
const WITH: &str = "svgf-dynamic.ron";
const WITH_SAMPLES: &str = "svgf-dynamic-samples.ron";

/// In the middle of everything that moves.
const TIME: f32 = 0.7;

/// Before anti-aliasing, which has a lag of its own.
const FILTERED: &str = "recombine.radiance";

/// A still scene whose lights are switched on (or off) once.
struct Switch {
    /// What is shown, and the same before anti-aliasing.
    frames: Vec<Image>,
    filtered: Vec<Image>,
    /// The first frame in another light.
    at: usize,
}

impl Switch {
    fn play(player: &mut Player, seed: u32, on: bool, [before, after]: [usize; 2]) -> Switch {
        player.begin(seed);
        let (mut frames, mut filtered) = (Vec::new(), Vec::new());
        for i in 0..before + after {
            frames.push(player.play(Shot {
                scene: usize::from((i >= before) == on),
                time: TIME,
            }));
            filtered.push(player.tapped(FILTERED));
        }
        Switch {
            frames,
            filtered,
            at: before,
        }
    }

    /// Frames until 90 % of the change are seen; both ends by the sequence's own last quarters.
    fn lag(&self, frames: &[Image]) -> Option<usize> {
        let means: Vec<f64> = frames.iter().map(mean_luminance).collect();
        let (before, after) = means.split_at(self.at);
        let end = |series: &[f64]| {
            let last = &series[3 * series.len() / 4..];
            last.iter().sum::<f64>() / last.len() as f64
        };
        lag(after, end(before), end(after), 0.9)
    }
}

fn mean_luminance(image: &Image) -> f64 {
    image.data.iter().map(|p| luminance(*p)).sum::<f64>() / image.data.len() as f64
}

/// Noise of a still scene: mean relMSE of the frames after a warm-up, and the deviation of a pixel's luminance over them.
fn noise(frames: &[Image], warm_up: usize, truth: &Image) -> [f64; 2] {
    let mut meter = FlickerMeter::new(warm_up);
    let mut error = 0.0;
    for (i, frame) in frames.iter().enumerate() {
        meter.push(frame).unwrap();
        if i >= warm_up {
            error += relmse(frame, truth).unwrap();
        }
    }
    let counted = frames.len() - warm_up;
    [error / counted as f64, meter.finish().unwrap().deviation]
}

#[test]
fn the_gradient_shortens_the_lag_and_leaves_a_still_picture_alone() {
    let (size, frames) = ([48, 27], [12, 20]);
    let scenes = [unlit(&moving()), moving()];
    let lit = Shot {
        scene: 1,
        time: TIME,
    };
    let truth = Reference::new(&scenes, size).of(lit, 64);
    let [without, with, samples] = [WITHOUT, WITH, WITH_SAMPLES].map(|graph| {
        let mut player = Player::new(graph, &scenes, size).tap(FILTERED);
        let [on, off] = [true, false].map(|on| Switch::play(&mut player, 1, on, frames));
        // Lit at first, and so until it is switched off.
        let noise = noise(&off.filtered[..frames[0]], 8, &truth);
        let lag = |switch: &Switch| switch.lag(&switch.filtered).unwrap();
        println!(
            "{graph}: on {}, off {}, relMSE and deviation {noise:?}",
            lag(&on),
            lag(&off)
        );
        ([lag(&on), lag(&off)], noise)
    });
    for i in 0..2 {
        // A blend of 0.2 goes 90 % of the way in 10 frames after the first, by its equation, whatever the scene. Noise moves the
        // crossing by a frame or two.
        assert!((8..=12).contains(&without.0[i]));
        // What is noise for the estimate is followed at that rate, and gradient samples weigh a change by its part of the light:
        // both are behind for some frames, but not for half as many.
        assert!(with.0[i] <= 4 && samples.0[i] <= 4);
        // Noise takes 8 % of the histories' weight (passes/tests/filters/temporal_gradient.rs). A blend of r has variance r / (2 - r): with
        // r from 0.2 to 0.26 it grows by 1.35, the deviation by 1.16, were nothing filtered in space; it grew by 1.09. Gradient samples
        // repeat the numbers of one pixel in nine, which then counts half: 1 / (1 - 1/18) of the variance, and a twentieth more.
        assert!(with.1[i] <= 1.16 * without.1[i]);
        assert!(samples.1[i] <= 1.11 * without.1[i]);
    }
}

/// What of docs/measurements/moving.md is to be made: nothing by default.
fn stages() -> Vec<(&'static str, Scene)> {
    if std::env::var_os("SCUMBLE_FULL").is_none_or(|v| v != "1") {
        return vec![];
    }
    let man = man().map(|scene| ("CesiumMan", scene));
    [("moving", moving())].into_iter().chain(man).collect()
}

#[test]
fn table_of_switches() {
    for (name, scene) in stages() {
        switches(name, &scene);
    }
}

#[test]
fn table_of_motion() {
    for (name, scene) in stages() {
        println!(
            "| {name} | graph | relMSE, new surfaces | relMSE, elsewhere | ghost of 8 frames ago |"
        );
        println!("|---|---|---|---|---|");
        let scenes = Moves::EACH.map(|moves| moves.of(&scene));
        let mut truth = Reference::new(&scenes, SIZE);
        let mut players = [WITHOUT, WITH].map(|graph| {
            let player = Player::new(graph, &scenes, SIZE);
            (title(graph), player.tap(FILTERED).tap("e/accumulate.age"))
        });
        for i in 0..scenes.len() {
            motion(name, i, &mut truth, &mut players);
        }
    }
}

// Of the tables.
const SIZE: [u32; 2] = [96, 54];
const SPP: u32 = 64;
const SEEDS: u32 = 2;

/// What is in the name of a graph.
fn title(graph: &str) -> &str {
    graph.trim_end_matches(".ron")
}

fn save(name: &str, image: &Image) {
    let folder = std::env::temp_dir().join("scumble-moving");
    std::fs::create_dir_all(&folder).unwrap();
    let toned = Image {
        data: image
            .data
            .iter()
            .map(|p| p.map(|c| c / (0.5 + c)))
            .collect(),
        ..image.clone()
    };
    write_png(folder.join(format!("{name}.png")), &toned.to_display()).unwrap();
}

fn switches(name: &str, scene: &Scene) {
    let scenes = [unlit(scene), scene.clone()];
    let mut reference = Reference::new(&scenes, SIZE);
    let truths = [0, 1].map(|scene| reference.of(Shot { scene, time: TIME }, SPP));
    let mut players = [WITHOUT, WITH, WITH_SAMPLES].map(|graph| {
        let player = Player::new(graph, &scenes, SIZE);
        (title(graph), player.tap(FILTERED))
    });
    let everywhere = Mask::of(&truths[0], |_| true);
    println!(
        "| {name} | lag of the filter | lag of what is shown | ghost, frames 0, 1, 2, 4, 8 | relMSE before | deviation before |"
    );
    println!("|---|---|---|---|---|---|");
    for (on, way) in [(true, "on"), (false, "off")] {
        for (graph, player) in &mut players {
            let (before, after) = (16, 24);
            let (mut lags, mut ghosts, mut still) = ([vec![], vec![]], [0.0; 5], [0.0; 2]);
            let [stale, now] = [&truths[usize::from(!on)], &truths[usize::from(on)]];
            for seed in 0..SEEDS {
                let switch = Switch::play(player, seed, on, [before, after]);
                for (lags, frames) in lags.iter_mut().zip([&switch.filtered, &switch.frames]) {
                    lags.push(switch.lag(frames).map_or("-".to_owned(), |n| n.to_string()));
                }
                for (ghost, i) in ghosts.iter_mut().zip([0, 1, 2, 4, 8]) {
                    let frame = &switch.filtered[before + i];
                    *ghost +=
                        ghost_energy(frame, now, stale, &everywhere).unwrap() / f64::from(SEEDS);
                    if seed == 0 {
                        save(&format!("{name}-{way}-{i}-{graph}"), frame);
                    }
                }
                let of_seed = noise(&switch.filtered[..before], 8, stale);
                (0..2).for_each(|i| still[i] += of_seed[i] / f64::from(SEEDS));
            }
            let ghosts = ghosts.map(|g| format!("{g:.3}")).join(", ");
            let [filtered, shown] = lags.map(|lags| lags.join(", "));
            let [error, deviation] = still;
            println!(
                "| {way}, `{graph}` | {filtered} | {shown} | {ghosts} | {error:.4} | {deviation:.4} |"
            );
        }
    }
}

/// Seventeen frames at 30 a second of one scene, judged at the last.
fn motion(name: &str, scene: usize, truth: &mut Reference, players: &mut [(&str, Player)]) {
    let moves = Moves::EACH[scene];
    let shot = |frame: u32| Shot {
        scene,
        time: TIME + frame as f32 / 30.0,
    };
    let [stale, now] = [8, 16].map(|frame| truth.of(shot(frame), SPP));
    save(&format!("{name}-{moves:?}-reference"), &now);
    let everywhere = Mask::of(&now, |_| true);
    let mut young = None;
    for (graph, player) in players {
        let (mut inside, mut outside, mut ghost) = (0.0, 0.0, 0.0);
        for seed in 0..SEEDS {
            player.begin(seed);
            (0..=16).for_each(|frame| player.render(shot(frame)));
            let last = player.tapped(FILTERED);
            // Which surfaces are new is the same for both, and does not depend on the seed.
            let age = player.tapped("e/accumulate.age");
            let young = young.get_or_insert_with(|| Mask::of(&age, |p| p[0] > 0.0 && p[0] <= 4.0));
            let map = error_map(Metric::RelMse, &last, &now).unwrap();
            let regions = map.regions(young).unwrap();
            inside += regions.inside.unwrap_or(0.0) / f64::from(SEEDS);
            outside += regions.outside.unwrap_or(0.0) / f64::from(SEEDS);
            ghost += ghost_energy(&last, &now, &stale, &everywhere).unwrap() / f64::from(SEEDS);
            if seed == 0 {
                save(&format!("{name}-{moves:?}-{graph}"), &last);
            }
        }
        let share = 100.0 * young.as_ref().map_or(0, Mask::count) as f64 / now.data.len() as f64;
        println!(
            "| {moves:?} | `{graph}` | {inside:.4} ({share:.1} %) | {outside:.4} | {ghost:.3} |"
        );
    }
}

#[test]
fn table_of_thresholds() {
    let Some((_, scene)) = stages().into_iter().next() else {
        return;
    };
    let scenes = [Moves::Light.of(&scene)];
    let shot = |frame: u32| Shot {
        scene: 0,
        time: TIME + frame as f32 / 30.0,
    };
    let mut truth = Reference::new(&scenes, SIZE);
    let [stale, now] = [8, 16].map(|frame| truth.of(shot(frame), 48));
    let everywhere = Mask::of(&now, |_| true);
    println!(
        "| noise_sigmas, change_sigmas, range | ghost | relMSE | relMSE, still | deviation, still |"
    );
    println!("|---|---|---|---|---|");
    let judge = |what: &str, player: &mut Player| {
        player.begin(0);
        (0..=16).for_each(|frame| player.render(shot(frame)));
        let last = player.tapped(FILTERED);
        let ghost = ghost_energy(&last, &now, &stale, &everywhere).unwrap();
        let moved = relmse(&last, &now).unwrap();
        player.begin(0);
        let still = [(); 14].map(|()| {
            player.render(shot(16));
            player.tapped(FILTERED)
        });
        let [error, deviation] = noise(&still, 8, &now);
        println!("| {what} | {ghost:.3} | {moved:.4} | {error:.4} | {deviation:.5} |");
    };
    let mut without = Player::new(WITHOUT, &scenes, SIZE).tap(FILTERED);
    judge("without the pass", &mut without);
    let mut with = Player::new(WITH, &scenes, SIZE).tap(FILTERED);
    for (low, high, range) in [(2.5, 5.0, 1), (1.5, 4.0, 1), (1.5, 4.0, 0), (1.0, 3.0, 1)] {
        with.tune("e/temporal-gradient.noise_sigmas", Value::Float(low));
        with.tune("e/temporal-gradient.change_sigmas", Value::Float(high));
        with.tune("e/temporal-gradient.range", Value::Int(range));
        judge(&format!("{low}, {high}, {range}"), &mut with);
    }
}
