//! What a demonstration found, as text for a terminal.

use crate::Report;
use crate::joint::JointReport;
use command_line::terminal::{figure, micrometres, table};
use courier_sensor::calibration::joint::StepReport;

/// Section 3.2.1.
pub fn joint_text(report: &JointReport) -> String {
    let cell = |value: Option<f64>| value.map_or("-".to_owned(), figure);
    let rows: Vec<Vec<String>> = report
        .rows
        .iter()
        .map(|row| {
            vec![
                row.words.to_owned(),
                row.unit.to_owned(),
                figure(row.paper),
                cell(row.here),
                cell(row.paper_method),
            ]
        })
        .collect();
    let preset = format!("{:?}", report.preset).to_lowercase();
    let title = format!(
        "courier `{preset}`, seed {}: {} poses fitted under the beacon; {} synthetic problems",
        report.seed, report.poses, report.synthetic_problems
    );
    let told = |step: &StepReport| {
        format!(
            "{:?} {}",
            step.step,
            if step.accepted {
                "accepted"
            } else {
                "reverted"
            }
        )
    };
    let steps: Vec<String> = report.steps.iter().map(told).collect();
    let verdict = match &report.refusal {
        None => format!("accepted and stored: {}", steps.join(", ")),
        Some(why) => format!("REFUSED: {why}; the calibration in force before stays"),
    };
    let note = map_note(report);
    let [place_here, place_paper] = report.synthetic_place_um.map(figure);
    let place = format!(
        "synthetic, beacon's place and angle offset: {place_here} µm here, {place_paper} µm by the paper's method"
    );
    let alone = report.without_map.map_or("-".to_owned(), |flown| {
        let [x, y] = [flown.theta_x_mrad, flown.theta_y_mrad].map(figure);
        format!(
            "{} µm, θ_x {x} mrad, θ_y {y} mrad",
            figure(flown.position_um)
        )
    });
    let alone = format!("the same fly-by before the tooth map: {alone}");
    let hidden = report.theta_x_answer_uncalibrated.map_or(String::new(), |answer| {
        let answer = figure(answer);
        format!("\nbefore calibration segments 1 and 3 answer {answer} of a rotation on this line, and of teeth and lateral waves alike")
    });
    let table = table(
        &["section 3.2.1", "unit", "paper", "here", "paper's method"],
        &rows,
    );
    format!("{title}\n{verdict}\n{table}\n{place}\n{alone}{hidden}\n{note}")
}

/// What came of the tooth map.
fn map_note(report: &JointReport) -> String {
    let Some(map) = &report.map else {
        let why = report.map_refusal.as_ref().map(|why| format!(": {why}"));
        return "no tooth map".to_owned() + &why.unwrap_or_default();
    };
    let [before, after] = [map.before_m, map.after_m].map(|g| g.map(micrometres).join(", "));
    let [x, y] = map.way_deviation_m.map(micrometres);
    let [_, [theta_x, theta_y]] = map
        .way_angle_deviation_rad
        .map(|pair| pair.map(|rad| figure(1.0e3 * rad)));
    let way = format!(
        "predicted deviation of a position along x, y {x}, {y} µm, of θ_x, θ_y on a way along y {theta_x}, {theta_y} mrad"
    );
    let outside = report.outside_map.map_or(String::new(), |share| {
        format!(
            "; {} % of the fly-by outside its trusted cells",
            figure(100.0 * share)
        )
    });
    format!(
        "tooth map in force: held-out g_p, g_x, g_y {before} -> {after} µm over {} poses; {way}{outside}",
        map.held_out_poses
    )
}

/// Section 3.1.2.
pub fn text(report: &Report) -> String {
    let rows: Vec<Vec<String>> = report
        .rows
        .iter()
        .map(|row| {
            let here = row.here.map_or("-".to_owned(), figure);
            vec![
                row.words.to_owned(),
                row.unit.to_owned(),
                format!("{:.1}", row.paper),
                here,
            ]
        })
        .collect();
    let preset = format!("{:?}", report.preset).to_lowercase();
    let [before, after] = report.held_out_residual_um;
    let verdict = match &report.refusal {
        None => format!(
            "accepted: held-out g_p residual {before:.2} -> {after:.2} µm; stored, and in force after a restart"
        ),
        Some(why) => format!("REFUSED: {why}; the calibration in force before stays"),
    };
    let title = format!(
        "courier `{preset}`, seed {}: {} poses fitted",
        report.seed, report.poses
    );
    format!(
        "{title}\n{verdict}\n{}",
        table(&["section 3.1.2", "unit", "paper", "here"], &rows)
    )
}
