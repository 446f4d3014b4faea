//! What `check` mends or leaves aside, in a line each.

use crate::data::observations::Observations;
use crate::data::slips::Slip;

/// A tooth count that was set right.
pub fn slip(slip: &Slip, o: &Observations) -> String {
    let run = &o.run_names[o.run[slip.sample]];
    let which = if slip.sure {
        ""
    } else {
        ", or of the segment whose difference is the same"
    };
    format!(
        "n{}: off by {} teeth from sample {} of the recording on (run {run}){which}: set right",
        slip.segment + 1,
        slip.teeth,
        slip.sample
    )
}

/// Samples at the converter's rails.
pub fn stuck(stuck: &[bool]) -> Option<String> {
    let count = stuck.iter().filter(|s| **s).count();
    (count > 0).then(|| {
        format!(
            "at {count} of {} samples both channels of a pair stand at their rails and tell no place between them: left out",
            stuck.len()
        )
    })
}

/// Samples far outside of what the others leave.
pub fn far(far: &[bool]) -> Option<String> {
    let count = far.iter().filter(|f| **f).count();
    (count > 0).then(|| {
        format!(
            "{count} of {} samples stand far outside what their neighbours show: left out",
            far.len()
        )
    })
}
