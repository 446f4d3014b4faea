//! One move's progress over time: smooth ramp up, cruise, smooth ramp down.

/// Progress from 0 to 1 with a peak rate and ramps whose acceleration is continuous.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    ramp_s: f64,
    rate_hz: f64,
    duration_s: f64,
}

impl Profile {
    /// For a distance (any unit) at a cruise speed; a distance too short to reach it peaks lower.
    #[must_use]
    pub fn new(distance: f64, speed: f64, ramp_s: f64) -> Self {
        let rate_hz = (speed / distance.max(1.0e-12)).min(1.0 / ramp_s);
        Self {
            ramp_s,
            rate_hz,
            duration_s: 1.0 / rate_hz + ramp_s,
        }
    }

    /// Whole duration, seconds.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// Progress 0..=1 at a time after the start.
    #[must_use]
    pub fn at(&self, time_s: f64) -> f64 {
        let ramp = |t: f64| {
            let u = (t / self.ramp_s).clamp(0.0, 1.0);
            self.rate_hz * self.ramp_s * u * u * u * (1.0 - 0.5 * u)
        };
        let left = self.duration_s - time_s;
        if time_s <= 0.0 {
            0.0
        } else if left <= 0.0 {
            1.0
        } else if time_s < self.ramp_s {
            ramp(time_s)
        } else if left < self.ramp_s {
            1.0 - ramp(left)
        } else {
            self.rate_hz * (time_s - 0.5 * self.ramp_s)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_is_smooth_and_cruises_at_the_stated_speed() {
        for (distance, speed) in [(40e-3, 50e-3), (1e-4, 50e-3)] {
            let profile = Profile::new(distance, speed, 0.08);
            let steps = 10_000;
            let dt = profile.duration_s() / f64::from(steps);
            let mut last = 0.0;
            let mut peak = 0.0_f64;
            for i in 1..=steps {
                let now = profile.at(f64::from(i) * dt);
                peak = peak.max((now - last) / dt);
                assert!(now >= last);
                last = now;
            }
            assert!((last - 1.0).abs() < 1e-9);
            assert!(peak * distance <= speed * (1.0 + 1e-6));
        }
        let cruise = Profile::new(40e-3, 50e-3, 0.08);
        assert!((40e-3 * (cruise.at(0.5) - cruise.at(0.4)) / 0.1 - 50e-3).abs() < 1e-9);
    }
}
