//! Prints what cannot be right in each recording folder that is named.

fn main() {
    for path in std::env::args().skip(1) {
        let Ok(recording) = recording::Recording::read(&path) else {
            println!("{path}: not a recording");
            continue;
        };
        let started = std::time::Instant::now();
        let findings = plausibility::check(&recording);
        println!(
            "{path}: {} ({:.3} s)",
            findings.len(),
            started.elapsed().as_secs_f64()
        );
        for finding in findings {
            println!("    {finding}");
        }
    }
}
