//! A simulated board takes a new firmware over its link: what it does, and what it refuses.

use board_link::image::{DEVELOPMENT_SEED, Image};
use board_link::{Link, SimWire, update};
use courier_sensor::calibration::record::{Calibration, Method};
use courier_sensor::drivers::motion::Target;
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::{Action, CalibrateOrder, InForce, Reply};
use courier_sensor::update::install::Progress;
use courier_sensor::update::order::{UpdateOrder, UpdateStatus};
use courier_sensor::update::version::Version;
use hal_sim::board::SharedFlash;
use indicatif::ProgressBar;

fn board() -> Link {
    let spec = hal_sim::presets::ideal(1);
    let wire = SimWire::start(spec, 1, SharedFlash::erased(1)).unwrap();
    Link::connect(Box::new(wire)).unwrap()
}

/// A calibration that corrects nothing, stored.
fn calibrated() -> Link {
    let mut link = board();
    let calibration = Calibration::identity(Geometry::PAPER);
    link.ask(Action::take_over(calibration)).unwrap();
    store(&mut link).unwrap();
    link
}

fn store(link: &mut Link) -> anyhow::Result<Reply> {
    link.ask(Action::Commit {
        lose_unknown: false,
    })
}

fn image(version: &str) -> Image {
    let version = Version::parse(version).unwrap();
    Image::sign(DEVELOPMENT_SEED, "simulated", version, vec![0x5A; 5000]).unwrap()
}

fn send(link: &mut Link, image: &Image) -> anyhow::Result<()> {
    update::send(link, image, false, &ProgressBar::hidden())
}

fn status(link: &mut Link) -> UpdateStatus {
    update::ask(link, UpdateOrder::Status).unwrap()
}

/// What the board says when it refuses.
fn refusal<T>(answer: anyhow::Result<T>) -> String {
    match answer {
        Ok(_) => panic!("it was taken"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn a_new_image_is_on_trial_until_it_is_accepted() {
    let mut link = calibrated();
    let stored = link.status().unwrap().in_force;
    assert!(matches!(stored, InForce::Stored(_)));
    send(&mut link, &image("9.0.0")).unwrap();
    let before = status(&mut link);
    assert_eq!(before.running, Version::OWN);
    assert!(matches!(before.progress, Progress::Installed { .. }));
    link.restart().unwrap();
    assert_eq!(link.hello().firmware, "9.0.0");
    assert!(status(&mut link).trial_left_s.is_some());
    assert_eq!(link.status().unwrap().in_force, stored, "it came along");
    // What it stored would be lost if it went back.
    let on_trial = "the image that runs is on trial";
    let calibrate = Action::Calibrate(CalibrateOrder::default());
    assert!(refusal(link.ask(calibrate)).contains(on_trial));
    assert!(refusal(store(&mut link)).contains(on_trial));
    assert!(refusal(link.ask(Action::RollBack)).contains(on_trial));
    assert!(refusal(send(&mut link, &image("9.0.1"))).contains(on_trial));
    update::ask(&mut link, UpdateOrder::Accept).unwrap();
    assert_eq!(status(&mut link).trial_left_s, None);
    for _ in 0..4 {
        link.restart().unwrap();
        assert_eq!(link.hello().firmware, "9.0.0");
        assert_eq!(link.status().unwrap().in_force, stored);
    }
    // And on it goes, into the bank that the first image was in.
    send(&mut link, &image("9.1.0")).unwrap();
    link.restart().unwrap();
    assert_eq!(link.hello().firmware, "9.1.0");
}

#[test]
fn an_image_that_is_given_up_goes_back_with_the_calibration() {
    let mut link = calibrated();
    let stored = link.status().unwrap().in_force;
    send(&mut link, &image("9.0.0")).unwrap();
    link.restart().unwrap();
    update::ask(&mut link, UpdateOrder::Refuse).unwrap();
    let again = update::ask(&mut link, UpdateOrder::Accept);
    assert!(refusal(again).contains("no image is on trial"));
    link.restart().unwrap();
    assert_eq!(status(&mut link).running, Version::OWN);
    assert_eq!(link.status().unwrap().in_force, stored);
    // Starts that nobody accepts use the trials up.
    send(&mut link, &image("9.0.0")).unwrap();
    let mut seen = vec![];
    for _ in 0..4 {
        link.restart().unwrap();
        seen.push(status(&mut link).running.major);
    }
    assert_eq!(seen, [9, 9, 9, Version::OWN.major]);
}

fn begin(image: &Image) -> UpdateOrder {
    UpdateOrder::Begin {
        header: heapless::Vec::from_slice(&image.header.encode()).unwrap(),
        allow_older: false,
    }
}

fn calibrate(method: Method) -> Action {
    Action::Calibrate(CalibrateOrder {
        method,
        ..CalibrateOrder::default()
    })
}

#[test]
fn an_update_and_a_calibration_refuse_each_other() {
    let mut link = board();
    let image = image("9.0.0");
    for method in [Method::Platen, Method::Joint] {
        update::ask(&mut link, begin(&image)).unwrap();
        let told = refusal(link.ask(calibrate(method)));
        assert!(told.contains("an update is under way"), "{told}");
        assert!(told.contains("`courier reset`"), "{told}");
        // A restart gives the update up.
        link.restart().unwrap();
        assert_eq!(link.ask(calibrate(method)).unwrap(), Reply::Done);
        let told = refusal(update::ask(&mut link, begin(&image)));
        assert!(told.contains("a calibration is under way"), "{told}");
        assert!(told.contains("abort it first"), "{told}");
        assert_eq!(status(&mut link).progress, Progress::Idle);
        assert_eq!(link.ask(Action::Abort).unwrap(), Reply::Done);
        link.restart().unwrap();
    }
    send(&mut link, &image).unwrap();
}

#[test]
fn an_update_waits_until_the_courier_stands() {
    let mut link = calibrated();
    let go = Action::GoTo {
        target: Target {
            x_m: 0.05,
            y_m: 0.0,
            theta_rad: 0.0,
        },
        speed_m_per_s: 0.1,
    };
    assert_eq!(link.ask(go).unwrap(), Reply::Done);
    let told = refusal(update::ask(&mut link, begin(&image("9.0.0"))));
    assert!(
        told.contains("the courier is moving: wait until it stands"),
        "{told}"
    );
}

#[test]
fn half_an_image_is_none() {
    let mut link = calibrated();
    let stored = link.status().unwrap().in_force;
    let image = image("9.0.0");
    update::ask(&mut link, begin(&image)).unwrap();
    let bytes = heapless::Vec::from_slice(&image.body[..384]).unwrap();
    update::ask(&mut link, UpdateOrder::Piece { offset: 0, bytes }).unwrap();
    let finish = update::ask(&mut link, UpdateOrder::Finish);
    assert!(refusal(finish).contains("384 bytes of the image, wanted 5000"));
    link.restart().unwrap();
    let now = status(&mut link);
    assert_eq!((now.running, now.progress), (Version::OWN, Progress::Idle));
    assert_eq!(link.status().unwrap().in_force, stored);
    // The next one is taken from its beginning.
    send(&mut link, &image).unwrap();
    link.restart().unwrap();
    assert_eq!(link.hello().firmware, "9.0.0");
}

#[test]
fn forged_images_are_refused_by_the_board_itself() {
    let mut link = calibrated();
    let mut forged = image("9.0.0");
    forged.header.version.minor = 1;
    assert!(refusal(send(&mut link, &forged)).contains("signature is wrong"));
    let mut changed = image("9.0.0");
    changed.body[3000] ^= 1;
    assert!(refusal(send(&mut link, &changed)).contains("check value is wrong"));
    let other = Image::sign([7; 32], "simulated", Version::OWN, vec![0; 80]).unwrap();
    assert!(refusal(send(&mut link, &other)).contains("a key that the board's firmware"));
    let other = Image::sign(DEVELOPMENT_SEED, "g474", Version::OWN, vec![0; 80]).unwrap();
    assert!(refusal(send(&mut link, &other)).contains("for another board"));
    assert!(refusal(send(&mut link, &image("0.0.1"))).contains("older than"));
    link.restart().unwrap();
    assert_eq!(status(&mut link).running, Version::OWN);
}
