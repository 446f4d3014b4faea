//! Drives the checks of the project.

mod arm;

fn main() -> anyhow::Result<()> {
    match std::env::args().nth(1).as_deref() {
        Some("arm") => arm::checks(),
        other => anyhow::bail!("found {other:?}, wanted: arm"),
    }
}
