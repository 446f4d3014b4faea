//! The gap at a glance.

use super::{Figure, legend, micro, strings};
use crate::html::plots::{self, Bar, BarAxis, Group};
use crate::html::svg::{AFTER, Area, BEFORE, Drawn, plot, short, times};
use diagnosis::verdict::answer::{Diagnosis, Gap, HeldOutChannel};
use plotters::style::RGBColor;

/// The bars of what is left are drawn again, larger, where the longest of all is so many times the longest of them.
const ZOOMED: f64 = 4.0;
/// Least floor that lengths are divided by, m: far below any sensor's.
const LEAST_M: f64 = 1.0e-12;

/// Residual rms of each channel in multiples of its floor: of the recording, and with what is named.
pub fn gap(diagnosis: &Diagnosis) -> Figure {
    let channels: Vec<(&HeldOutChannel, &Gap)> = diagnosis
        .held_out
        .channels
        .iter()
        .zip(&diagnosis.gap)
        .collect();
    let named = !diagnosis.effects.is_empty();
    let longest = |bars: &dyn Fn(&HeldOutChannel, &Gap) -> Bar| {
        let ends = channels.iter().map(|(c, g)| bars(c, g).value);
        ends.fold(0.0, f64::max)
    };
    let zoom = named && longest(&before) > ZOOMED * longest(&after);
    let rows = channels.len();
    let draw = |area: &Area, narrow: bool| -> Drawn {
        let both = groups(&channels, |c, g| {
            let mut list = vec![before(c, g)];
            list.extend(named.then(|| after(c, g)));
            list
        });
        if !zoom {
            return draw_bars(area, narrow, &both, ALL);
        }
        let [main, other] = split(area, narrow, rows);
        let mut marks = draw_bars(&main, narrow, &both, ALL)?;
        let left = groups(&channels, |c, g| vec![after(c, g)]);
        marks.extend(draw_bars(&other, narrow, &left, LEFT)?);
        Ok(marks)
    };
    let [wide, narrow] = plots::heights(rows, 1 + usize::from(named));
    let further = if zoom {
        24 + plots::heights(rows, 1)[1]
    } else {
        0
    };
    let caption = caption(&channels, named);
    Figure {
        id: "gap",
        title: "The gap at a glance".into(),
        plots: plot(
            &format!("Bars of held-out residuals. {caption}"),
            [wide, narrow + further],
            draw,
        ),
        caption,
        legend: legend(named, ("interval", "95 % interval")),
        table: table(&channels, named),
    }
}

/// Beside each other on a desk, below each other on a phone.
fn split<'a>(area: &Area<'a>, narrow: bool, rows: usize) -> [Area<'a>; 2] {
    let (main, other) = if narrow {
        area.split_vertically(plots::heights(rows, 2)[1])
    } else {
        area.split_horizontally(560)
    };
    [main, other]
}

/// Titles of the axes of all bars, and of those of what is left.
const ALL: &str = "rms, multiples of the floor";
const LEFT: &str = "after alone, multiples of the floor";

fn draw_bars(area: &Area, narrow: bool, groups: &[Group], title: &str) -> Drawn {
    let axis = BarAxis {
        title,
        line: Some((1.0, "floor")),
    };
    plots::bars(area, narrow, groups, &axis)
}

fn groups(
    channels: &[(&HeldOutChannel, &Gap)],
    bars: impl Fn(&HeldOutChannel, &Gap) -> Vec<Bar>,
) -> Vec<Group> {
    let group = |(c, g): &(&HeldOutChannel, &Gap)| (c.channel.clone(), bars(c, g));
    channels.iter().map(group).collect()
}

fn before(channel: &HeldOutChannel, gap: &Gap) -> Bar {
    let interval = gap
        .excess_ci95_m
        .map(|e| with_excess(gap.simulated_rms_m, e));
    bar(channel, "before", channel.before_rms_m, interval, BEFORE)
}

fn after(channel: &HeldOutChannel, _: &Gap) -> Bar {
    let interval = channel.after_ci95_m;
    bar(channel, "after", channel.after_rms_m, interval, AFTER)
}

/// Rms in the recording of which the excess over the simulation is this: the excess is the root of the difference of squares, with its
/// sign.
fn with_excess(simulated_m: f64, excess_m: f64) -> f64 {
    let square = simulated_m.powi(2) + excess_m.abs() * excess_m;
    square.max(0.0).sqrt()
}

fn bar(
    channel: &HeldOutChannel,
    when: &str,
    rms_m: f64,
    ci95_m: [f64; 2],
    colour: RGBColor,
) -> Bar {
    let over = |value_m: f64| value_m / channel.floor_rms_m.max(LEAST_M);
    Bar {
        value: over(rms_m),
        was: None,
        interval: Some(ci95_m.map(over)).filter(|i| i.iter().all(|v| v.is_finite())),
        colour,
        label: format!("{} × = {} µm", times(over(rms_m)), micro(rms_m)),
        told: format!(
            "{} {when}: {} times the floor, {} µm rms (95 %: {} to {} µm); floor {} µm",
            channel.channel,
            short(over(rms_m)),
            micro(rms_m),
            micro(ci95_m[0]),
            micro(ci95_m[1]),
            micro(channel.floor_rms_m)
        ),
    }
}

fn caption(channels: &[(&HeldOutChannel, &Gap)], named: bool) -> String {
    let one = |(c, _): &(&HeldOutChannel, &Gap)| {
        let before = micro(c.before_rms_m);
        let told = if named {
            format!("{before} µm before, {} µm after", micro(c.after_rms_m))
        } else {
            format!("{before} µm")
        };
        format!("{}: {told}, floor {} µm", c.channel, micro(c.floor_rms_m))
    };
    let list: Vec<String> = channels.iter().map(one).collect();
    format!("{}.", list.join("; "))
}

fn table(channels: &[(&HeldOutChannel, &Gap)], named: bool) -> (Vec<String>, Vec<Vec<String>>) {
    let to = |of: [f64; 2]| format!("{} to {}", micro(of[0]), micro(of[1]));
    let row = |(c, g): &(&HeldOutChannel, &Gap)| {
        let mut row = vec![
            c.channel.clone(),
            g.samples.to_string(),
            micro(c.before_rms_m),
            micro(c.floor_rms_m),
            format!("{} ({})", micro(g.excess_rms_m), to(g.excess_ci95_m)),
        ];
        if named {
            row.push(format!("{} ({})", micro(c.after_rms_m), to(c.after_ci95_m)));
        }
        row
    };
    let mut header = strings([
        "channel",
        "samples",
        "recording, µm rms",
        "floor, µm rms",
        "excess (95 %), µm",
    ]);
    header.extend(named.then(|| "after (95 %), µm rms".to_owned()));
    (header, channels.iter().map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_excess_leads_back_to_the_rms_that_it_came_of() {
        assert!((with_excess(0.3, 0.4) - 0.5).abs() < 1e-12);
        assert!((with_excess(0.5, -0.4) - 0.3).abs() < 1e-12);
        assert_eq!(with_excess(0.1, -0.4), 0.0);
    }
}
