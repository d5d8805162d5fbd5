//! The board program for an ESP32-C3: one whisker, two valves, a pressure sensor, a strain gauge, and the driver
//! interface of vibrissa-robot over USB.

#![no_std]
#![no_main]

use core::panic::PanicInfo;

use esp_hal::Blocking;
use esp_hal::analog::adc::{Adc, AdcCalCurve, AdcChannel, AdcConfig, AdcPin, Attenuation};
use esp_hal::gpio::{Level, Output, OutputConfig};
use esp_hal::main;
use esp_hal::peripherals::ADC1;
use esp_hal::time::{Duration, Instant};
use esp_hal::timer::timg::{MwdtStage, TimerGroup};
use esp_hal::usb::usb_serial_jtag::UsbSerialJtag;
use vibrissa_board::{Board, Lines, Readings};

esp_bootloader_esp_idf::esp_app_desc!();

/// Array and number of the whisker, as in the agent's `agent.toml`.
const ARRAY: &str = "left";
const WHISKER: u32 = 0;
/// Highest pressure that the chamber withstands, MPa.
const LIMIT_MPA: f32 = 0.2;
/// Voltages at a pin between which the converter measures, V: beyond, the strain is at an end.
const CONVERTER_V: core::ops::Range<f32> = 0.005..2.495;
/// Ratio of the voltage of a sensor to that at the pin. Sensors of 5 V need a divider: the converter reads up to 2.5 V.
const DIVIDER: f32 = 2.0;
/// Voltage of the pressure sensor at 0 MPa, V, and its slope, V/MPa.
const PRESSURE_ZERO_V: f32 = 1.0;
const PRESSURE_V_PER_MPA: f32 = 4.0;
/// Voltage of the strain amplifier at rest, V, and strain per volt, m/m.
const STRAIN_ZERO_V: f32 = 2.5;
const STRAIN_PER_VOLT: f32 = 0.002;
/// Slide potentiometer that measures the way of the whisker's base: way in mm from 0 V to the voltage at its end, V. 0 mm without
/// one; the agent then makes no contacts. Negative if it is turned round.
const SLIDE_MM: f32 = 0.0;
const SLIDE_END_V: f32 = 2.37;
/// Conversions of which one reading is the mean.
const CONVERSIONS: u32 = 8;
/// Time without a step after which the hardware restarts the board, with both valves closed.
const WATCHDOG: Duration = Duration::from_millis(500);
/// Room for lines that the USB host has not taken yet. Lines that do not fit are left out.
const LINES_MOST: usize = 1024;

#[main]
fn main() -> ! {
    let chip = esp_hal::init(esp_hal::Config::default());
    let fill = Output::new(chip.GPIO6, Level::Low, OutputConfig::default());
    let vent = Output::new(chip.GPIO7, Level::Low, OutputConfig::default());
    let mut pins = AdcConfig::new();
    let mut pressure = pins.enable_pin_with_cal::<_, AdcCalCurve<ADC1>>(chip.GPIO0, Attenuation::_11dB);
    let mut strain = pins.enable_pin_with_cal::<_, AdcCalCurve<ADC1>>(chip.GPIO1, Attenuation::_11dB);
    let mut slide = pins.enable_pin_with_cal::<_, AdcCalCurve<ADC1>>(chip.GPIO3, Attenuation::_11dB);
    let mut converter = Adc::new(chip.ADC1, pins);
    let mut usb = UsbSerialJtag::new(chip.USB_DEVICE);
    let mut watchdog = TimerGroup::new(chip.TIMG0).wdt;
    watchdog.set_timeout(MwdtStage::Stage0, WATCHDOG);
    watchdog.enable();

    let Ok(mut board) = Board::new(fill, vent, ARRAY, WHISKER, LIMIT_MPA) else { esp_hal::system::software_reset() };
    let mut lines = Lines::<LINES_MOST>::default();
    loop {
        let now_us = Instant::now().duration_since_epoch().as_micros();
        while let Ok(byte) = usb.read_byte() {
            board.receive(now_us, byte);
        }
        let strain_v = volts(&mut converter, &mut strain);
        let readings = Readings {
            pressure_mpa: (DIVIDER * volts(&mut converter, &mut pressure) - PRESSURE_ZERO_V) / PRESSURE_V_PER_MPA,
            supply_mpa: None,
            strain: (DIVIDER * strain_v - STRAIN_ZERO_V) * STRAIN_PER_VOLT,
            strain_at_end: !CONVERTER_V.contains(&strain_v),
            deflection_mm: (SLIDE_MM != 0.0).then(|| volts(&mut converter, &mut slide) / SLIDE_END_V * SLIDE_MM),
        };
        // After an error the watchdog is not fed, and restarts the board.
        if board.step(now_us, readings, &mut lines).is_ok() {
            watchdog.feed();
        }
        send(&mut usb, &mut lines);
    }
}

/// The voltage at a pin, V; not a number if the converter failed.
fn volts<'a, Pin: AdcChannel>(
    converter: &mut Adc<'a, ADC1<'a>, Blocking>,
    pin: &mut AdcPin<Pin, ADC1<'a>, AdcCalCurve<ADC1<'a>>>,
) -> f32 {
    let mut sum_mv = 0;
    for _ in 0..CONVERSIONS {
        match nb::block!(converter.read_oneshot(pin)) {
            Ok(mv) => sum_mv += u32::from(mv),
            Err(()) => return f32::NAN,
        }
    }
    sum_mv as f32 / CONVERSIONS as f32 / 1000.0
}

/// Sends as much as the USB host takes at once.
fn send(usb: &mut UsbSerialJtag<'_, Blocking>, lines: &mut Lines<LINES_MOST>) {
    let sent = lines.waiting().iter().take_while(|&&byte| usb.write_byte_nb(byte).is_ok()).count();
    if sent > 0 {
        lines.sent(sent);
        // Without a host the rest is sent with the next bytes.
        let _ = usb.flush_tx_nb();
    }
}

/// A restart closes both valves: their gates have resistors to ground.
#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    esp_hal::system::software_reset()
}
