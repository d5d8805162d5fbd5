// A board for one whisker: two on/off valves, a pressure sensor and a strain gauge, for an Arduino Uno or Mega.
//
// Speaks the driver interface of vibrissa-robot over serial, 115200 baud: one JSON object per line. It regulates the
// pressure by itself (regulator.h), and vents if it hears no order for 5 seconds. robot/boards/README.md has the wiring.

#include <Arduino.h>
#include <avr/wdt.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "regulator.h"

// Pins. Each valve hangs on a transistor with a diode, and is closed without current. Resistors to ground keep both
// valves closed while the board starts.
static const uint8_t FILL_PIN = 4;
static const uint8_t VENT_PIN = 5;
static const uint8_t PRESSURE_PIN = A0;
static const uint8_t STRAIN_PIN = A1;
static const uint8_t SLIDE_PIN = A2;

// This board's whisker, as in the robot's factsheet.
static const char ARRAY[] = "left";
static const long WHISKER = 1;

// Pressure sensor: MPa = (V - 1) / 4, and 5 V full scale. Never above the limit, whatever a line asks for.
static const float VOLTS_PER_STEP = 5.0f / 1024.0f;
static const float LIMIT_MPA = 0.2f;
// Strain of the gauge with its amplifier: strain = (V - 2.5) * STRAIN_PER_VOLT. The converter ends at 2.5 V from rest: at a
// strain of 0.005 here, which is 1.4 mm of deflection at the tip. At its end the board reports a saturated gauge.
static const float STRAIN_PER_VOLT = 0.002f;
static const int STRAIN_LEAST = 1, STRAIN_MOST = 1022;
// Slide potentiometer that measures the way of the whisker's base: mm from 0 to 5 V; 0 without one. Contacts need it.
static const float SLIDE_MM = 0.0f;

static const unsigned long STEP_US = 2000;
static const unsigned long STRAIN_US = 10000;
static const unsigned long PRESSURE_MS = 250;
static const unsigned long SILENT_MS = 5000;
static const unsigned long PULSE_MOST_US = 1000000;
static const uint8_t SAMPLES = 10;
// Lines of strain below the end of the converter after which the gauge counts as in order, and between two reports.
static const uint8_t CLEAN_LINES = 100, REPORT_LINES = 20;

static vibrissa::Regulator regulator;

// Differences of unsigned times stay right when micros() and millis() wrap around.
static unsigned long last_step_us, last_strain_us, last_pressure_ms, last_line_ms;
static unsigned long pulse_begin_us, pulse_us;
static uint8_t open_pin;
static bool by_hand, silent;
static float pressure_mpa;

static float strains[SAMPLES], ways_mm[SAMPLES];
static uint8_t strain_count;
static unsigned long strain_ms;
static bool at_end, saturated;
static uint8_t clean_lines, report_lines;

static char line_in[200];
static uint8_t line_length;
static bool line_too_long;

// Lines wait here, as a full serial buffer would hold up the valves. A power of two, as the indices wrap around.
static const uint16_t OUT_SIZE = 512;
static char out[OUT_SIZE];
static uint16_t out_begin, out_end;

static void close_valves() {
    digitalWrite(FILL_PIN, LOW);
    digitalWrite(VENT_PIN, LOW);
    open_pin = 0;
}

static void open_valve(uint8_t pin, unsigned long us) {
    close_valves();
    if (us == 0) return;
    pulse_us = us < PULSE_MOST_US ? us : PULSE_MOST_US;
    pulse_begin_us = micros();
    open_pin = pin;
    digitalWrite(pin, HIGH);
}

static void end_pulse() {
    if (open_pin && micros() - pulse_begin_us >= pulse_us) close_valves();
}

static void put(const char *text) {
    for (; *text; text++) out[out_end++ % OUT_SIZE] = *text;
}

static void put_number(unsigned long number) {
    char digits[11];
    ultoa(number, digits, 10);
    put(digits);
}

static void put_decimal(float number, uint8_t places) {
    char digits[16];
    dtostrf(number, 1, places, digits);
    put(digits);
}

static uint16_t out_room() { return OUT_SIZE - (uint16_t)(out_end - out_begin); }

static void send() {
    while (out_begin != out_end && Serial.availableForWrite() > 0) Serial.write(out[out_begin++ % OUT_SIZE]);
}

static void put_head(const char *type, unsigned long ms) {
    put("{\"type\":\"");
    put(type);
    put("\",\"array\":\"");
    put(ARRAY);
    put("\",\"whisker\":");
    put_number(WHISKER);
    put(",\"t_ms\":");
    put_number(ms);
}

static void put_pressure() {
    // A line that does not fit is left out: the next one is newer.
    if (out_room() < 130) return;
    put_head("pressure", millis());
    put(",\"pressure_mpa\":");
    put_decimal(pressure_mpa, 5);
    put(",\"regulator\":\"");
    put(vibrissa::word(regulator.condition()));
    put("\"}\n");
}

static void put_strain() {
    if (out_room() < (SLIDE_MM > 0 ? 310 : 210)) return;
    put_head("strain", strain_ms);
    put(",\"every_us\":");
    put_number(STRAIN_US);
    put(",\"strain\":[");
    for (uint8_t i = 0; i < SAMPLES; i++) {
        if (i) put(",");
        put_decimal(strains[i], 6);
    }
    if (SLIDE_MM > 0) {
        put("],\"deflection_mm\":[");
        for (uint8_t i = 0; i < SAMPLES; i++) {
            if (i) put(",");
            put_decimal(ways_mm[i], 2);
        }
    }
    put("]}\n");
}

// The condition of the gauge, after each line of strain. It is repeated while it is bad, as the agent may have started anew.
static void put_gauge() {
    bool was_saturated = saturated;
    clean_lines = at_end ? 0 : clean_lines < CLEAN_LINES ? clean_lines + 1 : CLEAN_LINES;
    saturated = at_end || (saturated && clean_lines < CLEAN_LINES);
    at_end = false;
    bool is_due = saturated != was_saturated || (saturated && ++report_lines >= REPORT_LINES);
    if (!is_due || out_room() < 90) return;
    report_lines = 0;
    put_head("fault", millis());
    put(saturated ? ",\"gauge\":\"SATURATED\"}\n" : ",\"gauge\":\"OK\"}\n");
}

// The value of a field of a flat JSON object, or none. Fields of the lines that this board reads have no nested
// objects.
static const char *field(const char *line, const char *name) {
    size_t length = strlen(name);
    for (const char *at = strchr(line, '"'); at; at = strchr(at + 1, '"')) {
        if (strncmp(at + 1, name, length) || at[length + 1] != '"') continue;
        const char *value = at + length + 2;
        while (*value == ' ') value++;
        if (*value != ':') continue;
        value++;
        while (*value == ' ') value++;
        return value;
    }
    return 0;
}

static bool is_text(const char *value, const char *text) {
    size_t length = strlen(text);
    return value && value[0] == '"' && !strncmp(value + 1, text, length) && value[length + 1] == '"';
}

// A number, or not a number if there is none.
static float number(const char *value) {
    if (!value) return NAN;
    char *end;
    float parsed = strtod(value, &end);
    return end == value ? NAN : parsed;
}

static bool is_mine(const char *line) {
    const char *array = field(line, "array"), *whisker = field(line, "whisker");
    return (!array || is_text(array, ARRAY)) && (!whisker || atol(whisker) == WHISKER);
}

// A whole object: of a line that lost its end, the last number may be another one.
static bool is_whole(const char *line) {
    size_t length = strlen(line);
    while (length && (line[length - 1] == '\r' || line[length - 1] == ' ')) length--;
    return length && line[0] == '{' && line[length - 1] == '}';
}

// Only an order that this board obeys shows that somebody holds the pressure: noise, echoes and orders for others do not.
static void heard() {
    last_line_ms = millis();
    silent = false;
}

static void take_line(const char *line) {
    const char *type = field(line, "type");
    if (!type || !is_whole(line) || !is_mine(line)) return;
    if (is_text(type, "set_pressure")) {
        float mpa = number(field(line, "pressure_mpa")), slew = number(field(line, "slew_mpa_per_s"));
        // The comparison is false for a value that is not a number.
        if (!(mpa >= 0.0f && mpa <= LIMIT_MPA)) return;
        heard();
        by_hand = false;
        regulator.set_target(mpa, slew > 0.0f ? slew : 0.0f);
    } else if (is_text(type, "valve")) {
        float ms = number(field(line, "for_ms"));
        if (!(ms >= 0.0f && ms <= 1000.0f)) return;
        const char *open = field(line, "open");
        if (!is_text(open, "FILL") && !is_text(open, "VENT") && !is_text(open, "CLOSE")) return;
        heard();
        by_hand = true;
        if (is_text(open, "FILL") && pressure_mpa < LIMIT_MPA) open_valve(FILL_PIN, (unsigned long)(ms * 1000.0f));
        if (is_text(open, "VENT")) open_valve(VENT_PIN, (unsigned long)(ms * 1000.0f));
        if (is_text(open, "CLOSE")) close_valves();
    }
}

static void receive() {
    while (Serial.available() > 0) {
        char byte = (char)Serial.read();
        if (byte == '\n') {
            line_in[line_length] = 0;
            if (!line_too_long) take_line(line_in);
            line_length = 0;
            line_too_long = false;
        } else if (line_length < sizeof line_in - 1) {
            line_in[line_length++] = byte;
        } else {
            // Lines for richer drivers may be longer: they are not read.
            line_too_long = true;
        }
    }
}

static void regulate() {
    float volts = (analogRead(PRESSURE_PIN) + 0.5f) * VOLTS_PER_STEP;
    pressure_mpa = (volts - 1.0f) * 0.25f;
    vibrissa::Command command = regulator.step(micros(), pressure_mpa, NAN);
    if (by_hand) {
        if (pressure_mpa > LIMIT_MPA && open_pin != VENT_PIN) open_valve(VENT_PIN, 100000);
        return;
    }
    if (command.kind == vibrissa::FILL) open_valve(FILL_PIN, command.us);
    if (command.kind == vibrissa::VENT) open_valve(VENT_PIN, command.us);
    if (command.kind == vibrissa::CLOSE) close_valves();
}

static void watch() {
    if (silent || millis() - last_line_ms < SILENT_MS) return;
    silent = true;
    by_hand = false;
    regulator.set_target(0.0f, 0.0f);
}

void setup() {
    pinMode(FILL_PIN, OUTPUT);
    pinMode(VENT_PIN, OUTPUT);
    close_valves();
    Serial.begin(115200);
    wdt_enable(WDTO_2S);
    put("{\"type\":\"hello\",\"version\":1,\"name\":\"vibrissa_board\"}\n");
    last_step_us = last_strain_us = micros();
    last_pressure_ms = last_line_ms = millis();
}

void loop() {
    wdt_reset();
    end_pulse();
    receive();
    watch();
    unsigned long now_us = micros();
    if (now_us - last_step_us >= STEP_US) {
        last_step_us = now_us;
        regulate();
    }
    end_pulse();
    if (now_us - last_strain_us >= STRAIN_US) {
        // The grid of the samples is kept.
        last_strain_us += STRAIN_US;
        if (strain_count == 0) strain_ms = millis();
        if (SLIDE_MM > 0) ways_mm[strain_count] = analogRead(SLIDE_PIN) * (SLIDE_MM / 1023.0f);
        int raw = analogRead(STRAIN_PIN);
        at_end |= raw <= STRAIN_LEAST || raw >= STRAIN_MOST;
        strains[strain_count++] = ((raw + 0.5f) * VOLTS_PER_STEP - 2.5f) * STRAIN_PER_VOLT;
        if (strain_count == SAMPLES) {
            put_strain();
            put_gauge();
            strain_count = 0;
        }
    }
    if (millis() - last_pressure_ms >= PRESSURE_MS) {
        last_pressure_ms += PRESSURE_MS;
        put_pressure();
    }
    send();
}
