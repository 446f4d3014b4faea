//! Names of motions: where one ends and the next begins.

use std::fmt;

/// What separates two runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Runs {
    /// The first of these that gives two motions: rests, reversals, four parts of equal duration.
    #[default]
    Found,
    /// A rest.
    Rests,
    /// A turn back.
    Reversals,
    /// Nothing: all is one motion.
    One,
    /// A further part of the whole duration.
    Parts,
}

impl fmt::Display for Runs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Found => "as found",
            Self::Rests => "rests",
            Self::Reversals => "reversals",
            Self::One => "none: one run",
            Self::Parts => "parts of equal duration",
        })
    }
}

/// A courier is at rest that moves less than this many pitches in [`REST_S`] …
const REST_PITCHES: f64 = 0.005;
/// … or less than this many times its noise.
const REST_NOISE: f64 = 8.0;
/// How long a rest is at least, seconds …
const REST_S: f64 = 0.1;
/// … and how many samples.
const REST_SAMPLES: usize = 10;
/// A turn back is one by this share of the whole way, and by at least [`REST_NOISE`] times the noise.
const TURN_SHARE: f64 = 0.05;
/// Parts of a motion that never rests nor turns: a diagnosis fits some and holds out others.
const PARTS: usize = 4;

/// Names of the runs of each sample, and the way by which they were found. `place` is where the segment or the reference is, pitches,
/// NaN where not measured; `noise` is that of a place, pitches.
#[must_use]
pub fn names(way: Runs, t_s: &[f64], place: &[f64], noise: f64) -> (Runs, Vec<String>) {
    match way {
        Runs::One => (way, vec!["one".to_owned(); t_s.len()]),
        Runs::Rests => (way, rests(t_s, place, noise)),
        Runs::Reversals => (way, reversals(place, noise)),
        Runs::Parts => (way, parts(t_s)),
        Runs::Found => {
            let ways = [
                (Runs::Rests, rests(t_s, place, noise)),
                (Runs::Reversals, reversals(place, noise)),
            ];
            let found = ways.into_iter().find(|(_, names)| motions(names) > 1);
            found.unwrap_or_else(|| (Runs::Parts, parts(t_s)))
        }
    }
}

fn motions(names: &[String]) -> usize {
    let mut different: Vec<&String> = names
        .iter()
        .filter(|name| !name.starts_with("rest"))
        .collect();
    different.dedup();
    different.len()
}

/// The last known place, for samples at which none was measured.
fn held(place: &[f64]) -> Vec<f64> {
    let mut last = place
        .iter()
        .copied()
        .find(|place| place.is_finite())
        .unwrap_or(0.0);
    let hold = |place: &f64| {
        if place.is_finite() {
            last = *place;
        }
        last
    };
    place.iter().map(hold).collect()
}

fn rests(t_s: &[f64], place: &[f64], noise: f64) -> Vec<String> {
    let place = held(place);
    let still = REST_PITCHES.max(REST_NOISE * noise);
    let mut at_rest = vec![false; place.len()];
    let mut start = 0;
    while start < place.len() {
        let end = stays(&place, start, still);
        let long = t_s[end - 1] - t_s[start] >= REST_S && end - start >= REST_SAMPLES;
        if long {
            at_rest[start..end].fill(true);
        }
        start = if long { end } else { start + 1 };
    }
    numbered(
        &at_rest
            .iter()
            .map(|rest| if *rest { "rest" } else { "move" })
            .collect::<Vec<_>>(),
    )
}

/// End of the samples from `start` on that stay within `width` of each other.
fn stays(place: &[f64], start: usize, width: f64) -> usize {
    let (mut low, mut high) = (place[start], place[start]);
    let moved = place[start..].iter().position(|place| {
        (low, high) = (low.min(*place), high.max(*place));
        high - low > width
    });
    moved.map_or(place.len(), |count| start + count)
}

fn reversals(place: &[f64], noise: f64) -> Vec<String> {
    let place = held(place);
    let (low, high) = place
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
            (low.min(*p), high.max(*p))
        });
    let turn = (TURN_SHARE * (high - low)).max(REST_NOISE * noise);
    let mut forward = vec![true; place.len()];
    // Where the present leg began, and the furthest that it came.
    let (mut start, mut furthest, mut direction) = (0, 0, 0.0);
    for index in 1..place.len() {
        if direction == 0.0 {
            let gone = place[index] - place[0];
            if gone.abs() > turn {
                direction = gone.signum();
            }
            furthest = index;
        } else if direction * (place[index] - place[furthest]) > 0.0 {
            furthest = index;
        } else if direction * (place[furthest] - place[index]) > turn {
            forward[start..=furthest].fill(direction > 0.0);
            (start, furthest, direction) = (furthest + 1, index, -direction);
        }
    }
    forward[start..].fill(direction >= 0.0);
    numbered(
        &forward
            .iter()
            .map(|forward| if *forward { "forward" } else { "back" })
            .collect::<Vec<_>>(),
    )
}

fn parts(t_s: &[f64]) -> Vec<String> {
    let (first, last) = (
        t_s.first().copied().unwrap_or(0.0),
        t_s.last().copied().unwrap_or(0.0),
    );
    let part = |t_s: &f64| {
        (((t_s - first) / (last - first).max(1.0e-12) * PARTS as f64) as usize).min(PARTS - 1)
    };
    t_s.iter()
        .map(|t_s| format!("part_{}", 1 + part(t_s)))
        .collect()
}

/// `move_1`, `rest_1`, `move_2`, … in order of appearance.
fn numbered(kinds: &[&str]) -> Vec<String> {
    let mut counts = std::collections::BTreeMap::new();
    let mut name = String::new();
    let mut before = "";
    let mut of = |kind: &&str| {
        if *kind != before {
            let count = counts.entry((*kind).to_owned()).or_insert(0_usize);
            *count += 1;
            name = format!("{kind}_{count}");
            before = kinds
                .iter()
                .find(|other| *other == kind)
                .copied()
                .unwrap_or("");
        }
        name.clone()
    };
    kinds.iter().map(&mut of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(names: &[String]) -> Vec<&str> {
        let mut order: Vec<&str> = names.iter().map(String::as_str).collect();
        order.dedup();
        order
    }

    /// Rest, three pitches there, rest, three back, at 1 kHz.
    fn there_and_back() -> (Vec<f64>, Vec<f64>) {
        let t_s: Vec<f64> = (0..2000).map(|k| f64::from(k) * 1.0e-3).collect();
        let place = |t_s: &f64| {
            3.0 * ((t_s - 0.3) / 0.5).clamp(0.0, 1.0) - 3.0 * ((t_s - 1.1) / 0.5).clamp(0.0, 1.0)
        };
        let place = t_s.iter().map(place).collect();
        (t_s, place)
    }

    #[test]
    fn rests_reversals_and_parts() {
        let (t_s, place) = there_and_back();
        let (way, names) = super::names(Runs::Found, &t_s, &place, 1e-4);
        assert_eq!(way, Runs::Rests);
        assert_eq!(
            order(&names),
            ["rest_1", "move_1", "rest_2", "move_2", "rest_3"]
        );
        let begins = names.iter().position(|name| name == "move_1").unwrap();
        assert!((295..=310).contains(&begins), "{begins}");
        let (_, names) = super::names(Runs::Reversals, &t_s, &place, 1e-4);
        assert_eq!(order(&names), ["forward_1", "back_1"]);
        let sweep: Vec<f64> = t_s.iter().map(|t_s| 10.0 * (5.0 * t_s).sin()).collect();
        let (way, names) = super::names(Runs::Found, &t_s, &sweep, 1e-4);
        assert_eq!((way, order(&names).len()), (Runs::Reversals, 4));
        let turning: Vec<f64> = t_s.iter().map(|t_s| 10.0 * t_s).collect();
        let (way, names) = super::names(Runs::Found, &t_s, &turning, 1e-4);
        assert_eq!((way, order(&names).len()), (Runs::Parts, 4));
        assert_eq!(
            order(&super::names(Runs::One, &t_s, &turning, 0.0).1),
            ["one"]
        );
    }

    #[test]
    fn a_rest_may_creep_and_be_noisy() {
        let (t_s, place) = there_and_back();
        let wanted = ["rest_1", "move_1", "rest_2", "move_2", "rest_3"];
        let noise = [0.02, -0.02].into_iter().cycle();
        let noisy: Vec<f64> = place.iter().zip(noise).map(|(p, n)| p + n).collect();
        let (_, names) = super::names(Runs::Rests, &t_s, &noisy, 0.01);
        assert_eq!(order(&names), wanted);
        let creeping: Vec<f64> = place.iter().zip(&t_s).map(|(p, t)| p + 0.002 * t).collect();
        let (_, names) = super::names(Runs::Rests, &t_s, &creeping, 0.0);
        assert_eq!(order(&names), wanted);
    }
}
