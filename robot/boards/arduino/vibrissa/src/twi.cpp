#include "twi.h"

#include <Arduino.h>

namespace vibrissa {

// Passes of 0.5 us after which a bus counts as stuck: four times a byte.
static const uint16_t PASSES_MOST = 250;

// The status after the step of the bus; 0 if there is none.
static uint8_t status() {
    for (uint16_t i = 0; i < PASSES_MOST; i++) {
        if (TWCR & _BV(TWINT)) return TWSR & 0xf8;
    }
    return 0;
}

// The device has acknowledged an address to write to, or a byte. Some simulators do not distinguish them.
static bool is_acknowledged() {
    uint8_t now = status();
    return now == 0x18 || now == 0x28;
}

static bool start(uint8_t address, bool read) {
    TWCR = _BV(TWINT) | _BV(TWSTA) | _BV(TWEN);
    // A start, or a repeated one.
    uint8_t now = status();
    if (now != 0x08 && now != 0x10) return false;
    TWDR = address << 1 | read;
    TWCR = _BV(TWINT) | _BV(TWEN);
    return read ? status() == 0x40 : is_acknowledged();
}

static bool write(uint8_t byte) {
    TWDR = byte;
    TWCR = _BV(TWINT) | _BV(TWEN);
    return is_acknowledged();
}

static bool stop(bool good) {
    TWCR = _BV(TWINT) | _BV(TWSTO) | _BV(TWEN);
    for (uint16_t i = 0; i < PASSES_MOST; i++) {
        if (!(TWCR & _BV(TWSTO))) return good;
    }
    // Somebody holds the bus: let it go, and begin anew with the next start.
    TWCR = 0;
    return false;
}

void begin_twi() {
    pinMode(SDA, INPUT_PULLUP);
    pinMode(SCL, INPUT_PULLUP);
    TWSR = 0;
    TWBR = (F_CPU / 400000UL - 16) / 2;
}

bool write_register(uint8_t address, uint8_t which, uint16_t value) {
    return stop(start(address, false) && write(which) && write(value >> 8) && write(value & 0xff));
}

bool read_register(uint8_t address, uint8_t which, int16_t &value) {
    if (!start(address, false) || !write(which) || !start(address, true)) return stop(false);
    TWCR = _BV(TWINT) | _BV(TWEN) | _BV(TWEA);
    bool good = status() == 0x50;
    uint8_t high = TWDR;
    TWCR = _BV(TWINT) | _BV(TWEN);
    good = good && status() == 0x58;
    value = (int16_t)((uint16_t)high << 8 | TWDR);
    return stop(good);
}

}  // namespace vibrissa
