//! Effects that do more than amounts of their usual sizes could, as the bend of a diode of quadrants does beside that of one which divides its
//! current: seen before anything is compared, since amounts of so many prior sizes are of no physical size.

use crate::design::assembly::{BlockKind, Design};
use crate::figures::limits::LARGEST_PRIOR_SIZES;
use crate::inference::residuals::Residuals;
use effects::Card;
use effects::sensor::NestedForms;

/// The forms of a recording with those of effects that do more in some channel, held out and each alone, than amounts of their sizes could; none
/// where no effect does. `before` is what the baseline alone leaves. Cost: a pass over the samples for each effect that has such a form.
pub(crate) fn far_forms(design: &Design, before: &Residuals) -> Option<NestedForms> {
    let mut forms = design.linearized.inputs.forms;
    for (k, kind) in design.kinds.iter().enumerate() {
        let BlockKind::Effect(name) = kind else {
            continue;
        };
        let far = effects::card(name).and_then(|card: &Card| card.far);
        if let Some(tell) = far.filter(|_| does_more(design, before, 1 + k)) {
            tell(&mut forms);
        }
    }
    (forms != design.linearized.inputs.forms).then_some(forms)
}

/// True if a block takes more of some channel than the largest of its amounts could.
fn does_more(design: &Design, before: &Residuals, block: usize) -> bool {
    let columns = design.columns.blocks[block].columns.clone();
    let sizes = columns.map(|c| design.columns.regressors[c].size_m);
    let largest_m = LARGEST_PRIOR_SIZES * sizes.fold(0.0, f64::max);
    let with = design.residuals(&[block]);
    let takes = |channel: usize| {
        let [before, after] = [before, &with].map(|r| r.channel_rms_m(channel).0);
        (before * before - after * after).max(0.0).sqrt()
    };
    before.channels().into_iter().any(|c| takes(c) > largest_m)
}
