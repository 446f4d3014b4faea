//! `cargo xtask bench`: the cost table, measured on the emulated Cortex-M4F.

use crate::plugin::{self, Build};
use crate::{arm, chip, cmsis, figures, firmware, onboard, throughput};
use anyhow::{Context, Result, ensure};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Processor clock, hertz.
const CLOCK_HZ: f64 = 170.0e6;
/// Unknowns of the joint calibration's measured rows: the paper's, and with the coordination sensor's own errors.
const SOLVED: [u32; 2] = [47, 62];
/// Unknowns of the measured Givens row.
const UNKNOWNS: u32 = 33;

/// One measured piece of work.
#[derive(Clone, Debug)]
pub struct Cost {
    /// How often it was run, on different inputs.
    pub count: u32,
    /// Exact, worst and mean.
    pub instructions: (u32, f64),
    /// By the public timings, worst and mean.
    pub cycles: (u32, f64),
}

/// All of them by name, in the image's order.
pub type Costs = BTreeMap<String, Cost>;

/// The command.
///
/// # Errors
/// What is missing cannot be set up, or the image fails.
pub fn run(arguments: &[String]) -> Result<()> {
    let json = match arguments {
        [] => false,
        [one] if one == "--json" => true,
        other => anyhow::bail!("found {other:?}, wanted nothing or --json"),
    };
    let mut costs = measure()?;
    let image = plugin::build_image(&arm::ensure()?, Build::Firmware)?;
    let joint = plugin::run_image(&image, &["joint"])?;
    costs.extend(parse(&joint)?);
    if json {
        let images = firmware::sizes(&arm::ensure()?)?;
        print_json(&costs, &joint, &images, &chip::json()?);
        return Ok(());
    }
    print_table(&costs);
    print_joint(&costs, &joint);
    figures::run()?;
    onboard::figures()?;
    throughput::run()
}

/// Cycles at most, worst case. Of the 1,500 that both sampling interrupts of a sample may take (17.6 % of 20 kHz, held on the chip's model),
/// reading the converters and handing the frame on needs 570: 930 are left for the plain computation, and 30 of these are kept for what
/// only the model sees, an instant that was missed and waiting for DMA. With the lateral terms 300 more are allowed, a fifth of the sample's.
const LIMITS: [(&str, u32); 5] = [
    ("interrupt", 900),
    ("interrupt_lateral", 1200),
    ("givens_row_33", 6000),
    // One pair by itself: a fifth of the four segments' sample with all eight orders, and a row of its circle.
    ("encoder_sample", 250),
    ("encoder_row_9", 3000),
];
/// Worst case over the mean, at most.
const SPREAD: f64 = 1.15;
/// A peer's instructions over ours, at least.
const PEERS: [(&str, u32); 2] = [("cmsis", 2), ("libm", 8)];

/// Measures and compares with the limits.
///
/// # Errors
/// The first that is not kept, with both numbers; or as [`measure`].
pub fn check() -> Result<()> {
    let costs = measure()?;
    let cost = |name: &str| {
        costs
            .get(name)
            .with_context(|| format!("costs: the image said nothing of {name}"))
    };
    for (name, limit) in LIMITS {
        let (worst, mean) = cost(name)?.cycles;
        ensure!(
            worst <= limit && f64::from(worst) <= SPREAD * mean,
            "costs: {name}: found {worst} cycles and {mean} in the mean, wanted at most {limit} and {SPREAD} times the mean"
        );
    }
    let ours = cost("interrupt")?.instructions.0;
    for (name, times) in PEERS {
        if let Some(peer) = costs.get(name) {
            ensure!(
                peer.instructions.0 >= times * ours,
                "costs: interrupt: found {ours} instructions where {name} takes {}, wanted {times} times fewer",
                peer.instructions.0
            );
        }
    }
    arm::say("costs within their limits");
    Ok(())
}

/// Builds and runs the measuring image twice: our work as the firmware's images have it, peers built for speed.
///
/// # Errors
/// As [`run`].
pub fn measure() -> Result<Costs> {
    let arm = arm::ensure()?;
    let peer = cmsis::build()
        .inspect_err(|why| arm::say(&format!("no CMSIS-DSP in the table: {why:#}")))
        .ok();
    let mut costs = Costs::new();
    for (build, what) in [
        (Build::Firmware, "costs"),
        (Build::Speed(peer.as_deref()), "peers"),
    ] {
        let image = plugin::build_image(&arm, build)?;
        costs.extend(parse(&plugin::run_image(&image, &[what])?)?);
    }
    Ok(costs)
}

fn parse(text: &str) -> Result<Costs> {
    text.lines()
        .filter(|line| line.starts_with("cost "))
        .map(line)
        .collect()
}

fn line(line: &str) -> Result<(String, Cost)> {
    let mut words = line.split(' ').skip(1);
    let mut next = || {
        words
            .next()
            .with_context(|| format!("the image's line {line:?} is too short"))
    };
    let name = next()?.to_owned();
    let count = next()?.parse()?;
    let instructions = (next()?.parse()?, next()?.parse()?);
    let cycles = (next()?.parse()?, next()?.parse()?);
    Ok((
        name,
        Cost {
            count,
            instructions,
            cycles,
        },
    ))
}

fn print_table(costs: &Costs) {
    println!(
        "{:<20} {:>7} {:>12} {:>12} {:>12} {:>12} {:>8} {:>8} {:>8}",
        "work",
        "inputs",
        "instructions",
        "mean",
        "cycles (est)",
        "mean",
        "20 kHz",
        "50 kHz",
        "100 kHz"
    );
    for (name, cost) in costs {
        let [a, b, c] = RATES_HZ.map(|rate| share(cost, rate));
        let (instructions, cycles) = (cost.instructions, cost.cycles);
        println!(
            "{name:<20} {:>7} {:>12} {:>12.1} {:>12} {:>12.1} {a:>8} {b:>8} {c:>8}",
            cost.count, instructions.0, instructions.1, cycles.0, cycles.1,
        );
    }
    let floor = GivensFloor::of(UNKNOWNS);
    println!(
        "\nfloor of givens_row_{UNKNOWNS}: {} loads, {} stores, {} multiplications, {} additions, {} divisions: {} cycles if nothing \
         else were done\ngivens_row_{UNKNOWNS} is every row after as many as unknowns; givens_row_{UNKNOWNS}_start the rows before",
        floor.loads,
        floor.stores,
        floor.multiplications,
        floor.additions,
        floor.divisions,
        floor.cycles()
    );
    println!(
        "Worst case first, mean beside it. Instructions are exact; cycles are estimated from the public timings of the\n\
         Cortex-M4F without wait states. Shares are of {:.0} MHz at the worst case, for work that is done at every sample.",
        CLOCK_HZ / 1.0e6
    );
}

/// The joint calibration as a whole, and its memory, of which the image says `bytes NAME NUMBER`.
fn print_joint(costs: &Costs, text: &str) {
    if let Some(slices) = costs.get("joint_slice") {
        let ms = |cycles: f64| 1.0e3 * cycles / CLOCK_HZ;
        println!(
            "\njoint calibration of 1000 poses and 200 held out, all five steps: {} slices, together {:.0} ms at {:.0} MHz, the longest \
             {:.0} ms",
            slices.count,
            ms(whole(slices)),
            CLOCK_HZ / 1.0e6,
            ms(slices.cycles.0.into())
        );
    }
    for (name, bytes) in sizes(text) {
        println!("{name}: {bytes} bytes");
    }
}

/// Cycles of all inputs together.
fn whole(cost: &Cost) -> f64 {
    f64::from(cost.count) * cost.cycles.1
}

fn sizes(text: &str) -> impl Iterator<Item = (&str, u32)> {
    let lines = text.lines().filter_map(|line| line.strip_prefix("bytes "));
    lines.filter_map(|line| {
        let (name, bytes) = line.split_once(' ')?;
        Some((name, bytes.parse().ok()?))
    })
}

/// Rates of the interrupt that the table has.
const RATES_HZ: [f64; 3] = [20.0e3, 50.0e3, 100.0e3];

fn share(cost: &Cost, rate: f64) -> String {
    let share = f64::from(cost.cycles.0) * rate / CLOCK_HZ;
    if share > 9.99 {
        "-".into()
    } else {
        format!("{:.1}%", 100.0 * share)
    }
}

/// What a Givens row cannot do without, however it is written: every number of the factor and of the row is read, the factor's
/// are written, and every rotation turns the entries right of it, by two multiplications and two additions a pair where no
/// roots are taken (Gentleman 1973; with roots it is four multiplications).
struct GivensFloor {
    loads: u32,
    stores: u32,
    multiplications: u32,
    additions: u32,
    divisions: u32,
}

impl GivensFloor {
    fn of(unknowns: u32) -> Self {
        // Right-hand side included, the diagonal apart.
        let pairs = unknowns * (unknowns + 1) / 2;
        let factor = pairs + unknowns;
        Self {
            loads: factor + unknowns + 1,
            stores: factor,
            // A rotation's own: g a, g a a, the two quotients, g.
            multiplications: 2 * pairs + 5 * unknowns,
            additions: 2 * pairs + unknowns,
            divisions: unknowns,
        }
    }

    /// One cycle a load in a row of loads, a store in a row of stores, a multiplication, an addition; 14 a division.
    fn cycles(&self) -> u32 {
        self.loads + self.stores + self.multiplications + self.additions + 14 * self.divisions
    }
}

fn print_json(costs: &Costs, joint: &str, images: &serde_json::Map<String, Value>, chip: &Value) {
    let worst = |name: &str| {
        costs.get(name).map(|c| json!({"instructions_worst": c.instructions.0, "cycles_worst": c.cycles.0, "cycles_mean": c.cycles.1}))
    };
    let instructions = |name: &str| {
        costs
            .get(name)
            .map(|c| json!({"instructions_worst": c.instructions.0}))
    };
    let row = costs
        .get("givens_row_33")
        .map(|c| json!({"instructions": c.instructions.0, "cycles": c.cycles.0}));
    let object = json!({
        "interrupt": worst("interrupt"),
        "interrupt_lateral": worst("interrupt_lateral"),
        "cmsis": instructions("cmsis"),
        "libm": instructions("libm"),
        "givens_row_33": row,
        "solve_33": worst("solve_33"),
        "interrupt_mapped": worst("interrupt_mapped"),
        "joint": {
            "rows": SOLVED.map(|unknowns| json!({
                "unknowns": unknowns,
                "linearise": worst("joint_linearise"),
                "g_p": worst(&format!("joint_row_{unknowns}_p")),
                "g_x": worst(&format!("joint_row_{unknowns}_x")),
                "g_y": worst(&format!("joint_row_{unknowns}_y")),
                "solve": worst(&format!("joint_solve_{unknowns}")),
            })),
            "solving_ms": costs.get("joint_slice").map(|slices| 1.0e3 * whole(slices) / CLOCK_HZ),
            "slice": worst("joint_slice"),
            "bytes": sizes(joint).collect::<BTreeMap<_, _>>(),
        },
        "images": images,
        "chip": chip,
    });
    println!("{object}");
}
