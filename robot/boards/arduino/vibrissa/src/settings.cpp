#include "settings.h"

#include <avr/eeprom.h>
#include <avr/wdt.h>
#include <string.h>
#include <util/crc16.h>

namespace vibrissa {

// Raise it when Settings changes: older records then count as foreign.
static const uint8_t VERSION = 1;
static const uint8_t MAGIC[] PROGMEM = {'V', 'I', 'B', VERSION, WHISKERS_MOST};
// The record: magic, settings, checksum of both.
static uint8_t *const FIRST = 0;

Settings settings;

static uint16_t sum_of_magic() {
    uint16_t sum = 0xffff;
    for (uint8_t i = 0; i < sizeof MAGIC; i++) sum = _crc16_update(sum, pgm_read_byte(MAGIC + i));
    return sum;
}

Record load() {
    bool blank = true, ours = true;
    for (uint8_t i = 0; i < sizeof MAGIC; i++) {
        uint8_t byte = eeprom_read_byte(FIRST + i);
        blank &= byte == 0xff;
        ours &= byte == pgm_read_byte(MAGIC + i);
    }
    if (ours) {
        uint16_t sum = sum_of_magic(), at = sizeof MAGIC;
        for (uint16_t i = 0; i < sizeof settings; i++) {
            uint8_t byte = eeprom_read_byte(FIRST + at++);
            ((uint8_t *)&settings)[i] = byte;
            sum = _crc16_update(sum, byte);
        }
        uint16_t stored = eeprom_read_byte(FIRST + at) | (uint16_t)eeprom_read_byte(FIRST + at + 1) << 8;
        if (sum == stored) return STORED;
    }
    load_defaults();
    return blank ? UNSET : BROKEN;
}

static void write(uint16_t at, uint8_t byte) {
    wdt_reset();
    eeprom_update_byte(FIRST + at, byte);
}

void save() {
    // Until the last byte is written, the checksum is that of no record.
    uint16_t sum = sum_of_magic(), at = sizeof MAGIC;
    for (uint8_t i = 0; i < sizeof MAGIC; i++) write(i, pgm_read_byte(MAGIC + i));
    for (uint16_t i = 0; i < sizeof settings; i++) {
        uint8_t byte = ((const uint8_t *)&settings)[i];
        write(at++, byte);
        sum = _crc16_update(sum, byte);
    }
    write(at, sum & 0xff);
    write(at + 1, sum >> 8);
}

void set_defaults(WhiskerSettings &whisker, uint8_t slot) {
    memset(&whisker, 0, sizeof whisker);
    strcpy_P(whisker.array, PSTR("left"));
    whisker.whisker = slot + 1;
    whisker.fill_pin = slot ? NO_PIN : 4;
    whisker.vent_pin = slot ? NO_PIN : 5;
    whisker.pressure_pin = slot ? NO_PIN : A0;
    whisker.pressure_zero_v = 1.0f;
    whisker.pressure_v_per_mpa = 4.0f;
    whisker.limit_mpa = 0.2f;
    whisker.sensor = slot ? NO_SENSOR : ANALOG;
    whisker.strain_pin = slot ? NO_PIN : A1;
    whisker.data_pin = whisker.clock_pin = NO_PIN;
    whisker.pulses = 25;
    whisker.address = 72;
    whisker.range = 1;
    whisker.strain_zero_v = 2.5f;
    whisker.strain_per_v = 0.002f;
    whisker.rate_hz = 100;
    whisker.slide_pin = NO_PIN;
}

void load_defaults() {
    settings.baud = 115200;
    for (uint8_t slot = 0; slot < WHISKERS_MOST; slot++) set_defaults(settings.whiskers[slot], slot);
    settings.whiskers[0].used = 1;
}

uint8_t count_whiskers() {
    uint8_t count = 0;
    for (uint8_t slot = 0; slot < WHISKERS_MOST; slot++) count += settings.whiskers[slot].used;
    return count;
}

}  // namespace vibrissa
