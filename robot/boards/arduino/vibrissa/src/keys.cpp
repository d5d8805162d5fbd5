#include "keys.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

namespace vibrissa {

#define AT(member) offsetof(WhiskerSettings, member)
static const Key keys[KEYS] PROGMEM = {
    {"array", NAME, AT(array), 0, 0},
    {"whisker", NUMBER_OF_WHISKER, AT(whisker), 0, 65535},
    {"fill_pin", VALVE_PIN, AT(fill_pin), 0, 0},
    {"vent_pin", VALVE_PIN, AT(vent_pin), 0, 0},
    {"limit_mpa", REAL, AT(limit_mpa), 0.01f, 0.2f},
    {"pressure_pin", ANALOG_PIN, AT(pressure_pin), 0, 0},
    {"pressure_zero_v", REAL, AT(pressure_zero_v), 0.1f, 4.0f},
    {"pressure_v_per_mpa", REAL, AT(pressure_v_per_mpa), 1.0f, 50.0f},
    {"slide_pin", ANALOG_PIN, AT(slide_pin), 0, 0},
    {"slide_mm", SIGNED, AT(slide_mm), 1.0f, 300.0f},
    {"strain_sensor", SENSOR_WORD, AT(sensor), 0, 0},
    {"strain_pin", ANALOG_PIN, AT(strain_pin), 0, 0},
    {"data_pin", DIGITAL_PIN, AT(data_pin), 0, 0},
    {"clock_pin", DIGITAL_PIN, AT(clock_pin), 0, 0},
    {"gain", GAIN, AT(pulses), 0, 0},
    {"address", ADDRESS, AT(address), 72, 75},
    {"inputs", INPUTS, AT(inputs), 0, 0},
    {"range_v", RANGE, AT(range), 0, 0},
    {"strain_zero_v", REAL, AT(strain_zero_v), -5.0f, 5.0f},
    {"strain_per_v", SIGNED, AT(strain_per_v), 1e-5f, 100.0f},
    {"rate_hz", RATE, AT(rate_hz), RATE_LEAST, RATE_MOST},
};

static const char sensors[SENSORS][9] PROGMEM = {"NONE", "ANALOG", "HX711", "ADS1115"};
static const char inputs[8][4] PROGMEM = {"0-1", "0-3", "1-3", "2-3", "0", "1", "2", "3"};
// Ranges of an ADS1115 in mV, by their number. That of 6.144 V is left out: its end is beyond the supply.
static const uint16_t ranges_mv[] PROGMEM = {0, 4096, 2048, 1024, 512, 256};

const Key *find_key(Part name) {
    for (uint8_t i = 0; i < KEYS; i++) {
        if (is_key(name, keys[i].name)) return keys + i;
    }
    return 0;
}

static bool take_name(Part value, char *array) {
    if (value.length < 3 || value.length > ARRAY_MOST + 2 || value.begin[0] != '"') return false;
    for (uint8_t i = 1; i + 1 < value.length; i++) {
        char byte = value.begin[i];
        bool letter = (byte >= 'A' && byte <= 'Z') || (byte >= 'a' && byte <= 'z') || (byte >= '0' && byte <= '9');
        if (!letter && byte != '_' && byte != '-') return false;
    }
    memcpy(array, value.begin + 1, value.length - 2);
    array[value.length - 2] = 0;
    return true;
}

static bool take_pin(KeyKind kind, Part value, uint8_t &pin) {
    if (is_text(value, PSTR("NONE"))) {
        pin = NO_PIN;
        return true;
    }
    long found = whole(value, NUM_DIGITAL_PINS - 1);
    if (found < 0 && value.length > 3 && value.begin[1] == 'A') {
        long analog = whole({value.begin + 2, (uint8_t)(value.length - 3)}, NUM_ANALOG_INPUTS - 1);
        if (analog >= 0) found = A0 + analog;
    }
    // 0 and 1 are the serial line. The bootloader blinks with 13: a valve there would open at each start.
    if (found < 2 || (kind == VALVE_PIN && found == LED_BUILTIN)) return false;
    if (kind == ANALOG_PIN && (found < A0 || found >= A0 + NUM_ANALOG_INPUTS)) return false;
    pin = found;
    return true;
}

static bool take_word(Part value, const char *words, uint8_t size, uint8_t count, uint8_t &place) {
    for (uint8_t i = 0; i < count; i++) {
        if (!is_text(value, words + i * size)) continue;
        place = i;
        return true;
    }
    return false;
}

static bool take_number(const Key &key, Part value, void *place) {
    float given = number(value), size = key.kind == SIGNED ? fabs(given) : given;
    // The comparison is false for a value that is not a number.
    if (!(size >= key.low && size <= key.high)) return false;
    if (key.kind == REAL || key.kind == SIGNED) {
        memcpy(place, &given, sizeof given);
        return true;
    }
    *(uint8_t *)place = (uint8_t)given;
    return given == (uint8_t)given;
}

static bool take_range(Part value, uint8_t &range) {
    float given_mv = number(value) * 1000.0f;
    for (uint8_t i = 1; i < 6; i++) {
        if (fabs(given_mv - pgm_read_word(ranges_mv + i)) > 0.1f || isnan(given_mv)) continue;
        range = i;
        return true;
    }
    return false;
}

bool take_value(const Key &in_flash, Part value, WhiskerSettings &set) {
    Key key;
    memcpy_P(&key, &in_flash, sizeof key);
    uint8_t *place = (uint8_t *)&set + key.offset;
    switch (key.kind) {
        case NAME: return take_name(value, (char *)place);
        case NUMBER_OF_WHISKER: {
            long given = whole(value, 65535);
            if (given >= 0) set.whisker = given;
            return given >= 0;
        }
        case VALVE_PIN:
        case DIGITAL_PIN:
        case ANALOG_PIN: return take_pin(key.kind, value, *place);
        case SENSOR_WORD: return take_word(value, sensors[0], sizeof sensors[0], SENSORS, *place);
        case INPUTS: return take_word(value, inputs[0], sizeof inputs[0], 8, *place);
        case GAIN: {
            long gain = whole(value, 128);
            if (gain != 128 && gain != 64 && gain != 32) return false;
            *place = gain == 128 ? 25 : gain == 32 ? 26 : 27;
            return true;
        }
        case RANGE: return take_range(value, *place);
        default: return take_number(key, value, place);
    }
}

void put_allowed(const Key &in_flash) {
    Key key;
    memcpy_P(&key, &in_flash, sizeof key);
    switch (key.kind) {
        case NAME: return put(PSTR("1 to 16 of A-Z a-z 0-9 _ -"));
        case VALVE_PIN: return put(PSTR("a digital pin from 2 on, but not 13: it blinks at the start"));
        case DIGITAL_PIN: return put(PSTR("a digital pin from 2 on"));
        case ANALOG_PIN: return put(NUM_ANALOG_INPUTS == 6 ? PSTR("A0 to A5, or NONE") : PSTR("A0 to A15, or NONE"));
        case SENSOR_WORD: return put(PSTR("ANALOG, HX711, ADS1115 or NONE"));
        case GAIN: return put(PSTR("128, 64 or 32"));
        case INPUTS: return put(PSTR("0-1, 0-3, 1-3, 2-3, 0, 1, 2 or 3 as a string"));
        case RANGE: return put(PSTR("4.096, 2.048, 1.024, 0.512 or 0.256"));
        default: break;
    }
    put(PSTR("a number from "));
    put_float(key.low);
    put(PSTR(" to "));
    put_float(key.high);
    if (key.kind == SIGNED) put(PSTR(", or its negative"));
}

static void put_quoted(const char *word_in_flash) {
    put('"');
    put(word_in_flash);
    put('"');
}

void put_value(uint8_t which, const WhiskerSettings &set) {
    Key key;
    memcpy_P(&key, keys + which, sizeof key);
    const uint8_t *place = (const uint8_t *)&set + key.offset;
    // Keys without a value, and those of the other sensors, are left out.
    bool is_pin = key.kind == VALVE_PIN || key.kind == DIGITAL_PIN || key.kind == ANALOG_PIN;
    bool of_hx711 = key.kind == DIGITAL_PIN || key.kind == GAIN;
    bool of_ads1115 = key.kind == ADDRESS || key.kind == INPUTS || key.kind == RANGE;
    float value = 0.0f;
    if (key.kind == REAL || key.kind == SIGNED) memcpy(&value, place, sizeof value);
    if ((is_pin && *place == NO_PIN) || (key.kind == SIGNED && value == 0.0f)) return;
    if ((of_hx711 && set.sensor != HX711) || (of_ads1115 && set.sensor != ADS1115)) return;
    put(',');
    put('"');
    put_text(key.name);
    put('"');
    put(':');
    switch (key.kind) {
        case NAME:
            put('"');
            put_text(set.array);
            return put('"');
        case NUMBER_OF_WHISKER: return put_number(set.whisker);
        case VALVE_PIN:
        case DIGITAL_PIN:
        case ANALOG_PIN: return put_pin(*place);
        case SENSOR_WORD: return put_quoted(sensors[*place]);
        case INPUTS: return put_quoted(inputs[*place]);
        case GAIN: return put_number(*place == 25 ? 128 : *place == 26 ? 32 : 64);
        case RANGE: return put_fixed(pgm_read_word(ranges_mv + *place), 3);
        case REAL:
        case SIGNED: return put_float(value);
        default: return put_number(*place);
    }
}

}  // namespace vibrissa
