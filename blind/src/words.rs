//! The scores in words: tables for the terminal and the page alike, each its header and its rows.

use crate::detection::Detection;
use crate::figure::Figure;
use crate::judged::Judged;
use crate::reliability::{Outcome, Reliability};
use crate::tally::Score;
use report::html::svg::short;

/// Header and rows.
pub type Words = (Vec<String>, Vec<Vec<String>>);

fn header(titles: &[&str]) -> Vec<String> {
    titles.iter().map(|t| (*t).to_owned()).collect()
}

/// A class of size.
pub(super) fn sizes(class: &Detection) -> String {
    format!(
        "{} to {} µm",
        short(1e6 * class.from_m),
        short(1e6 * class.to_m)
    )
}

/// Single effects by size: with a gap seen, and with the cause right.
#[must_use]
pub fn detection(score: &Score) -> Words {
    let rows = score.detection.iter().map(|d| {
        let counts = [d.cases, d.detected, d.named].map(|n| n.to_string());
        std::iter::once(sizes(d)).chain(counts).collect()
    });
    (
        header(&["one effect, rms", "cases", "gap seen", "cause right"]),
        rows.collect(),
    )
}

/// Right answers of all cases: effect by effect, and each by size; effects of no catalogue too, for which it is `unknown`.
#[must_use]
pub fn effects(score: &Score) -> Words {
    let titles = score.detection.iter().map(sizes);
    let titles = std::iter::once("right, by rms".to_owned())
        .chain(titles)
        .chain(["all".into()]);
    let share = |right: usize, of: usize| {
        if of == 0 {
            String::new()
        } else {
            format!("{right}/{of}")
        }
    };
    let rows = score.effects.iter().map(|(name, classes)| {
        let (right, of) = classes
            .iter()
            .fold((0, 0), |(r, n), c| (r + c.named, n + c.cases));
        let fields = classes.iter().map(|c| share(c.named, c.cases));
        std::iter::once(name.clone())
            .chain(fields)
            .chain([share(right, of)])
            .collect()
    });
    (titles.collect(), rows.collect())
}

/// The confusion matrix without its empty fields: what was answered to each truth, and how often.
#[must_use]
pub fn confusion(score: &Score) -> Words {
    let rows = score.confusion.iter().map(|(truth, answers)| {
        let mut list: Vec<(&String, &usize)> = answers.iter().collect();
        list.sort_by(|a, b| b.1.cmp(a.1));
        let told: Vec<String> = list
            .iter()
            .map(|(answer, n)| format!("{answer} {n}"))
            .collect();
        vec![
            truth.clone(),
            answers.values().sum::<usize>().to_string(),
            told.join(", "),
        ]
    });
    (header(&["truth", "cases", "answered"]), rows.collect())
}

/// Claimed against true shrinkage: what is spread over the cases, as quantiles.
#[must_use]
pub fn shrinkage(score: &Score) -> Words {
    let claims = || {
        score
            .judged
            .iter()
            .filter_map(|j: &Judged| j.claim.as_ref())
    };
    let percent = |v: f64| format!("{:.1} %", 100.0 * v);
    let ratio = |v: f64| format!("{v:.3}");
    let list: [(&str, Vec<f64>, &dyn Fn(f64) -> String); 4] = [
        (
            "squared gap closed, claimed",
            claims().filter_map(|c| Some(c.closed()?[0])).collect(),
            &percent,
        ),
        (
            "squared gap closed, on the second recording",
            claims().filter_map(|c| Some(c.closed()?[1])).collect(),
            &percent,
        ),
        (
            "gap after: claimed over confirmed",
            claims()
                .filter_map(|c| Some(c.claimed / c.confirmed?))
                .collect(),
            &ratio,
        ),
        (
            "gap after: claimed over best possible",
            claims().filter_map(|c| Some(c.claimed / c.best?)).collect(),
            &ratio,
        ),
    ];
    let rows = list
        .into_iter()
        .filter(|l| !l.1.is_empty())
        .map(|(name, mut values, told)| {
            values.sort_by(f64::total_cmp);
            let at =
                |share: f64| told(values[((values.len() - 1) as f64 * share).round() as usize]);
            vec![
                name.to_owned(),
                values.len().to_string(),
                at(0.05),
                at(0.5),
                at(0.95),
            ]
        });
    (
        header(&["shrinkage", "cases", "5 %", "median", "95 %"]),
        rows.collect(),
    )
}

/// All figures, and beside them what the stated probabilities are worth.
#[must_use]
pub fn figures(score: &Score) -> Words {
    let titles = [
        "figure",
        "measured",
        "95 % interval",
        "cases",
        "ideal observer",
        "wanted",
        "result",
    ];
    let rows = score.figures.iter().map(row);
    (
        header(&titles),
        rows.chain(of_reliability(&score.reliability)).collect(),
    )
}

/// Largest deviation of a tenth, and the log score.
fn of_reliability(of: &Reliability) -> [Vec<String>; 2] {
    let [low, high] = of.worst.as_ref().map_or([0.0, 1.0], |tenth| tenth.interval);
    let worst = of.worst.as_ref();
    let result = match of.outcome {
        Outcome::Reached => "reached",
        Outcome::NotReached => "not reached",
        Outcome::TooFewCases => "too few cases",
        Outcome::NotTried => "not tried",
    };
    let all = format!("{} of {}", of.right, of.named);
    let deviation = [
        "probability of a cause: largest deviation of a tenth".into(),
        worst.map_or("none".into(), |tenth| format!("{:+.3}", tenth.deviation)),
        format!("{low:+.3} to {high:+.3}"),
        worst.map_or("0 of 0".into(), |tenth| {
            format!("{} of {}", tenth.right, tenth.named)
        }),
        String::new(),
        format!("≤ {:.3}", of.wanted),
        result.into(),
    ];
    let score = [
        "probability of a cause: mean log score; of the share that is true".into(),
        format!("{:.3}; {:.3}", of.log_score, of.base_log_score),
        String::new(),
        all,
        String::new(),
        String::new(),
        String::new(),
    ];
    [deviation.to_vec(), score.to_vec()]
}

/// The stated probabilities, tenth by tenth, beside what is true.
#[must_use]
pub fn reliability(score: &Score) -> Words {
    let rows = score.reliability.tenths.iter().map(|tenth| {
        let [low, high] = tenth.interval;
        vec![
            format!("{:.1} to {:.1}", tenth.from, tenth.to),
            tenth.named.to_string(),
            tenth.right.to_string(),
            format!("{:.3}", tenth.stated),
            format!("{:+.3}", tenth.deviation),
            format!("{low:+.3} to {high:+.3}"),
        ]
    });
    let titles = [
        "stated probability",
        "causes",
        "true",
        "mean stated",
        "deviation",
        "95 % interval",
    ];
    (header(&titles), rows.collect())
}

/// One figure in words.
fn row(figure: &Figure) -> Vec<String> {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let [low, high] = figure.interval;
    vec![
        figure.name.clone(),
        figure.share().map_or("none".into(), percent),
        format!("{:.0} to {:.0} %", 100.0 * low, 100.0 * high),
        format!("{} of {}", figure.count, figure.of),
        figure.ideal.map_or(String::new(), percent),
        format!(
            "{} {}",
            if figure.at_least { "≥" } else { "≤" },
            percent(figure.wanted)
        ),
        if figure.of == 0 {
            "not tried"
        } else if figure.reached() {
            "reached"
        } else {
            "not reached"
        }
        .into(),
    ]
}

/// The confusion matrix as a table: only answers that were given.
pub fn matrix(score: &Score) -> Words {
    let mut answers: Vec<&String> = score
        .confusion
        .values()
        .flat_map(|row| row.keys())
        .collect();
    answers.sort();
    answers.dedup();
    let header = std::iter::once("truth".to_owned())
        .chain(answers.iter().map(|a| (*a).clone()))
        .collect();
    let rows = score.confusion.iter().map(|(truth, row)| {
        let counts = answers
            .iter()
            .map(|a| row.get(*a).map_or(String::new(), ToString::to_string));
        std::iter::once(truth.clone()).chain(counts).collect()
    });
    (header, rows.collect())
}
