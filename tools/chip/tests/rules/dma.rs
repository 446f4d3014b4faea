//! What DMA moves.

use crate::bench::{assert_kept, chip, set, wait_us};
use crate::spi;
use chip::chip::Chip;
use chip::peripheral::flash::Start;

const ON: u32 = 1;
/// Memory counts up, in a circle.
const RECEIVES: u32 = 1 << 5 | 1 << 7;

/// SPI1 and channel 1 of DMA1 with this request, memory and count, to be switched on.
pub fn dma(chip: &mut Chip, request: u32, memory: u32, count: u32) {
    spi::start(chip);
    // DMA1, DMAMUX1 and the CRC unit.
    set(chip, at!(RCC.ahb1enr()), 1 << 12 | 1 << 2 | 1);
    chip.write(at!(DMAMUX1.ccr(0)), 4, request);
    chip.write(at!(DMA1.ch(0).par()), 4, at!(SPI1.dr8()));
    chip.write(at!(DMA1.ch(0).mar()), 4, memory);
    chip.write(at!(DMA1.ch(0).ndtr()), 4, count);
}

/// Switches channel 1 on, and a byte comes.
fn receive(chip: &mut Chip) {
    set(chip, at!(SPI1.cr2()), 1);
    chip.write(at!(DMA1.ch(0).cr()), 4, RECEIVES | ON);
    spi::send(chip);
    wait_us(chip, 1);
}

trips! {
    dma_setup {
        a_count_of_none: |chip| {
            dma(chip, 10, 0x2000_0000, 0);
            receive(chip);
        };
    }
    dma_while_enabled {
        a_count_that_is_set_while_it_runs: |chip| {
            dma(chip, 10, 0x2000_0000, 2);
            receive(chip);
            chip.write(at!(DMA1.ch(0).ndtr()), 4, 2);
        };
    }
    dma_address {
        the_ccm_ram_as_the_processor_sees_it: |chip| {
            dma(chip, 10, 0x1000_0000, 2);
            receive(chip);
        };
    }
    dma_request {
        another_buss_request: |chip| {
            // SPI2's request for SPI1's register.
            dma(chip, 12, 0x2000_0000, 2);
            receive(chip);
        };
        the_other_direction: |chip| {
            // To the peripheral at the request of what has come.
            dma(chip, 10, 0x0800_0000, 2);
            chip.write(at!(DMA1.ch(0).cr()), 4, 1 << 4 | ON);
        };
    }
}

#[test]
fn bytes_that_come_go_to_memory_in_a_circle_and_their_end_is_told() {
    let mut chip = chip(Start::default());
    dma(&mut chip, 10, 0x2000_0010, 2);
    receive(&mut chip);
    assert_eq!(chip.read(at!(DMA1.isr()), 4) & 1 << 1, 0, "not at its end");
    spi::send(&mut chip);
    wait_us(&mut chip, 1);
    assert_eq!(chip.read(at!(DMA1.isr()), 4) & 1 << 1, 1 << 1);
    chip.write(at!(DMA1.ifcr()), 4, 1);
    assert_eq!(chip.read(at!(DMA1.isr()), 4), 0);
    spi::send(&mut chip);
    wait_us(&mut chip, 1);
    let stored = chip.transfers.take_stored();
    let places: Vec<u32> = stored.iter().map(|(at, _)| *at).collect();
    assert_eq!(places, [0x2000_0010, 0x2000_0011, 0x2000_0010]);
    assert_kept(&chip);
}
