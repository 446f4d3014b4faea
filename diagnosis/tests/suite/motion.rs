//! What is told of a sample's motion must not hold that sample's own noise.
use specimens::{Case, Conditions, rig};

use diagnosis::data::adequacy::overstated;
use diagnosis::data::motion::Motion;
use diagnosis::data::observations::Observations;
use diagnosis::data::play_operator::{EVEN_M, GRADUAL_M, PlayOperator};
use diagnosis::design::gram::Columns;
use diagnosis::linearization::baseline::Baseline;
use diagnosis::linearization::recording::{LatentDisplacement, LinearizedRecording};
use diagnosis::linearization::relinearized::{at_fixed_point, displacement};
use diagnosis::{Options, diagnose};

/// A column made of a sample's own noise would rebuild the residual held out as well: a false alarm "speed".
#[test]
fn speed_and_acceleration_are_the_neighbours() {
    let options = rig::Options {
        samples: 4000,
        ..rig::Options::default()
    };
    let mut clean = Observations::new(&rig::record(43, &[], &options).0).unwrap();
    // Segment 1 gathers speed, 5 m/s² throughout, with 0.1 µm of noise.
    let mut dice = rig::Dice(5);
    let mut start_s = 0.0;
    for i in 0..clean.len() {
        if i == 0 || clean.stretch[i] != clean.stretch[i - 1] {
            start_s = clean.t_s[i];
        }
        clean.position_m[0][i] = 2.5 * (clean.t_s[i] - start_s).powi(2) + 0.1e-6 * dice.normal();
    }
    let motion = Motion::new(&clean, &clean.position_m);
    let moving: Vec<usize> = (0..clean.len())
        .filter(|&i| motion.acceleration_m_s2[0][i] != 0.0 && motion.speed_m_s[0][i] != 0.0)
        .step_by(7)
        .collect();
    assert!(moving.len() > 50);
    let mut compared = 0;
    for i in moving {
        let mut other = clean.clone();
        other.position_m[0][i] += 0.3e-6;
        let moved = Motion::new(&other, &other.position_m);
        let (before, after) = (&motion.acceleration_m_s2[0], &moved.acceleration_m_s2[0]);
        assert!((motion.speed_m_s[0][i] - moved.speed_m_s[0][i]).abs() < 1.0e-9);
        // A larger misfit may call the same curvature noise, and it is then zero.
        if after[i] != 0.0 {
            assert!((before[i] - after[i]).abs() < 1.0e-6 * before[i].abs());
            compared += 1;
        }
        if compared > 20 {
            break;
        }
    }
    assert!(compared > 10);
}

/// Around a turn the way back is within the noise for a good part of the time: it counts from where it began.
#[test]
fn a_turn_is_told_where_it_was() {
    let clean = Observations::new(&rig::record(43, &[], &rig::Options::default()).0).unwrap();
    let length = (0..clean.len())
        .take_while(|&i| clean.stretch[i] == clean.stretch[0])
        .count();
    let mut dice = rig::Dice(7);
    let leg = 400;
    // There and back over 2 mm along quintics, each leg at rest for a tenth of its time before it begins.
    let place_m = |i: usize| {
        let u = (((i % leg) as f64 / leg as f64 - 0.1) / 0.9).max(0.0);
        let s = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        2.0e-3 * if (i / leg) % 2 == 0 { s } else { 1.0 - s }
    };
    let position_m: Vec<f64> = (0..clean.len())
        .map(|i| place_m(i) + 0.3e-6 * dice.normal())
        .collect();
    let smooth = vec![true; clean.len()];
    let travel = PlayOperator::new(&position_m, &smooth, 0.2e-6, &clean);
    let (mut wrong, mut count) = (0u32, 0u32);
    for i in leg..length {
        let rests = i % leg < leg / 10;
        let way = if ((i - usize::from(rests) * leg) / leg) % 2 == 0 {
            1.0
        } else {
            -1.0
        };
        wrong += u32::from(travel.direction[i] != way);
        count += 1;
    }
    assert!(count > 1200, "{count}");
    // A dead band of eight misfits alone takes until 10 u³ is 1.6 µm of 2 mm, u = 0.043 of each leg: less than half of that.
    assert!(
        f64::from(wrong) < 0.5 * 0.043 * f64::from(count),
        "{wrong} of {count}"
    );
}

/// Between separate poses the way is the straight one, however short, as long as it is clear of the noise.
#[test]
fn a_short_way_between_poses_turns_the_memory_over_as_far_as_it_goes() {
    let clean = Observations::new(&rig::record(43, &[], &rig::Options::default()).0).unwrap();
    let separate = vec![false; clean.len()];
    let mut position_m = vec![0.0; clean.len()];
    // Far on, 6 µm back, then a tenth of a micrometre on: within a noise of 0.2 µm that is no way.
    for (i, step_m) in [2.0e-3, -6.0e-6, 0.1e-6].into_iter().enumerate() {
        position_m[i + 1] = position_m[i] + step_m;
    }
    let travel = PlayOperator::new(&position_m, &separate, 0.2e-6, &clean);
    assert_eq!(travel.direction[1..4], [1.0, -1.0, -1.0]);
    let gradual = GRADUAL_M.map(|m| -1.0 + 2.0 * (-6.0e-6 / m).exp());
    let even = EVEN_M.map(|m| f64::max(-1.0, 1.0 - 6.0e-6 / m));
    for (k, turned) in gradual.into_iter().chain(even).enumerate() {
        assert!((travel.memory[2][k] - turned).abs() < 1.0e-6);
        assert!((travel.memory[3][k] - turned).abs() < 0.05);
    }
}

/// Where an effect hides some micrometres of a way, the memory follows from the places without it.
#[test]
fn the_memory_follows_from_where_a_segment_is_known_to_be() {
    let recording = rig::record(43, &[], &rig::Options::default()).0;
    let observations = Observations::new(&recording).unwrap();
    let baseline = Baseline::nominal(&observations);
    let linearized = LinearizedRecording::new(
        &observations,
        baseline.clone(),
        vec![true; observations.len()],
    );
    // Each sample of segment 2 is off by up to 10 µm, one way and the other.
    let off = |i: usize| 10.0e-6 * (i as f64).sin();
    let mut displacement = LatentDisplacement::default();
    displacement.total_m[1] = (0..linearized.len()).map(off).collect();
    let known = linearized.moved(baseline, displacement);
    let place_m: Vec<f64> = (0..linearized.len())
        .map(|i| linearized.calibrated_m[1][i] + off(i))
        .collect();
    let mut told = Motion::new(&observations, &linearized.calibrated_m);
    let way = told.retraced(1, &place_m, 1.0, &observations);
    told.follow(1, way);
    assert_eq!(known.motion.memory[1], told.memory[1]);
    assert_ne!(known.motion.memory[1], linearized.motion.memory[1]);
    assert_eq!(known.motion.memory[0], linearized.motion.memory[0]);
}

/// Where an effect hides a segment's place, the others tell most of it, and it is known how much of their noise comes along.
#[test]
fn what_one_segment_hides_of_its_place_the_others_tell() {
    let recording = rig::record(43, &[], &rig::Options::default()).0;
    let truth = Observations::new(&recording).unwrap();
    let constrained_positions = |o: &Observations| {
        LinearizedRecording::new(o, Baseline::nominal(o), vec![true; truth.len()])
            .constrained_positions()
    };
    let known = constrained_positions(&truth);
    let seen: Vec<usize> = (0..truth.len()).filter(|i| truth.sees_beacon(*i)).collect();
    assert!(seen.len() > 500 && seen.len() < truth.len());
    let off_m = |o: &Observations, samples: &mut dyn Iterator<Item = usize>| {
        let told = constrained_positions(o);
        rms(samples.map(|i| told.place_m[0][i] - known.place_m[0][i]))
    };

    let mut hidden = truth.clone();
    for (i, place_m) in hidden.position_m[0].iter_mut().enumerate() {
        *place_m += 3.0e-6 * (i as f64).sin().signum();
    }
    let hidden_m = off_m(&hidden, &mut seen.iter().copied());
    assert!(hidden_m < 1.5e-6, "{hidden_m}");

    let mut noisy = truth.clone();
    let mut dice = rig::Dice(11);
    let readings = noisy.position_m.iter_mut().chain(&mut noisy.tan_psi);
    let stated = truth.position_noise_m.iter().chain(&truth.tan_psi_noise);
    for (values, stated) in readings.zip(stated) {
        for (value, noise) in values.iter_mut().zip(stated) {
            *value += noise * dice.normal();
        }
    }
    let noise_m = off_m(&noisy, &mut (0..truth.len()));
    let stated_m = known.louder[0] * rms(truth.position_noise_m[0].iter().copied());
    assert!(
        (noise_m / stated_m - 1.0).abs() < 0.05,
        "{noise_m}, {stated_m}"
    );
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (count, squares) = values.fold((0.0, 0.0), |(n, sum), v| (n + 1.0, sum + v * v));
    f64::sqrt(squares / count)
}

/// Patterns add to a path's scatter and never take from it: a statement far above it is wrong.
#[test]
fn noise_of_a_segment_that_is_stated_too_large_is_told() {
    let (recording, _) = rig::record(43, &[], &rig::Options::default());
    let told = |observations: &Observations| {
        let baseline = Baseline::nominal(observations);
        let linearized =
            LinearizedRecording::new(observations, baseline, vec![true; observations.len()]);
        overstated(&linearized).map(|told| told.to_string())
    };
    let mut observations = Observations::new(&recording).unwrap();
    assert_eq!(told(&observations), None);
    for noise in &mut observations.position_noise_m[2] {
        *noise *= 100.0;
    }
    let told = told(&observations).expect("a segment's stated noise");
    assert!(told.contains("segment 3"), "{told}");
}

/// Samples as if none were apart from the next.
fn in_one_stretch() -> Observations {
    let recording = rig::record(43, &[], &rig::Options::default()).0;
    let mut observations = Observations::new(&recording).unwrap();
    observations.stretch.fill(0);
    observations.unbroken.fill(0);
    observations
}

/// What a way leaves in the memory by its own definition, sample for sample.
fn remembered(place_m: &[f64], turnover_m: f64) -> Vec<f64> {
    let mut memory = 0.0;
    let mut before_m = place_m[0];
    let mut after = |&here_m: &f64| {
        let way_m: f64 = here_m - before_m;
        before_m = here_m;
        let towards = way_m.signum();
        memory = towards + (memory - towards) * (-way_m.abs() / turnover_m).exp();
        memory
    };
    place_m.iter().map(&mut after).collect()
}

/// The state of a stop: what a spring holds that yields beyond one, `length_m` to one.
fn stopped(place_m: &[f64], length_m: f64) -> Vec<f64> {
    let mut state: f64 = 0.0;
    let mut before_m = place_m[0];
    let mut after = |&here_m: &f64| {
        state = (state + (here_m - before_m) / length_m).clamp(-1.0, 1.0);
        before_m = here_m;
        state
    };
    place_m.iter().map(&mut after).collect()
}

/// A segment that creeps on, and is shaken by 4 µm nearly four samples a turn on four fifths of its way: metres.
fn shaken(observations: &Observations) -> Vec<f64> {
    let at = |i: usize| {
        let still = i % 500 >= 400;
        let wave = if still { 0.0 } else { (1.55 * i as f64).sin() };
        5.0e-8 * i as f64 + 4.0e-6 * wave
    };
    (0..observations.len()).map(at).collect()
}

/// Neighbours tell nothing of a place between them where the courier is shaken that fast, and its shaking is no noise.
#[test]
fn the_memory_of_a_courier_that_is_shaken_is_that_of_its_way() {
    let mut observations = in_one_stretch();
    let clean_m = shaken(&observations);
    let mut dice = rig::Dice(9);
    observations.position_m = std::array::from_fn(|_| {
        let noisy = clean_m.iter().map(|p| p + 0.1e-6 * dice.normal());
        noisy.collect()
    });
    for noise in &mut observations.position_noise_m {
        noise.fill(0.1e-6);
    }
    let motion = Motion::new(&observations, &observations.position_m);
    let gradual = GRADUAL_M.map(|m| (m, remembered(&clean_m, m)));
    let even = EVEN_M.map(|m| (m, stopped(&clean_m, m)));
    for (k, (turnover_m, way)) in gradual.into_iter().chain(even).enumerate() {
        let off = |i: usize| (motion.memory[0][i][k] - way[i]).abs();
        let mean = (1000..way.len()).map(off).sum::<f64>() / (way.len() - 1000) as f64;
        // Noise of 0.1 µm moves the least of the memories by a few hundredths.
        assert!(mean < 0.04, "{turnover_m}: {mean}");
    }
}

fn columns_of(effect: &str, linearized: &LinearizedRecording) -> Columns {
    let sides = effects::sensor_sides();
    let side = sides.iter().find(|side| side.name() == effect);
    let mut columns = Columns::default();
    columns.push(
        effect,
        side.expect("an effect").regressors(&linearized.inputs),
    );
    columns
}

/// Where a segment is follows from what it remembers, and that from where it is. Where the memory turns over within less than the
/// effect itself, going all the way each round leads from one place to another and back.
#[test]
fn a_place_and_its_own_memory_agree() {
    let observations = swaying();
    let baseline = Baseline::nominal(&observations);
    let linearized =
        LinearizedRecording::new(&observations, baseline, vec![true; observations.len()]);
    let columns = columns_of("hysteresis", &linearized);
    let turned =
        |c: &usize| columns.regressors[*c].name == "direction turned over within 4 um, segment 1";
    let list: Vec<usize> = (0..columns.regressors.len()).filter(turned).collect();
    for amount_m in [5.0e-6, -3.0e-6] {
        let there = at_fixed_point(
            linearized.moved(linearized.baseline.clone(), LatentDisplacement::default()),
            &columns,
            &list,
            &[amount_m],
        );
        let next = displacement(&there, &columns, &list, &[amount_m]);
        let off = |i: usize| (next.total_m[0][i] - there.displacement.total_m[0][i]).abs();
        let mean_m = (0..there.len()).map(off).sum::<f64>() / there.len() as f64;
        assert!(mean_m < 0.02 * amount_m.abs(), "{amount_m}: {mean_m}");
    }
}

/// What a courier without errors reads that sways by some tens of micrometres in its place.
fn swaying() -> Observations {
    let mut out = in_one_stretch();
    let o = out.clone();
    for (s, position_m) in out.position_m.iter_mut().enumerate() {
        let sway = |i: usize, periods: f64| (i as f64 / periods).sin();
        let centre_m = |i| 40.0e-6 * sway(i, [57.0, 83.0][s % 2]);
        let turned_m = |i| [1.0, -1.0][s / 2] * 4.0e-6 * sway(i, 41.0);
        *position_m = (0..o.len()).map(|i| centre_m(i) + turned_m(i)).collect();
    }
    let baseline = Baseline::nominal(&o);
    let linearized = LinearizedRecording::new(&out, baseline, vec![true; o.len()]);
    let rows: Vec<_> = (0..o.len()).map(|i| linearized.rows(i)).collect();
    for (i, rows) in rows.iter().enumerate() {
        for row in 1..rows.count {
            let slopes = &rows.by_reading[row][4..];
            let square = slopes[0].powi(2) + slopes[1].powi(2);
            for (tan, slope) in out.tan_psi.iter_mut().zip(slopes) {
                tan[i] -= slope * rows.residual_m[row] / square;
            }
        }
    }
    out
}

/// Play that turns over faster than a segment goes back hides that it goes back at all; the beacon tells.
#[test]
fn a_way_that_all_segments_hide_is_told_by_the_beacon() {
    let truth = swaying();
    let baseline = Baseline::nominal(&truth);
    let linearized = |o| LinearizedRecording::new(o, baseline.clone(), vec![true; truth.len()]);
    let known = linearized(&truth);
    let columns = columns_of("hysteresis", &known);
    let play = |c: &usize| {
        let name = &columns.regressors[*c].name;
        name.starts_with("direction turned evenly over 12 um")
    };
    let list: Vec<usize> = (0..columns.regressors.len()).filter(play).collect();
    assert_eq!(list.len(), 4);
    // Within 12 um of the way back a segment goes on by 2 um.
    let amounts = [7.0e-6; 4];
    let hidden = displacement(&known, &columns, &list, &amounts).total_m;
    let mut seen_m = truth.clone();
    for (position_m, hidden_m) in seen_m.position_m.iter_mut().zip(&hidden) {
        for (position_m, hidden_m) in position_m.iter_mut().zip(hidden_m) {
            *position_m -= hidden_m;
        }
    }
    let there = at_fixed_point(linearized(&seen_m), &columns, &list, &amounts);
    let off = |i: usize| (0..4).map(move |s| (s, i));
    let with_beacon = (0..truth.len()).filter(|i| truth.sees_beacon(*i));
    let off_m = rms(with_beacon
        .flat_map(off)
        .map(|(s, i)| there.displacement.total_m[s][i] - hidden[s][i]));
    let all_m = rms(hidden[0].iter().copied());
    assert!(off_m < 0.2 * all_m, "{off_m} of {all_m}");
}

/// Shapes as steep as nine tenths of the way itself: the plain fixed point would take a hundred rounds to what a tenth of the noise
/// is of the first step.
#[test]
fn a_place_on_a_steep_shape_is_found() {
    let mut observations = in_one_stretch();
    observations.position_m[0] = (0..observations.len()).map(|i| 7.3e-6 * i as f64).collect();
    let baseline = Baseline::nominal(&observations);
    let linearized =
        LinearizedRecording::new(&observations, baseline, vec![true; observations.len()]);
    let columns = columns_of("extra_harmonics", &linearized);
    let list = [0];
    let pitch_m = observations.pitch_m;
    let linearized =
        || linearized.moved(linearized.baseline.clone(), LatentDisplacement::default());
    let per_metre = displacement(&linearized(), &columns, &list, &[1.0]);
    let largest = per_metre.total_m[0]
        .iter()
        .fold(0.0, |m: f64, v| m.max(v.abs()));
    assert!(largest > 0.0, "{}", columns.regressors[0].name);
    let order = 3.0;
    assert!(columns.regressors[0].name.contains("order 3"));
    for slope in [0.9, -0.9] {
        let amount = slope * pitch_m / (order * std::f64::consts::TAU) / largest;
        let there = at_fixed_point(linearized(), &columns, &list, &[amount]);
        let next = displacement(&there, &columns, &list, &[amount]);
        let off = |i: usize| (next.total_m[0][i] - there.displacement.total_m[0][i]).powi(2);
        let rms_m = ((0..there.len()).map(off).sum::<f64>() / there.len() as f64).sqrt();
        assert!(rms_m < 1.0e-8, "{slope}: {rms_m}");
    }
}

/// Noise is no way: a segment at rest keeps what it brought along, and one that went far has nothing of it.
#[test]
fn what_was_before_is_forgotten_on_the_way() {
    let clean = Observations::new(&rig::record(43, &[], &rig::Options::default()).0).unwrap();
    let smooth = vec![true; clean.len()];
    let mut dice = rig::Dice(3);
    let rest = 200;
    let place = |i: usize| 5.0e-6 * i.saturating_sub(rest) as f64;
    let position_m: Vec<f64> = (0..clean.len())
        .map(|i| place(i) + 0.1e-6 * dice.normal())
        .collect();
    let before = PlayOperator::new(&position_m, &smooth, 0.1e-6, &clean).before;
    assert_eq!(before[0], 1.0);
    assert!(before[rest - 10] > 0.9, "{}", before[rest - 10]);
    assert!(before[rest + 40] < 1e-3, "{}", before[rest + 40]);
}

/// Poses that are scattered over fifty pitches come to each place once: what a fine mesh leaves of the amplitudes that it has not seen says
/// little of whether they follow the place.
#[test]
fn a_gap_over_poses_that_are_far_apart_is_named() {
    let case = Case::draw(3, 6023, Conditions::Drawn);
    let truth: Vec<&str> = case.effects.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(truth, ["gap_variation"]);
    let told = diagnose(&case.recorded(0), "scattered", &Options::default());
    let named: Vec<&str> = told.effects.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(named, truth, "{:?}", told.unexplained.place);
}
