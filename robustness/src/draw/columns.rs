//! What happens to columns: left out, empty here and there, constant, frozen, at the end of their range, time that is odd.

use super::chance::chance;
use effects::plant::SEGMENTS;
use effects::random::{ChaCha8Rng, index, log_uniform, normal, uniform};
use recording::{Recording, Row, Samples, unmodified_m};

/// A change of one row; the number is the row's.
type Change = Box<dyn FnMut(usize, &mut Row)>;

/// The same recording with columns as a stranger's log may have them.
pub fn changed(from: &Recording, rng: &mut ChaCha8Rng) -> Recording {
    let length = from.samples.len();
    let mut changes = vec![outputs(from.meta.geometry.pitch_m, rng), left_out(rng)];
    for _ in 0..index(rng, 4) {
        changes.push(one(length, rng));
    }
    let mut time = time(rng);
    let mut samples = Samples::default();
    let mut last_s = f64::NEG_INFINITY;
    for i in 0..length {
        let mut row = from.samples.row(i);
        changes.iter_mut().for_each(|change| change(i, &mut row));
        row.t_s = time(row.t_s).max(next_above(last_s));
        last_s = row.t_s;
        samples.push(&row);
    }
    Recording {
        samples,
        ..from.clone()
    }
}

fn next_above(time_s: f64) -> f64 {
    if time_s.is_finite() {
        time_s.next_up()
    } else {
        f64::NEG_INFINITY
    }
}

/// Counts with teeth, positions, or counts whose teeth nobody counted.
fn outputs(pitch_m: f64, rng: &mut ChaCha8Rng) -> Change {
    let of_segment: [usize; 4] = match index(rng, 8) {
        0 | 1 => [1; 4],
        2 => std::array::from_fn(|_| index(rng, 3)),
        _ => [0; 4],
    };
    Box::new(move |_, row| {
        for (segment, kind) in of_segment.iter().enumerate() {
            let pair = row.quadrature_counts[segment];
            if *kind == 1 {
                let teeth = row.teeth[segment].take();
                let read = pair.zip(teeth);
                row.position_m[segment] = read.map(|(pair, n)| unmodified_m(n, pair, pitch_m));
                row.quadrature_counts[segment] = None;
            } else if *kind == 2 {
                row.teeth[segment] = None;
            }
        }
    })
}

/// What a bench with one segment and a reference along it records.
pub fn of_one_segment(from: &Recording, segment: usize) -> Recording {
    let mut samples = Samples::default();
    for i in 0..from.samples.len() {
        let mut row = from.samples.row(i);
        for other in (0..SEGMENTS).filter(|s| *s != segment) {
            row.quadrature_counts[other] = None;
            row.teeth[other] = None;
        }
        row.electrode_counts = None;
        row.reference[1 - segment % 2] = None;
        samples.push(&row);
    }
    Recording {
        samples,
        ..from.clone()
    }
}

/// Columns that are not there at all.
fn left_out(rng: &mut ChaCha8Rng) -> Change {
    let segment_out: [bool; 4] = if chance(rng, 0.35) {
        std::array::from_fn(|_| chance(rng, 0.5))
    } else {
        [false; 4]
    };
    let [beacon, warmth] = [0.3, 0.3].map(|p| chance(rng, p));
    let commanded: [bool; 3] = std::array::from_fn(|_| chance(rng, 0.3));
    let reference: [bool; 3] = std::array::from_fn(|_| chance(rng, 0.2));
    Box::new(move |_, row| {
        for segment in (0..4).filter(|s| segment_out[*s]) {
            row.quadrature_counts[segment] = None;
            row.teeth[segment] = None;
            row.position_m[segment] = None;
        }
        if beacon {
            row.electrode_counts = None;
        }
        if warmth {
            row.temperature_c = None;
        }
        for axis in 0..3 {
            row.commanded[axis] = row.commanded[axis].filter(|_| !commanded[axis]);
            row.reference[axis] = row.reference[axis].filter(|_| !reference[axis]);
        }
    })
}

/// One kind of column in one row.
#[derive(Clone, Copy)]
enum Channel {
    Pair(usize),
    Teeth(usize),
    Position(usize),
    Electrodes,
    Temperature,
    Commanded(usize),
    Reference(usize),
}

impl Channel {
    fn draw(rng: &mut ChaCha8Rng) -> Self {
        match index(rng, 7) {
            0 => Self::Pair(index(rng, 4)),
            1 => Self::Teeth(index(rng, 4)),
            2 => Self::Position(index(rng, 4)),
            3 => Self::Electrodes,
            4 => Self::Temperature,
            5 => Self::Commanded(index(rng, 3)),
            _ => Self::Reference(index(rng, 3)),
        }
    }

    /// What `row` shows of it, put in place of what `into` shows.
    fn copy(self, row: &Row, into: &mut Row) {
        match self {
            Self::Pair(s) => into.quadrature_counts[s] = row.quadrature_counts[s],
            Self::Teeth(s) => into.teeth[s] = row.teeth[s],
            Self::Position(s) => into.position_m[s] = row.position_m[s],
            Self::Electrodes => into.electrode_counts = row.electrode_counts,
            Self::Temperature => into.temperature_c = row.temperature_c,
            Self::Commanded(axis) => into.commanded[axis] = row.commanded[axis],
            Self::Reference(axis) => into.reference[axis] = row.reference[axis],
        }
    }

    /// Every value of it changed where there is one.
    fn map(self, row: &mut Row, to: impl Fn(f64) -> f64) {
        let change = |value: &mut Option<f64>| *value = value.map(&to);
        match self {
            Self::Pair(s) => {
                row.quadrature_counts[s] = row.quadrature_counts[s].map(|pair| pair.map(&to));
            }
            Self::Teeth(s) => row.teeth[s] = row.teeth[s].map(|n| to(f64::from(n)) as i32),
            Self::Position(s) => change(&mut row.position_m[s]),
            Self::Electrodes => row.electrode_counts = row.electrode_counts.map(|e| e.map(&to)),
            Self::Temperature => change(&mut row.temperature_c),
            Self::Commanded(axis) => change(&mut row.commanded[axis]),
            Self::Reference(axis) => change(&mut row.reference[axis]),
        }
    }
}

/// One channel that is empty, frozen, constant, extreme, scaled or noisy over a part of the rows.
fn one(length: usize, rng: &mut ChaCha8Rng) -> Change {
    let channel = Channel::draw(rng);
    let from = if chance(rng, 0.5) {
        0
    } else {
        index(rng, length)
    };
    let to = if chance(rng, 0.5) {
        length
    } else {
        from + index(rng, length - from)
    };
    let within = move |i: usize| (from..to).contains(&i);
    match index(rng, 6) {
        0 => {
            let (every, share) = (1 + index(rng, 20), uniform(rng, 0.0, 1.0));
            let empty = move |i: usize| (i % every) as f64 >= share * every as f64;
            let nothing = Row::default();
            Box::new(move |i, row| {
                if within(i) && empty(i) {
                    channel.copy(&nothing, row);
                }
            })
        }
        1 => frozen(channel, within),
        2 => {
            let value = extreme(rng);
            Box::new(move |i, row| {
                if within(i) {
                    channel.map(row, |_| value);
                }
            })
        }
        3 => {
            let factor = log_uniform(rng, 1.0e-3, 1.0e3) * effects::random::sign(rng);
            Box::new(move |i, row| {
                if within(i) {
                    channel.map(row, |v| limited(v * factor));
                }
            })
        }
        4 => {
            let at = index(rng, length);
            let value = extreme(rng);
            Box::new(move |i, row| {
                if i == at {
                    channel.map(row, |_| value);
                }
            })
        }
        _ => {
            let (mut rng, size) = (effects::random::fork(rng), log_uniform(rng, 1.0e-6, 1.0e3));
            Box::new(move |i, row| {
                let noise = size * normal(&mut rng);
                if within(i) {
                    channel.map(row, |v| limited(v + noise));
                }
            })
        }
    }
}

/// Within the reader's range of every column but counts, whose range is the stated converter's.
fn limited(value: f64) -> f64 {
    value.clamp(-1.0e3, 1.0e3)
}

fn frozen(channel: Channel, within: impl Fn(usize) -> bool + 'static) -> Change {
    let mut held: Option<Row<'static>> = None;
    Box::new(move |i, row| {
        if within(i) {
            let first = *held.get_or_insert(Row { run: "", ..*row });
            channel.copy(&first, row);
        }
    })
}

/// Ends of ranges, and zero.
fn extreme(rng: &mut ChaCha8Rng) -> f64 {
    const VALUES: [f64; 10] = [
        0.0, -0.0, 1.0, -1.0, 32_767.0, -32_768.0, 1.0e3, -1.0e3, 1.0e-300, 273.0,
    ];
    VALUES[index(rng, VALUES.len())]
}

/// A clock: another unit, another start, jitter. Times stay in order by what [`changed`] does.
fn time(rng: &mut ChaCha8Rng) -> Box<dyn FnMut(f64) -> f64> {
    let factor = if chance(rng, 0.8) {
        1.0
    } else {
        log_uniform(rng, 1.0e-9, 1.0e4)
    };
    let start_s = if chance(rng, 0.8) {
        0.0
    } else {
        uniform(rng, -1.0e10, 1.0e10)
    };
    let jitter_s = if chance(rng, 0.8) {
        0.0
    } else {
        log_uniform(rng, 1.0e-6, 1.0)
    };
    let mut rng = effects::random::fork(rng);
    Box::new(move |t_s| start_s + factor * (t_s + jitter_s * normal(&mut rng)))
}
