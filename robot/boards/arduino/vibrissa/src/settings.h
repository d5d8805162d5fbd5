// The configuration of the board, and its record in the EEPROM.
#pragma once

#include <Arduino.h>

namespace vibrissa {

// Whiskers that the memory of the board can serve.
#if RAMEND > 0x1000
static const uint8_t WHISKERS_MOST = 6;
#else
static const uint8_t WHISKERS_MOST = 2;
#endif
static const uint8_t ARRAY_MOST = 16;
static const uint8_t NO_PIN = 255;
static const uint8_t RATE_LEAST = 10, RATE_MOST = 200;

enum Sensor : uint8_t { NO_SENSOR, ANALOG, HX711, ADS1115, SENSORS };

// One whisker. Pins are those of digitalRead(), also for analog inputs.
struct WhiskerSettings {
    uint8_t used;
    char array[ARRAY_MOST + 1];
    uint16_t whisker;
    uint8_t fill_pin, vent_pin, pressure_pin;
    // Voltage of the pressure sensor at 0 MPa, and its slope.
    float pressure_zero_v, pressure_v_per_mpa;
    // Never above it, whatever a line asks for.
    float limit_mpa;
    uint8_t sensor;
    // ANALOG: the pin. HX711: data and clock. ADS1115: nothing.
    uint8_t strain_pin, data_pin, clock_pin;
    // HX711: gain 128, 64 or 32, by its number of clock pulses.
    uint8_t pulses;
    // ADS1115: address, input multiplexer and range, as in its configuration register.
    uint8_t address, inputs, range;
    // strain = (V - strain_zero_v) * strain_per_v; negative if a touch lowers the voltage.
    float strain_zero_v, strain_per_v;
    // Samples a second; an HX711 has its own rate.
    uint8_t rate_hz;
    // Slide potentiometer that measures the way of the whisker's base: mm from 0 to 5 V, negative if turned round.
    uint8_t slide_pin;
    float slide_mm;
};

struct Settings {
    uint32_t baud;
    WhiskerSettings whiskers[WHISKERS_MOST];
};

// Origin of the settings.
enum Record : uint8_t {
    // The EEPROM is blank: nobody has configured the board.
    UNSET,
    STORED,
    // The record is damaged, of another version, or of another program. The valves stay closed.
    BROKEN,
};

extern Settings settings;

// Loads the record, or the defaults.
Record load();
void load_defaults();
void set_defaults(WhiskerSettings &whisker, uint8_t slot);
// Takes half a second on a Mega.
void save();
uint8_t count_whiskers();

}  // namespace vibrissa
