//! What looks wrong in a log is told.

use crate::log::{COLUMNS, Logged, PITCH_M, encoder, warned};

/// Each wrong statement, and what the warning names.
#[test]
fn what_looks_wrong_is_told_with_the_option_that_mends_it() {
    let rows = encoder();
    for (columns, wanted) in [
        (
            ["t_s=time", "q1s=sin", "q1c=cos", "ref_x_m=stage:m"],
            "--column ref_x_m=stage:mm",
        ),
        (
            ["t_s=time", "q1s=sin", "q1c=cos", "ref_x_m=stage:um"],
            "--column ref_x_m=stage:mm",
        ),
        (
            ["t_s=time", "q1s=sin", "q1c=cos", "ref_x_m=stage:mm*-1"],
            "counts down where ref_x_m rises; --column ref_x_m=stage:mm if",
        ),
        (
            ["t_s=time", "q1s=cos", "q1c=sin", "ref_x_m=stage:mm"],
            "exchange the columns of q1s and q1c",
        ),
        (
            ["t_s=time", "q1s=sin", "q1c=sin", "ref_x_m=stage:mm"],
            "on no circle",
        ),
        (
            ["t_s=time:h", "q1s=sin", "q1c=cos", "ref_x_m=stage:mm"],
            "--column t_s=time:UNIT",
        ),
    ] {
        let told = warned(&rows, &columns);
        assert!(told.contains(wanted), "{columns:?}: {told}");
    }
    let off: Vec<Logged> = rows
        .iter()
        .map(|[t_s, s, c, x]| [*t_s, *s, *c, x * 1.01])
        .collect();
    let told = warned(&off, &COLUMNS);
    assert!(
        told.contains("% further than ref_x_m; --pitch 0.00101m"),
        "{told}"
    );
    // A stage of another axis: as far, a quarter of a period later.
    let other: Vec<Logged> = rows
        .iter()
        .map(|[t_s, s, c, _]| [*t_s, *s, *c, 5.0 * PITCH_M * (0.8 * t_s).cos()])
        .collect();
    let told = warned(&other, &COLUMNS);
    assert!(told.contains("segment 1 does not follow ref_x_m"), "{told}");
    let mut gap = rows.clone();
    gap.drain(1000..1100);
    assert!(warned(&gap, &COLUMNS).contains("time jumps at 1 rows, the first row 1002"));
}
