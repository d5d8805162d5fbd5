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
static bool line_too_long, line_complete;

// Lines for richer drivers may be longer: they are not read.
static void receive() {
    while (!line_complete && Serial.available() > 0) {
        char byte = (char)Serial.read();
        if (byte == '\n') {
            line_in[line_length] = 0;
            line_complete = !line_too_long;
            line_length = 0;
            line_too_long = false;
        } else if (line_length < LINE_MOST - 1) {
            line_in[line_length++] = byte;
        } else {
            line_too_long = true;
        }
    }
}

static void tick() {
    for (uint8_t slot = 0; slot < WHISKERS_MOST; slot++) {
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

static void take_configure(const char *line) {
    begin_configuring();
    // The answer needs room.
    send_all();
    Step step = configure(line);
    if (step == CHANGED) put_configured(PSTR("UNSAVED"));
    if (step == SAVE && check()) {
        save();
        end_configuring(PSTR("SAVED"));
    }
    if (step == DISCARD) end_configuring(PSTR("DISCARDED"));
    send_all();
}

static void take_line(const char *line) {
    Part type = field(line, PSTR("type"));
    if (!type.begin || !is_whole(line)) return;
    if (is_text(type, PSTR("configure"))) return take_configure(line);
    if (is_text(type, PSTR("configuration"))) to_tell = 0;
    if (configuring) return;
    for (uint8_t slot = 0; slot < WHISKERS_MOST; slot++) {
        if (settings.whiskers[slot].used && whiskers[slot].is_mine(line)) whiskers[slot].obey(line);
    }
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
    if (line_complete) {
        take_line(line_in);
        line_complete = false;
    }
    if (to_tell != NOTHING_TO_TELL && !tell(to_tell, record)) to_tell = NOTHING_TO_TELL;
    send();
    if (configuring) {
        if (millis() - configured_ms >= CONFIGURE_MS) end_configuring(PSTR("DISCARDED"));
        return;
    }
    for (uint8_t slot = 0; slot < WHISKERS_MOST; slot++) {
        if (!settings.whiskers[slot].used) continue;
        regulate_next();
        tick();
        whiskers[slot].watch();
        whiskers[slot].sample(tick);
        whiskers[slot].report();
    }
}

}  // namespace vibrissa
