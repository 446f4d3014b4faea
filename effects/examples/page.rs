//! Prints the page of the catalogue: `cargo run -p effects --example page > docs/effects.md`.

fn main() {
    print!("{}", effects::page::page());
}
