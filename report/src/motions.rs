//! What to record next, as motions with their duration and as the commands that make them.

use diagnosis::verdict::evidence::Setting;
use effects::effect::Recordings;

/// A recording that a courier makes by one command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Record {
    /// Fly-bys there and back along both axes at 10, 50 and 200 mm/s, turned to either side, a turn on the spot, and standing still;
    /// about a place that is moved by so many mm, mm and degrees.
    Survey([f64; 3]),
    /// Standing still for so many seconds, every sample kept.
    Still(f64),
}

/// Recordings by the name of their folder.
pub type Records = &'static [(&'static str, Record)];

/// About the same place.
pub const HERE: Record = Record::Survey([0.0; 3]);
/// Long enough for a frequency to be told to a fifth of a hertz.
const STILL: Record = Record::Still(5.0);
/// The motions of `courier record --survey` take so long, s.
const SURVEY_S: f64 = 25.0;

/// What any question begins with.
pub const USUAL: Records = &[("next", HERE)];

/// What tells an effect from others.
pub fn of_effect(effect: &str) -> Records {
    let recordings = effects::card(effect).map(|card| card.recordings);
    match recordings.unwrap_or(Recordings::Usual) {
        Recordings::Usual => USUAL,
        Recordings::ColdAndWarm => &[("cold", HERE), ("warm", HERE)],
        Recordings::NowAndLater => &[("now", HERE), ("an-hour-later", HERE)],
        Recordings::Apart => &[
            ("here", HERE),
            ("aside", Record::Survey([30.0, 0.0, 0.0])),
            ("beyond", Record::Survey([0.0, 30.0, 0.0])),
        ],
        Recordings::Turned => &[
            ("turned-left", Record::Survey([0.0, 0.0, 0.5])),
            ("turned-right", Record::Survey([0.0, 0.0, -0.5])),
        ],
        Recordings::Still => &[("still", STILL)],
    }
}

/// What to do about a gap that lies over a coordinate and that nothing explains: what to change, and what to record.
pub fn over(coordinate: &str) -> (&'static str, Records) {
    let list: [(&str, &str, Records); 10] = [
        (
            "aux_",
            "Change what the logged column measures while the courier stands still, and keep it constant while the courier moves. An error that comes with the one and not with the other is its doing",
            &[("changing", STILL), ("constant", HERE)],
        ),
        (
            "temperature",
            "Record once cold, right after switching on, and once warm, half an hour later. What differs goes with the temperature",
            &[("cold", HERE), ("warm", HERE)],
        ),
        (
            "time",
            "Record the same motions again now and in ten minutes. What is the same in both goes with the motion and not with the time",
            &[("now", HERE), ("later", HERE)],
        ),
        (
            "deflection",
            "Record about two places under the beacon, 3 mm apart. What stays at the same deflection is the coordination sensor's, what stays at the same place is the platen's",
            &[
                ("left", Record::Survey([-1.5, 0.0, 0.0])),
                ("right", Record::Survey([1.5, 0.0, 0.0])),
            ],
        ),
        (
            "place",
            "Record at two places, 30 mm apart, over other teeth. What comes back at both is the sensor's, what does not is the platen's",
            &[("here", HERE), ("aside", Record::Survey([30.0, 0.0, 0.0]))],
        ),
        (
            "theta",
            "Record turned to either side by half a degree. What changes with the angle alone is seen at every tooth phase",
            &[
                ("turned-left", Record::Survey([0.0, 0.0, 0.5])),
                ("turned-right", Record::Survey([0.0, 0.0, -0.5])),
            ],
        ),
        (
            "frequency",
            "Stand still, once with the drives on and once with them off. A line that is there in both comes from outside",
            &[("drives-on", STILL), ("drives-off", STILL)],
        ),
        (
            "amplitude",
            "Record at two places, 30 mm apart, with raw counts. If the amplitude and the error change together from place to place, the air gap does; if not, look at the electronics",
            &[("here", HERE), ("aside", Record::Survey([30.0, 0.0, 0.0]))],
        ),
        (
            "speed",
            "Record the same way at 10, 50 and 200 mm/s, as a survey does. What grows in proportion to the speed is a delay",
            &[("speeds", HERE)],
        ),
        (
            "direction",
            "Record the same way there and back at three speeds, as a survey does. What turns its sign with the direction at every speed is no delay",
            &[("both-ways", HERE)],
        ),
    ];
    let known = list
        .into_iter()
        .find(|(word, ..)| coordinate.contains(word));
    known.map_or(
        (
            "Record fly-bys along both axes, slow and fast, straight and turned: they pass every phase of a tooth at every phase across it",
            &[("next", HERE)],
        ),
        |(_, what, records)| (what, records),
    )
}

/// How long the recordings take, in words.
pub fn takes(records: Records) -> String {
    let seconds = records.iter().map(|(_, record)| match record {
        Record::Survey(_) => SURVEY_S,
        Record::Still(seconds) => *seconds,
    });
    let list: Vec<String> = seconds.map(|s| format!("{s:.0} s")).collect();
    match &list[..] {
        [one] => format!("takes {one}"),
        _ => format!("{} recordings, {}", list.len(), list.join(" and ")),
    }
}

/// The commands that make recordings about the place of the last one.
pub fn commands(records: Records, setting: &Setting) -> Vec<String> {
    let one = |(folder, record): &(&str, Record)| match record {
        Record::Still(seconds) => {
            format!("courier record {folder} --seconds {seconds} --decimation 1 --run still")
        }
        Record::Survey(moved) => {
            format!(
                "courier record {folder} --survey {}",
                target(setting, *moved)
            )
        }
    };
    records.iter().map(one).collect()
}

/// A place as `--survey` takes it: mm, mm, degrees. `X,Y,THETA` where the recording tells none.
fn target(setting: &Setting, [x_mm, y_mm, turn_deg]: [f64; 3]) -> String {
    let Some([x_m, y_m, theta_rad]) = setting.commanded else {
        let moved = |name: &str, by: f64| {
            if by == 0.0 {
                name.to_owned()
            } else {
                format!("{name}{by:+}")
            }
        };
        let [x, y, theta] =
            [("X", x_mm), ("Y", y_mm), ("THETA", turn_deg)].map(|(n, by)| moved(n, by));
        return format!("{x},{y},{theta}");
    };
    let rounded = |value: f64, to: f64| (value / to).round() * to + 0.0;
    format!(
        "{:.1},{:.1},{:.1}",
        rounded(1.0e3 * x_m + x_mm, 0.1),
        rounded(1.0e3 * y_m + y_mm, 0.1),
        rounded(theta_rad.to_degrees() + turn_deg, 0.1)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_has_recordings_with_names_of_their_own() {
        for entry in effects::CATALOGUE {
            let records = of_effect(entry.name);
            let mut names: Vec<&str> = records.iter().map(|r| r.0).collect();
            names.dedup();
            assert!(!names.is_empty() && names.len() == records.len());
        }
    }

    #[test]
    fn commands_name_the_place_of_the_recording_where_it_tells_one() {
        let mut setting = Setting::default();
        let records = over("place on the platen").1;
        let told = |setting: &Setting| commands(records, setting).pop().unwrap();
        assert_eq!(told(&setting), "courier record aside --survey X+30,Y,THETA");
        setting.commanded = Some([0.1, -0.020_04, -0.0001]);
        assert_eq!(
            told(&setting),
            "courier record aside --survey 130.0,-20.0,0.0"
        );
        let still = over("frequency").1;
        assert_eq!(
            commands(still, &setting)[0],
            "courier record drives-on --seconds 5 --decimation 1 --run still"
        );
        assert_eq!(takes(still), "2 recordings, 5 s and 5 s");
    }
}
