#include "configure.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "keys.h"

namespace vibrissa {

static const uint8_t NO_SLOT = 255;

static void put_error(uint8_t slot) {
    put(PSTR("{\"type\":\"error\","));
    if (slot == NO_SLOT) return;
    put(PSTR("\"slot\":"));
    put_number(slot);
    put(',');
}

static Step refuse(uint8_t slot, const char *problem, const char *what_to_do) {
    put_error(slot);
    put(PSTR("\"problem\":\""));
    put(problem);
    put(PSTR("\",\"do\":\""));
    put(what_to_do);
    put(PSTR("\"}\n"));
    return REFUSED;
}

static Step refuse_value(uint8_t slot, Part key, Part value, const Key *known) {
    put_error(slot);
    put(PSTR("\"key\":\""));
    put_part(key);
    put(PSTR("\",\"problem\":\""));
    put_part(value);
    put(PSTR(" is not allowed\",\"do\":\"send "));
    put_allowed(*known);
    put(PSTR("\"}\n"));
    return REFUSED;
}

static Step set_baud(Part value) {
    long baud = whole(value, 1000000);
    if (baud != 115200 && baud != 250000 && baud != 500000) {
        return refuse(NO_SLOT, PSTR("baud has another value"), PSTR("send 115200, 250000 or 500000"));
    }
    settings.baud = baud;
    return CHANGED;
}

// A line without a slot: it has one key of the board.
static Step configure_board(const char *line) {
    Part baud = field(line, PSTR("baud"));
    if (baud.begin) return set_baud(baud);
    if (is_true(field(line, PSTR("save")))) return SAVE;
    if (is_true(field(line, PSTR("discard")))) return DISCARD;
    if (is_true(field(line, PSTR("defaults")))) {
        load_defaults();
        return CHANGED;
    }
    return refuse(NO_SLOT, PSTR("the line has no slot"), PSTR("send slot, or baud, defaults, save or discard"));
}

Step configure(const char *line) {
    Part slot_text = field(line, PSTR("slot"));
    if (!slot_text.begin) return configure_board(line);
    long slot = whole(slot_text, WHISKERS_MOST - 1);
    if (slot < 0) {
        return refuse(NO_SLOT, PSTR("the board has no such slot"),
                      WHISKERS_MOST == 2 ? PSTR("send slot 0 or 1") : PSTR("send slot 0 to 5"));
    }
    // A line is taken as a whole or not at all.
    WhiskerSettings set = settings.whiskers[slot];
    set.used = 1;
    Part key, value;
    bool bad = false;
    for (const char *at = line; next_pair(at, key, value, bad);) {
        if (is_key(key, PSTR("type")) || is_key(key, PSTR("slot"))) continue;
        if (is_key(key, PSTR("remove")) && is_true(value)) {
            set_defaults(set, slot);
            continue;
        }
        const Key *known = find_key(key);
        if (!known) {
            put_error(slot);
            put(PSTR("\"key\":\""));
            put_part(key);
            put(PSTR("\",\"problem\":\"the board has no such key\",\"do\":\"see docs/driver-interface.md\"}\n"));
            return REFUSED;
        }
        if (!take_value(*known, value, set)) return refuse_value(slot, key, value, known);
    }
    if (bad) {
        return refuse(slot, PSTR("the line is no flat JSON object"), PSTR("send names and numbers without nesting"));
    }
    settings.whiskers[slot] = set;
    return CHANGED;
}

// Bytes a second of the lines of a whisker, at most.
static uint16_t bytes_per_s(const WhiskerSettings &set) {
    uint16_t head = 75 + strlen(set.array), rate = set.sensor == HX711 ? 90 : set.rate_hz;
    bool slide = set.slide_pin != NO_PIN;
    if (set.sensor == NO_SENSOR && !slide) return 4 * (head + 55);
    uint16_t lines = rate > 100 ? (rate + 9) / 10 : 11;
    return lines * (head + 25 + (slide ? 20 : 0)) + rate * ((set.sensor ? 10 : 0) + (slide ? 7 : 0)) + 4 * (head + 55);
}

static bool check_load() {
    uint32_t bytes = 0, samples = 0;
    for (uint8_t slot = 0; slot < WHISKERS_MOST; slot++) {
        const WhiskerSettings &set = settings.whiskers[slot];
        if (!set.used) continue;
        bytes += bytes_per_s(set);
        samples += set.sensor == HX711 ? 90 : set.rate_hz;
    }
    if (samples > 600) {
        refuse(NO_SLOT, PSTR("all whiskers have more than 600 samples a second"), PSTR("send smaller rate_hz"));
        return false;
    }
    // A byte has ten bits.
    if (bytes <= settings.baud / 10) return true;
    put_error(NO_SLOT);
    put(PSTR("\"problem\":\"the lines need "));
    put_number(bytes);
    put(PSTR(" bytes a second, and the serial line carries "));
    put_number(settings.baud / 10);
    put(PSTR("\",\"do\":\"send a larger baud or smaller rate_hz\"}\n"));
    return false;
}

static bool refuse_pin(uint8_t slot, const char *key, const char *problem) {
    put_error(slot);
    put(PSTR("\"key\":\""));
    put(key);
    put(PSTR("\",\"problem\":\""));
    put(problem);
    put(PSTR("\",\"do\":\"send another pin\"}\n"));
    return false;
}

// Pins by their bits.
struct Pins {
    uint8_t bits[(NUM_DIGITAL_PINS + 7) / 8];
    bool has(uint8_t pin) const { return bits[pin / 8] & 1 << pin % 8; }
    void add(uint8_t pin) { bits[pin / 8] |= 1 << pin % 8; }
};

static bool add_pin(Pins &taken, uint8_t slot, const char *key, uint8_t pin) {
    if (pin == NO_PIN) return refuse_pin(slot, key, PSTR("the whisker needs this pin"));
    if (taken.has(pin)) return refuse_pin(slot, key, PSTR("the pin has another use, too"));
    taken.add(pin);
    return true;
}

static bool check_pins() {
    Pins taken;
    memset(&taken, 0, sizeof taken);
    for (uint8_t slot = 0; slot < WHISKERS_MOST; slot++) {
        const WhiskerSettings &set = settings.whiskers[slot];
        if (set.used && set.sensor == ADS1115) {
            taken.add(SDA);
            taken.add(SCL);
        }
    }
    for (uint8_t slot = 0; slot < WHISKERS_MOST; slot++) {
        const WhiskerSettings &set = settings.whiskers[slot];
        if (!set.used) continue;
        if (!add_pin(taken, slot, PSTR("fill_pin"), set.fill_pin)
            || !add_pin(taken, slot, PSTR("vent_pin"), set.vent_pin)
            || !add_pin(taken, slot, PSTR("pressure_pin"), set.pressure_pin)) return false;
        if (set.sensor == ANALOG && !add_pin(taken, slot, PSTR("strain_pin"), set.strain_pin)) return false;
        if (set.sensor == HX711 && (!add_pin(taken, slot, PSTR("data_pin"), set.data_pin)
                                    || !add_pin(taken, slot, PSTR("clock_pin"), set.clock_pin))) return false;
    }
    // One slide may move several whiskers.
    for (uint8_t slot = 0; slot < WHISKERS_MOST; slot++) {
        const WhiskerSettings &set = settings.whiskers[slot];
        if (set.used && set.slide_pin != NO_PIN && taken.has(set.slide_pin)) {
            return refuse_pin(slot, PSTR("slide_pin"), PSTR("the pin has another use, too"));
        }
    }
    return true;
}

bool check() {
    if (!count_whiskers()) {
        refuse(NO_SLOT, PSTR("no whisker is configured"), PSTR("send the keys of slot 0"));
        return false;
    }
    for (uint8_t slot = 1; slot < WHISKERS_MOST; slot++) {
        for (uint8_t other = 0; other < slot; other++) {
            const WhiskerSettings &a = settings.whiskers[slot], &b = settings.whiskers[other];
            if (a.used && b.used && a.whisker == b.whisker && !strcmp(a.array, b.array)) {
                refuse(slot, PSTR("two slots have the same array and whisker"), PSTR("send another whisker"));
                return false;
            }
        }
    }
    for (uint8_t slot = 0; slot < WHISKERS_MOST; slot++) {
        const WhiskerSettings &set = settings.whiskers[slot];
        // Beyond the end of the converter nobody would see a pressure above the limit.
        if (!set.used || set.pressure_zero_v + set.limit_mpa * set.pressure_v_per_mpa <= 4.9f) continue;
        refuse(slot, PSTR("limit_mpa is above 4.9 V of the pressure sensor"), PSTR("send a smaller limit_mpa"));
        return false;
    }
    return check_pins() && check_load();
}

bool tell(uint8_t &at, Record record) {
    static const uint8_t LINES = (KEYS + 4) / 5;
    // Readings go first.
    if (out_room() < SPARE_ROOM) return true;
    if (at == 0) {
        put(PSTR("{\"type\":\"configuration\",\"record\":\""));
        put(record == STORED ? PSTR("STORED") : record == UNSET ? PSTR("DEFAULT") : PSTR("BROKEN"));
        put(PSTR("\",\"slots\":"));
        put_number(WHISKERS_MOST);
        put(PSTR(",\"baud\":"));
        put_number(settings.baud);
        put(PSTR("}\n"));
        at = 1;
        return true;
    }
    uint8_t slot = (at - 1) / LINES, first = (at - 1) % LINES * 5;
    if (slot == WHISKERS_MOST) return false;
    at++;
    if (!settings.whiskers[slot].used) return true;
    put(PSTR("{\"type\":\"configuration\",\"slot\":"));
    put_number(slot);
    for (uint8_t key = first; key < KEYS && key < first + 5; key++) put_value(key, settings.whiskers[slot]);
    put(PSTR("}\n"));
    return true;
}

}  // namespace vibrissa
