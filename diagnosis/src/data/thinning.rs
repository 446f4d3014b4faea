//! A very long recording: whole pieces tell as much as all of it, and the rest is let go before anything grows with it.

use crate::data::observations::Observations;

/// Samples that an answer is made of; of more, whole pieces are left out evenly. A bound on the work: an answer says so where it
/// leaves some out (`thin`), and 60,000 rows tell an rms to 0.3 %, far less than the 5 % from which a gap shows.
const MOST_FITTED_SAMPLES: usize = 60_000;
/// Samples in such a piece. Derived from the longest memory over neighbours, `MARGIN` at each end: a quarter of what is kept
/// besides serves neighbours alone.
const PIECE: usize = 250;
/// Samples to either side of a piece that stay to tell how it moves, and are used for nothing else: more than any window over
/// neighbours. Derived from the longest of them, 25 samples either way where a segment rests (`REST_HALF_WINDOW`).
const MARGIN: usize = 30;

/// Takes out what the answer is not made of. For each sample that stays: whether it does so for the sake of its neighbours only;
/// and what is to be said of it.
pub fn thin(observations: &mut Observations) -> (Vec<bool>, Option<String>) {
    let samples = observations.len();
    let every = samples.div_ceil(MOST_FITTED_SAMPLES).max(1);
    if every == 1 {
        return (vec![false; samples], None);
    }
    let used = |i: usize| {
        let piece = i / PIECE;
        // The place within each group of pieces changes, so that no period of the motion is missed.
        i < samples && (piece + piece / every).is_multiple_of(every)
    };
    let near = |i: usize| used(i) || used(i + MARGIN) || i >= MARGIN && used(i - MARGIN);
    let stays: Vec<bool> = (0..samples).map(near).collect();
    observations.retain(&stays);
    let margins: Vec<bool> = (0..samples)
        .filter(|i| stays[*i])
        .map(|i| !used(i))
        .collect();
    let count = margins.iter().filter(|m| !**m).count();
    let note = format!(
        "samples: of {samples} every part tells as much as the whole; {count} in pieces of {PIECE}, evenly over the recording, are what the answer is made of"
    );
    (margins, Some(note))
}
