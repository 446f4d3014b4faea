//! The first of the kept answers, answered again.

use frozen::answer::answer;
use frozen::list::SAMPLE;
use frozen::{RELATIVE, compare, read};
use std::path::Path;

#[test]
fn the_sample_is_answered_as_it_was() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("answers.jsonl");
    let kept = read(&path).expect("kept answers");
    for one in &kept[..SAMPLE] {
        let first = one
            .specimen
            .first()
            .expect("a recording")
            .expect("a simulated one");
        let now = answer(&first, one.specimen.second().as_ref());
        let found = compare(&one.answer, &now, RELATIVE);
        assert!(found.is_empty(), "{}: {found:#?}", one.specimen.name());
    }
}
