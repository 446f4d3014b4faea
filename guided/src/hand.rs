//! A motion in words, for couriers that are moved by hand.

use crate::motion::{Move, SPEEDS_M_S};

/// Steps of less than this are not told, m and rad. A prior: no hand keeps to them.
const UNTOLD_M: f64 = 0.5e-3;
/// See [`UNTOLD_M`].
const UNTOLD_RAD: f64 = 1.0e-3;

/// The motion in words: which way, how far, how fast. Left is the turn against the clock, seen from above.
#[must_use]
pub fn words(go: &Move) -> String {
    told(go, "")
}

/// What a hand is to do: which way, how far, how fast. Left is the turn against the clock, seen from above.
#[must_use]
pub fn order(go: &Move) -> String {
    told(go, " by hand")
}

fn told(go: &Move, by_hand: &str) -> String {
    let (dx, dy) = (go.to.x_m - go.from.x_m, go.to.y_m - go.from.y_m);
    let turn = go.to.theta_rad - go.from.theta_rad;
    let mut parts = Vec::new();
    let along = |by: f64, axis: &str| {
        let sign = if by > 0.0 { '+' } else { '-' };
        format!("{:.0} mm along {sign}{axis}", 1.0e3 * by.abs())
    };
    let ways: Vec<String> = [(dx, "x"), (dy, "y")]
        .into_iter()
        .filter(|(by, _)| by.abs() > UNTOLD_M)
        .map(|(by, axis)| along(by, axis))
        .collect();
    if !ways.is_empty() {
        parts.push(format!("push it {} in a straight line", ways.join(" and ")));
    }
    if turn.abs() > UNTOLD_RAD {
        let side = if turn > 0.0 { "left" } else { "right" };
        let degrees = turn.abs().to_degrees();
        let on_the_way = if parts.is_empty() {
            "turn it"
        } else {
            "turning it"
        };
        parts.push(format!("{on_the_way} {degrees:.1} degrees to the {side}"));
    }
    if parts.is_empty() {
        return format!("keep it still for {:.1} s", go.seconds());
    }
    format!(
        "{}{by_hand}, {} ({:.1} s)",
        parts.join(", "),
        pace(go.speed_m_s),
        go.seconds()
    )
}

/// A speed as a hand knows it.
fn pace(speed_m_s: f64) -> &'static str {
    if speed_m_s <= SPEEDS_M_S[2] {
        "slowly"
    } else if speed_m_s <= SPEEDS_M_S[1] {
        "steadily"
    } else {
        "quickly"
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::motion::Pose;

    fn go(to: [f64; 3], speed_m_s: f64) -> Move {
        let [x_m, y_m, theta_rad] = to;
        Move {
            from: Pose::default(),
            to: Pose {
                x_m,
                y_m,
                theta_rad,
            },
            speed_m_s,
        }
    }

    #[test]
    fn a_hand_is_told_which_way_how_far_and_how_fast() {
        let turn = order(&go([0.0, 0.0, 0.174_533], 0.01));
        assert!(
            turn.starts_with("turn it 10.0 degrees to the left by hand, slowly"),
            "{turn}"
        );
        let slanted = order(&go([-0.02, 0.01, -0.0087], 0.2));
        assert!(
            slanted.starts_with(
                "push it 20 mm along -x and 10 mm along +y in a straight line, turning it 0.5 degrees to the right by hand, quickly"
            ),
            "{slanted}"
        );
        assert!(order(&go([0.0; 3], 0.01)).starts_with("keep it still for 0.5 s"));
        assert!(!words(&go([0.02, 0.0, 0.0], 0.01)).contains("hand"));
    }
}
