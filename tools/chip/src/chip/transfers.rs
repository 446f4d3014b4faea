//! What DMA moves between the converters' buses and memory: one byte a request.

use crate::memory::FLASH;
use crate::peripheral::Access;
use crate::peripheral::dma::{self, Dma, Dmamux};
use crate::peripheral::spi::Spi;
use crate::processor::contention::Moved;
use crate::registers;
use crate::rule::Rule;
use std::rc::Rc;

/// The converters' buses.
pub(super) const SPI: [&str; 2] = ["SPI1", "SPI2"];
/// Offset of a bus's data register (RM0440, 39.9.4).
const SPI_DATA: u32 = 0x0C;

/// Request line of a bus: its number, the bus, and whether it asks to be read.
type Request = (u32, usize, bool);

/// The controller, its multiplexer, and the memory that they reach.
#[derive(Debug)]
pub struct Transfers {
    pub(super) dma1: Dma,
    pub(super) dmamux1: Dmamux,
    code: Rc<[u8]>,
    /// What a channel sends that takes it from RAM, and where that lies.
    sources: [(u32, Vec<u8>); dma::CHANNELS],
    stored: Vec<(u32, u8)>,
    moved: Moved,
    requests: [Request; 4],
}

impl Transfers {
    /// After reset, with no code.
    pub(super) fn after_reset() -> Self {
        Self {
            dma1: Dma::after_reset(),
            dmamux1: Dmamux::after_reset(),
            code: Rc::new([]),
            sources: Default::default(),
            stored: vec![],
            moved: Moved::default(),
            requests: std::array::from_fn(|k| {
                let (index, receives) = (k / 2, k % 2 == 0);
                let signal = if receives { "RX" } else { "TX" };
                (registers::dma_request(SPI[index], signal), index, receives)
            }),
        }
    }

    /// A reset: the code stays.
    pub(super) fn reset(&mut self) {
        self.dma1 = Dma::after_reset();
        self.dmamux1 = Dmamux::after_reset();
        self.stored.clear();
    }

    /// Serves the requests of the buses, one byte after the other, until none is left.
    pub(super) fn serve(&mut self, spi: &mut [Spi; 2], access: &mut Access) {
        while let Some((channel, index, receives)) = self.next_request(spi) {
            let Some(item) = self.dma1.next_item(channel, access) else {
                continue;
            };
            if receives {
                let byte = spi[index].dma_read();
                self.stored.push((item.memory, byte));
                self.moved.in_ram += 1;
            } else {
                let (base, bytes): (u32, &[u8]) = match dma::RAM.contains(&item.memory) {
                    true => (self.sources[channel].0, &self.sources[channel].1),
                    false => (FLASH, &self.code),
                };
                let at = item.memory.wrapping_sub(base) as usize;
                let byte = bytes.get(at).copied().unwrap_or(0xFF);
                spi[index].dma_write(byte, access);
                self.moved.note_sent(item.memory);
            }
        }
    }

    /// The channel that is served next, the bus whose request it is, and which of the two.
    fn next_request(&self, spi: &[Spi; 2]) -> Option<(usize, usize, bool)> {
        let running = (0..dma::CHANNELS).filter(|channel| self.dma1.runs(*channel));
        let asked = running.filter_map(|channel| {
            let (_, index, receives) = self.request_of(channel)?;
            let asks = spi[index].requests(receives);
            asks.then_some((channel, index, receives))
        });
        asked.max_by_key(|(channel, ..)| (self.dma1.priority(*channel), usize::MAX - channel))
    }

    fn request_of(&self, channel: usize) -> Option<Request> {
        let number = self.dmamux1.request(channel);
        let mut known = self.requests.iter();
        known.find(|(line, ..)| *line == number).copied()
    }

    /// A channel that is switched on must listen to the register that it serves.
    pub(super) fn watch(&mut self, access: &mut Access) {
        for channel in self.dma1.take_enabled() {
            let (register, to_peripheral) = self.dma1.target(channel);
            let fits = self
                .request_of(channel)
                .is_some_and(|(_, index, receives)| {
                    let data = registers::address(SPI[index]) + SPI_DATA;
                    data == register && receives != to_peripheral
                });
            if !fits {
                let detail = format!(
                    "channel {} serves {register:#010x} at request {}",
                    channel + 1,
                    self.dmamux1.request(channel)
                );
                access.broken(Rule::DmaRequest, detail);
            }
        }
    }

    /// The bytes of bank 1, which DMA may read.
    pub fn set_code(&mut self, code: &[u8]) {
        self.code = code.into();
    }

    /// Where channels take what they send from RAM, and how many bytes.
    pub fn sources_in_ram(&self) -> impl Iterator<Item = (usize, u32, usize)> + '_ {
        let source = |channel| {
            let (memory, bytes) = self.dma1.source_in_ram(channel)?;
            Some((channel, memory, bytes))
        };
        (0..dma::CHANNELS).filter_map(source)
    }

    /// What lies there, as of now.
    pub fn set_source(&mut self, channel: usize, memory: u32, bytes: Vec<u8>) {
        self.sources[channel] = (memory, bytes);
    }

    /// What DMA has moved since the last call.
    pub fn take_moved(&mut self) -> Moved {
        std::mem::take(&mut self.moved)
    }

    /// Whether a channel that sends is at work: the buses are served.
    pub fn serves(&self) -> bool {
        (0..dma::CHANNELS).any(|channel| self.dma1.runs(channel) && self.dma1.target(channel).1)
    }

    /// How many bytes DMA has put into memory since the last call of [`Transfers::take_stored`].
    pub fn stored(&self) -> usize {
        self.stored.len()
    }

    /// Bytes that DMA has put into memory since the last call, with their addresses.
    pub fn take_stored(&mut self) -> Vec<(u32, u8)> {
        std::mem::take(&mut self.stored)
    }
}
