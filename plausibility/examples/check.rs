//! Prints the geometry by the data, and what cannot be right, of each recording folder that is named.

fn main() {
    for path in std::env::args().skip(1) {
        let Ok(recording) = recording::Recording::read(&path) else {
            println!("{path}: not a recording");
            continue;
        };
        let started = std::time::Instant::now();
        let plausibility::Plausibility { findings, geometry } = plausibility::look(&recording);
        println!(
            "{path}: {} ({:.3} s)",
            findings.len(),
            started.elapsed().as_secs_f64()
        );
        for f in geometry {
            let [found, stated, error] = [f.found_m, f.stated_m, f.error_m].map(|m| 1.0e3 * m);
            println!(
                "    {} {found:.4} mm (stated {stated:.4}, known to {error:.2})",
                f.name
            );
        }
        for finding in findings {
            println!("    {finding}");
        }
    }
}
