#include "gauge.h"

#include <math.h>

#include "twi.h"

namespace vibrissa {

// An HX711 of 10 Hz that is silent for longer is absent; none is faster than 144 Hz.
static const uint32_t HX711_ABSENT_US = 600000, HX711_LEAST_US = 5000;
static const int32_t HX711_MOST = 0x7fffff, HX711_LEAST = -0x800000L;
// An ADS1115 converts in 1.16 ms at 860 a second, 10 % more by its clock, and 0.03 ms to wake up.
static const uint32_t ADS1115_US = 1400;
// Largest strain that a line tells, in units of 1e-7: 1.
static const float STRAIN_MOST = 1e7f;

// One conversion at a time on the bus: several whiskers may share an ADS1115.
static const Gauge *bus_of;

void Gauge::begin(const WhiskerSettings &set) {
    settling = 5;
    pending = false;
    bus_of = 0;
    since_us = micros();
    if (set.sensor == HX711) {
        pinMode(set.data_pin, INPUT_PULLUP);
        // More than 60 us high would switch it off.
        digitalWrite(set.clock_pin, LOW);
        pinMode(set.clock_pin, OUTPUT);
    } else if (set.sensor == ADS1115) {
        begin_twi();
    }
}

Sample Gauge::read(const WhiskerSettings &set, bool due, int32_t &strain) {
    float volts = 0.0f;
    Sample sample = WAITING;
    if (set.sensor == ANALOG) {
        if (!due) return WAITING;
        int raw = analogRead(set.strain_pin);
        volts = (raw + 0.5f) * VOLTS_PER_STEP;
        sample = raw <= 1 || raw >= 1022 ? CLIPPED : GOOD;
    } else if (set.sensor == HX711) {
        sample = read_hx711(set, volts);
    } else if (set.sensor == ADS1115) {
        sample = read_ads1115(set, due, volts);
    }
    if (sample != GOOD && sample != CLIPPED) return sample;
    float scaled = (volts - set.strain_zero_v) * set.strain_per_v * 1e7f;
    if (fabs(scaled) > STRAIN_MOST) {
        scaled = scaled < 0 ? -STRAIN_MOST : STRAIN_MOST;
        sample = CLIPPED;
    }
    strain = lround(scaled);
    return sample;
}

// The 24 bits of the conversion, and pulses that choose channel and gain of the next one: 25 for A with 128, 26 for B
// with 32, 27 for A with 64. An interrupt may not lengthen a pulse, as 60 us switch the chip off.
static int32_t shift_in(uint8_t data_pin, uint8_t clock_pin, uint8_t pulses) {
    volatile uint8_t *clock = portOutputRegister(digitalPinToPort(clock_pin));
    volatile uint8_t *data = portInputRegister(digitalPinToPort(data_pin));
    uint8_t clock_bit = digitalPinToBitMask(clock_pin), data_bit = digitalPinToBitMask(data_pin);
    uint32_t bits = 0;
    for (uint8_t i = 0; i < pulses; i++) {
        uint8_t interrupts = SREG;
        cli();
        *clock |= clock_bit;
        // The bit is there 0.1 us after the edge; the pulse lasts 0.2 us or more.
        __asm__ __volatile__("nop\n\tnop\n\tnop\n\tnop");
        bool bit = *data & data_bit;
        *clock &= ~clock_bit;
        SREG = interrupts;
        if (i < 24) bits = bits << 1 | bit;
    }
    return bits & 0x800000 ? (int32_t)(bits | 0xff000000) : (int32_t)bits;
}

Sample Gauge::read_hx711(const WhiskerSettings &set, float &volts) {
    uint32_t now_us = micros();
    if (now_us - since_us < HX711_LEAST_US) return WAITING;
    bool ready = digitalRead(set.data_pin) == LOW;
    if (!ready && now_us - since_us < HX711_ABSENT_US) return WAITING;
    since_us = now_us;
    if (!ready) return ABSENT;
    int32_t raw = shift_in(set.data_pin, set.clock_pin, set.pulses);
    // After its data the chip lets the line rise. A line that stays low is no HX711, or one without a supply.
    if (digitalRead(set.data_pin) == LOW) return ABSENT;
    if (settling) {
        settling--;
        return WAITING;
    }
    // Half of the supply of 5 V over the gain is the end of the scale.
    uint8_t gain = set.pulses == 25 ? 128 : set.pulses == 26 ? 32 : 64;
    volts = raw * (2.5f / 8388608.0f) / gain;
    return raw <= HX711_LEAST || raw >= HX711_MOST ? CLIPPED : GOOD;
}

Sample Gauge::read_ads1115(const WhiskerSettings &set, bool due, float &volts) {
    static const float ranges_v[] PROGMEM = {6.144f, 4.096f, 2.048f, 1.024f, 0.512f, 0.256f};
    uint32_t now_us = micros();
    // A sample that comes while another whisker has the bus waits for it.
    if (due) pending = true;
    if (pending && !bus_of) {
        pending = false;
        // Start one conversion, at 860 a second, without comparator.
        uint16_t config = 0x81e3 | (uint16_t)set.inputs << 12 | (uint16_t)set.range << 9;
        if (!write_register(set.address, 1, config)) return ABSENT;
        bus_of = this;
        // The conversion begins when the order is complete.
        since_us = micros();
        return WAITING;
    }
    if (bus_of != this || now_us - since_us < ADS1115_US) return WAITING;
    bus_of = 0;
    int16_t raw;
    if (!read_register(set.address, 0, raw)) return ABSENT;
    volts = raw * (pgm_read_float(ranges_v + set.range) / 32768.0f);
    return raw == INT16_MIN || raw == INT16_MAX ? CLIPPED : GOOD;
}

}  // namespace vibrissa
