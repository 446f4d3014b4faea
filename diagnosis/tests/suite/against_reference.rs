//! What segments show against a reference, of couriers and motions that are drawn.

use crate::confusion::names;
use diagnosis::{Options, diagnose};
use specimens::{Case, Conditions};

/// The answer names this, and leaves nothing else; `doubted` where it doubts the reference.
fn assert_named(case: &Case, wanted: &str, doubted: bool) {
    let d = diagnose(&case.recorded(0), "drawn", &Options::default());
    assert_eq!(names(&d), [wanted], "{:?}", d.verdict);
    assert!(d.held_out.whitened_after < 1.1, "{:?}", d.held_out);
    let doubt = |note: &String| note.contains("the reference's own");
    assert_eq!(d.notes.iter().any(doubt), doubted, "{:?}", d.notes);
}

/// Four segments over 60 mm, on rulings of which one is turned and the other's pitch is too small. Under a beacon only the difference of the pitches
/// shows, since its height takes up what both share; a reference tells either. With the difference alone half of this gap was left, and taken for
/// displaced teeth. A reference that is mounted askew would show the same, and the answer says so.
#[test]
fn rulings_are_told_by_four_segments() {
    assert_named(&Case::draw(55, 6055, Conditions::Drawn), "axis_skew", true);
}

/// Segments 1, 2 and 4 of a courier that turns by 17 mrad. Where its middle is along x, segment 1 alone tells, which sits half a span aside: that
/// follows the angle. Without the angle the place across the other pair's teeth was off by a sixth of a tooth, and what that left was taken for
/// displaced teeth as well.
#[test]
fn a_pair_of_which_one_segment_is_known_tells_the_middle() {
    assert_named(
        &Case::draw(6, 6055, Conditions::Drawn),
        "lateral_dependence",
        false,
    );
}
