//! The peripherals that the model has.

/// A peripheral that the model has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // the chip's own names
pub enum Unit {
    Rcc,
    Pwr,
    Flash,
    Gpio(usize),
    Exti,
    Syscfg,
    Tim2,
    Tim3,
    Tim8,
    Tim16,
    Spi(usize),
    Dma1,
    Dmamux1,
    Crc,
    Usart1,
    Adc1,
    Adc12Common,
    Iwdg,
    Wwdg,
    Dbgmcu,
}

impl Unit {
    /// By the chip's name for it.
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "RCC" => Self::Rcc,
            "PWR" => Self::Pwr,
            "FLASH" => Self::Flash,
            "EXTI" => Self::Exti,
            "SYSCFG" => Self::Syscfg,
            "TIM2" => Self::Tim2,
            "TIM3" => Self::Tim3,
            "TIM8" => Self::Tim8,
            "TIM16" => Self::Tim16,
            "SPI1" => Self::Spi(0),
            "SPI2" => Self::Spi(1),
            "DMA1" => Self::Dma1,
            "DMAMUX1" => Self::Dmamux1,
            "CRC" => Self::Crc,
            "USART1" => Self::Usart1,
            "ADC1" => Self::Adc1,
            "ADC12_COMMON" => Self::Adc12Common,
            "IWDG" => Self::Iwdg,
            "WWDG" => Self::Wwdg,
            "DBGMCU" => Self::Dbgmcu,
            _ => {
                let port = name.strip_prefix("GPIO")?.bytes().next()?;
                Self::Gpio(usize::from(port - b'A'))
            }
        })
    }
}
