//! Starts the emulated board and prints what it says.
use courier_sensor::link::client::Client;
use courier_sensor::link::message::Action;
use hal_sim::board::FLASH_PAGES;
use hal_sim::wire::flash::Flash;
use link_host::emulated::{Emulated, Images, Parts};
use link_host::wire::Wire;
use std::time::{Duration, Instant};

fn main() -> anyhow::Result<()> {
    let a: Vec<String> = std::env::args().collect();
    let images = Images { firmware: a[1].clone().into(), plugin: a[2].clone().into() };
    let spec = hal_sim::presets::ideal(1);
    let home = spec.places.scatter_corner;
    let world = hal_sim::world::World::new(spec, hal_sim::wire::motion::ControllerConfig::TYPICAL, home, 1)?;
    let t = Instant::now();
    let mut board = Emulated::start(&images, Parts::new(world, Flash::new(FLASH_PAGES, 1)))?;
    println!("started {} after {:?}", board.starts(), t.elapsed());
    let mut client = Client::new();
    let mut buffer = [0; 2048];
    let mut got = [0; 2048];
    let n = board.receive(0, &mut got)?;
    println!("log {:?}", &got[..n]);
    for k in 0..3 {
        let (_, bytes) = if k == 0 { client.hello(&mut buffer)? } else { client.ask(Action::Status, &mut buffer)? };
        board.send(bytes)?;
        for _ in 0..20 {
            board.pass(Duration::from_micros(500))?;
            let n = board.receive(2, &mut got)?;
            for b in &got[..n] { if let Some(r) = client.feed(*b) { println!("{r:?}"); } }
        }
    }
    let t = Instant::now();
    board.pass(Duration::from_secs(1))?;
    println!("1 s took {:?}", t.elapsed());
    Ok(())
}
