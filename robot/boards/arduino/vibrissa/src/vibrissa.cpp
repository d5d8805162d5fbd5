#include "vibrissa.h"

#include <Arduino.h>
#include <avr/wdt.h>

#include "configure.h"
#include "whisker.h"

namespace vibrissa {

static const uint16_t LINE_MOST = 200;
// Between two steps of a regulator: of the only one, and of the next one.
static const uint32_t ONE_STEP_US = 2000, STEP_US = 1500;
// Without a line `configure` for this long the changes are discarded.
static const uint32_t CONFIGURE_MS = 60000;
static const uint8_t NOTHING_TO_TELL = 255;

static Whisker whiskers[WHISKERS_MOST];
static Record record;
static bool configuring;
static uint32_t configured_ms, last_step_us;
static uint8_t turn, to_tell = NOTHING_TO_TELL;

static char line_in[LINE_MOST];
static uint8_t line_length;
static bool line_too_long, configure_waits;

// Orders are obeyed as soon as they are complete, because the serial buffer has 64 bytes: at 250000 baud they come in
// 2.6 ms, and a turn of the loop takes longer. The lines `configure` wait for the loop, as their answers need room.
static void take_line() {
    Part type = field(line_in, PSTR("type"));
    if (!type.begin || !is_whole(line_in)) return;
    if (is_text(type, PSTR("configure"))) configure_waits = true;
    if (is_text(type, PSTR("configuration"))) to_tell = 0;
    bool is_pressure = is_text(type, PSTR("set_pressure"));
    if (configuring || (!is_pressure && !is_text(type, PSTR("valve")))) return;
    Part array = field(line_in, PSTR("array")), whisker = field(line_in, PSTR("whisker"));
    // A line that names no whisker means all of them only if there is one.
    if (!whisker.begin && count_whiskers() > 1) return;
    for (uint8_t slot = 0; slot < WHISKERS_MOST; slot++) {
        if (settings.whiskers[slot].used && whiskers[slot].is_named(array, whisker)) {
            whiskers[slot].obey(line_in, is_pressure);
        }
    }
}

// Up to the end of one line, so that pulses end in time. Lines for richer drivers may be longer: they are not read.
static void receive() {
    while (!configure_waits) {
        int byte = Serial.read();
        if (byte < 0) return;
        if (byte == '\n') {
            line_in[line_length] = 0;
            bool is_read = !line_too_long;
            line_length = 0;
            line_too_long = false;
            if (is_read) return take_line();
        } else if (line_length < LINE_MOST - 1) {
            line_in[line_length++] = (char)byte;
        } else {
            line_too_long = true;
        }
    }
}

static void tick() {
    for (uint8_t slot = 0; open_valves && slot < WHISKERS_MOST; slot++) {
        if (settings.whiskers[slot].used) whiskers[slot].end_pulse();
    }
    receive();
}

static void begin_whiskers() {
    for (uint8_t slot = 0; slot < WHISKERS_MOST; slot++) {
        if (settings.whiskers[slot].used) whiskers[slot].begin(settings.whiskers[slot], record == BROKEN, slot);
    }
}

// From the first line `configure` on all valves are closed, and no order is obeyed.
static void begin_configuring() {
    configured_ms = millis();
    if (configuring) return;
    for (uint8_t slot = 0; slot < WHISKERS_MOST; slot++) {
        if (settings.whiskers[slot].used) whiskers[slot].release();
    }
    configuring = true;
}

static void put_configured(const char *how) {
    put(PSTR("{\"type\":\"configured\",\"changes\":\""));
    put(how);
    put(PSTR("\"}\n"));
}

static void end_configuring(const char *how) {
    put_configured(how);
    send_all();
    record = load();
    configuring = false;
    Serial.begin(settings.baud);
    begin_whiskers();
}

static void take_configure() {
    begin_configuring();
    // The answer needs room.
    send_all();
    Step step = configure(line_in);
    if (step == CHANGED) put_configured(PSTR("UNSAVED"));
    if (step == SAVE && check()) {
        save();
        end_configuring(PSTR("SAVED"));
    }
    if (step == DISCARD) end_configuring(PSTR("DISCARDED"));
    send_all();
}

static void put_hello() {
    // A restart may have cut a line: the first end of line separates it from this one.
    put(PSTR("\n{\"type\":\"hello\",\"version\":1,\"name\":\"vibrissa_board\",\"firmware_version\":\"" VIBRISSA_VERSION
             "\",\"whiskers\":"));
    put_number(count_whiskers());
    put(PSTR(",\"configuration\":\""));
    put(record == STORED ? PSTR("STORED") : record == UNSET ? PSTR("DEFAULT") : PSTR("BROKEN"));
    put(PSTR("\"}\n"));
}

void begin() {
    record = load();
    begin_whiskers();
    Serial.begin(settings.baud);
    wdt_enable(WDTO_2S);
    put_hello();
    last_step_us = micros();
}

static void regulate_next() {
    uint32_t now_us = micros();
    if (now_us - last_step_us < (count_whiskers() == 1 ? ONE_STEP_US : STEP_US)) return;
    last_step_us = now_us;
    do {
        if (++turn >= WHISKERS_MOST) turn = 0;
    } while (!settings.whiskers[turn].used);
    whiskers[turn].regulate();
}

void loop() {
    wdt_reset();
    tick();
    if (configure_waits) {
        take_configure();
        configure_waits = false;
    }
    if (to_tell != NOTHING_TO_TELL && !tell(to_tell, record)) to_tell = NOTHING_TO_TELL;
    send();
    if (configuring) {
        if (millis() - configured_ms >= CONFIGURE_MS) end_configuring(PSTR("DISCARDED"));
        return;
    }
    // A line takes up to 5 ms: there is one in a turn.
    bool has_put = false;
    for (uint8_t slot = 0; slot < WHISKERS_MOST; slot++) {
        if (!settings.whiskers[slot].used) continue;
        regulate_next();
        tick();
        whiskers[slot].watch();
        has_put |= whiskers[slot].sample(tick, !has_put);
        tick();
        whiskers[slot].report();
        tick();
        send();
        tick();
        // An HX711 is asked more often: a reading that begins as the next conversion ends would be spoilt.
        for (uint8_t other = 0; other < WHISKERS_MOST; other++) {
            const WhiskerSettings &set = settings.whiskers[other];
            if (!set.used || set.sensor != HX711) continue;
            has_put |= whiskers[other].sample(tick, !has_put);
            tick();
        }
    }
}

}  // namespace vibrissa
