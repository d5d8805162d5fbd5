#include "whisker.h"

#include <math.h>
#include <new.h>
#include <string.h>

namespace vibrissa {

static const uint32_t PRESSURE_MS = 250, SILENT_MS = 5000, PULSE_MOST_US = 1000000, RELIEF_US = 100000;
// An order may exceed the limit by the zero of a sensor, which the agent adds. It counts as the limit.
static const float ABOVE_MPA = 0.01f;
// Longest time between two samples that a line may tell.
static const uint32_t EVERY_MOST_US = 100000;
// A line is sent once its samples take so long.
static const uint32_t LINE_US = 92000;
// Without a clipped sample for this long the gauge counts as in order; a bad one is reported so often.
static const uint32_t CLEAN_MS = 10000, REPORT_MS = 2000;
// Between two whiskers: with lines of 100 ms they come in turn, and samples of 10 ms are at least 0.8 ms apart.
static const uint32_t SHIFT_US = 17300;

void Whisker::begin(const WhiskerSettings &settings, bool is_locked, uint8_t slot) {
    set = &settings;
    locked = is_locked;
    by_hand = silent = refused = clipped = absent = false;
    open_pin = NO_PIN;
    pressure_mpa = 0.0f;
    count = 0;
    reported = GOOD;
    last_order_ms = millis();
    // Spread over the time between two lines, as all would not fit at once.
    last_pressure_ms = last_order_ms - 40 * slot;
    bad_ms = reported_ms = last_order_ms;
    due_us = micros() + SHIFT_US * slot;
    period_us = 1000000UL / set->rate_hz;
    Params params;
    params.max_mpa = set->limit_mpa;
    // The regulator is tried with this step and coarser ones.
    params.sensor_step_mpa = most(params.sensor_step_mpa, VOLTS_PER_STEP / set->pressure_v_per_mpa);
    // In its place: a copy would take 200 bytes of the stack.
    new (&regulator) Regulator(params);
    if (locked) return;
    close_valves();
    pinMode(set->fill_pin, OUTPUT);
    pinMode(set->vent_pin, OUTPUT);
    gauge.begin(settings);
}

void Whisker::release() {
    if (locked) return;
    close_valves();
    pinMode(set->fill_pin, INPUT);
    pinMode(set->vent_pin, INPUT);
}

uint8_t open_valves;

void Whisker::close_valves() {
    if (open_pin != NO_PIN) open_valves--;
    digitalWrite(set->fill_pin, LOW);
    digitalWrite(set->vent_pin, LOW);
    open_pin = NO_PIN;
}

void Whisker::open_valve(uint8_t pin, uint32_t us) {
    if (locked) return;
    close_valves();
    if (us == 0) return;
    pulse_us = us < PULSE_MOST_US ? us : PULSE_MOST_US;
    pulse_begin_us = micros();
    open_pin = pin;
    open_valves++;
    digitalWrite(pin, HIGH);
}

bool Whisker::is_named(Part array, Part whisker) const {
    return (!array.begin || is_text_of(array, set->array)) && (!whisker.begin || whole(whisker, 65535) == set->whisker);
}

// Only an order that this whisker obeys shows that somebody holds its pressure: noise, echoes and orders for others do
// not.
void Whisker::heard() {
    last_order_ms = millis();
    silent = false;
}

void Whisker::obey(const char *line, bool is_pressure) {
    if (locked) return;
    if (is_pressure) {
        float mpa = number(field(line, PSTR("pressure_mpa"))), slew = number(field(line, PSTR("slew_mpa_per_s")));
        // The comparisons are false for a value that is not a number.
        refused = mpa > set->limit_mpa + ABOVE_MPA;
        if (!(mpa >= 0.0f && mpa <= set->limit_mpa + ABOVE_MPA)) return;
        heard();
        by_hand = false;
        // The regulator never exceeds the limit.
        regulator.set_target(mpa, slew > 0.0f ? slew : 0.0f);
    } else {
        float ms = number(field(line, PSTR("for_ms")));
        if (!(ms >= 0.0f && ms <= 1000.0f)) return;
        Part open = field(line, PSTR("open"));
        bool fill = is_text(open, PSTR("FILL")), vent = is_text(open, PSTR("VENT"));
        if (!fill && !vent && !is_text(open, PSTR("CLOSE"))) return;
        heard();
        by_hand = true;
        if (fill && pressure_mpa < set->limit_mpa) open_valve(set->fill_pin, (uint32_t)(ms * 1000.0f));
        if (vent) open_valve(set->vent_pin, (uint32_t)(ms * 1000.0f));
        if (!fill && !vent) close_valves();
    }
}

void Whisker::watch() {
    if (silent || millis() - last_order_ms < SILENT_MS) return;
    silent = true;
    by_hand = false;
    regulator.set_target(0.0f, 0.0f);
}

void Whisker::regulate() {
    int raw = analogRead(set->pressure_pin);
    pressure_mpa = ((raw + 0.5f) * VOLTS_PER_STEP - set->pressure_zero_v) / set->pressure_v_per_mpa;
    // At the upper end of the converter the pressure may be any.
    Command command = regulator.step(micros(), raw >= 1023 ? NAN : pressure_mpa, NAN);
    if (by_hand) {
        if (pressure_mpa > set->limit_mpa && open_pin != set->vent_pin) open_valve(set->vent_pin, RELIEF_US);
        return;
    }
    if (command.kind == FILL) open_valve(set->fill_pin, command.us);
    if (command.kind == VENT) open_valve(set->vent_pin, command.us);
    if (command.kind == CLOSE) close_valves();
}

void Whisker::put_head(const char *type, uint32_t ms) const {
    put(PSTR("{\"type\":\""));
    put(type);
    put(PSTR("\",\"array\":\""));
    put_text(set->array);
    put(PSTR("\",\"whisker\":"));
    put_number(set->whisker);
    put(PSTR(",\"t_ms\":"));
    put_number(ms);
}

static const char *word_in_flash(Condition condition) {
    switch (condition) {
        case OK: return PSTR("OK");
        case FILLING: return PSTR("FILLING");
        case VENTING: return PSTR("VENTING");
        case SUPPLY_LOW: return PSTR("SUPPLY_LOW");
        case LEAK: return PSTR("LEAK");
        default: return PSTR("FAULT");
    }
}

void Whisker::report() {
    uint32_t now_ms = millis();
    if (refused && out_room() >= 240) {
        refused = false;
        put_head(PSTR("error"), now_ms);
        put(PSTR(",\"problem\":\"the pressure is above limit_mpa, which is "));
        put_float(set->limit_mpa);
        put(PSTR("\",\"do\":\"lower pressure_max_mpa in agent.toml, or raise the limit of the board\"}\n"));
        return;
    }
    if (now_ms - last_pressure_ms < PRESSURE_MS) return;
    // A line waits for room, and is then a newer one.
    if (out_room() < 140) return;
    last_pressure_ms += PRESSURE_MS;
    if (now_ms - last_pressure_ms > PRESSURE_MS) last_pressure_ms = now_ms;
    put_head(PSTR("pressure"), now_ms);
    put(PSTR(",\"pressure_mpa\":"));
    put_fixed(lround(pressure_mpa * 1e5f), 5);
    put(PSTR(",\"regulator\":\""));
    put(locked ? PSTR("FAULT") : word_in_flash(regulator.condition()));
    put(PSTR("\"}\n"));
    if (!locked || now_ms - reported_ms < REPORT_MS || out_room() < 300) return;
    reported_ms = now_ms;
    put_head(PSTR("fault"), now_ms);
    put(PSTR(",\"regulator\":\"FAULT\",\"problem\":\"the configuration in the EEPROM is damaged or foreign\","
             "\"do\":\"configure the board: the valves stay closed until then\"}\n"));
}

bool Whisker::sample(void (*tick)(), bool may_put) {
    if (locked || (set->sensor == NO_SENSOR && !has_slide())) return false;
    uint32_t now_us = micros();
    bool due = (int32_t)(now_us - due_us) >= 0;
    if (due) {
        // The grid of the samples is kept, unless the board was away for longer.
        due_us += period_us;
        if (now_us - due_us < 0x7fffffff && now_us - due_us > 3 * period_us) {
            due_us = now_us + period_us;
            count = 0;
        }
    }
    int32_t strain = 0;
    Sample sample = set->sensor == NO_SENSOR ? (due ? GOOD : WAITING) : gauge.read(*set, due, strain);
    if (sample == ABSENT) {
        // The samples of a line are evenly spaced: the begun one ends here.
        absent = true;
        count = 0;
    }
    if (sample == CLIPPED) clipped = true;
    if ((sample == GOOD || sample == CLIPPED) && count < SAMPLES_MOST) {
        if (count == 0) {
            first_us = now_us;
            first_ms = millis();
        }
        last_us = now_us;
        if (has_slide()) ways[count] = lround(analogRead(set->slide_pin) * (set->slide_mm * (100.0f / 1023.0f)));
        strains[count++] = strain;
    }
    if (count && (count >= SAMPLES || now_us - first_us >= LINE_US)) {
        uint16_t size = 130 + count * (has_slide() ? 20 : 12);
        if (!may_put || out_room() < size) return false;
        put_samples(tick);
        count = 0;
        tick();
        put_gauge();
        return true;
    }
    if ((absent || clipped) && !count) put_gauge();
    return false;
}

void Whisker::put_samples(void (*tick)()) {
    bool is_gauge = set->sensor != NO_SENSOR;
    tick();
    put_head(is_gauge ? PSTR("strain") : PSTR("motion"), first_ms);
    if (count > 1) {
        put(PSTR(",\"every_us\":"));
        // An HX711 has a clock of its own. At 10 Hz a line has two samples only if it waited for room; the interface
        // ends at 100 ms.
        uint32_t every_us = set->sensor == HX711 ? (last_us - first_us) / (count - 1) : period_us;
        put_number(every_us < EVERY_MOST_US ? every_us : EVERY_MOST_US);
    }
    for (uint8_t list = is_gauge ? 0 : 1; list < (has_slide() ? 2 : 1); list++) {
        put(list ? PSTR(",\"deflection_mm\":[") : PSTR(",\"strain\":["));
        for (uint8_t i = 0; i < count; i++) {
            tick();
            if (i) put(',');
            if (list) put_fixed(ways[i], 2);
            else put_fixed(strains[i], 7);
        }
        put(']');
    }
    put(PSTR("}\n"));
}

// The condition of the gauge. It is repeated while it is bad, as the agent may have started anew.
void Whisker::put_gauge() {
    uint32_t now_ms = millis();
    Sample now = absent ? ABSENT : clipped ? CLIPPED : GOOD;
    if (now != GOOD) bad_ms = now_ms;
    else if (reported != GOOD && now_ms - bad_ms < CLEAN_MS) now = reported;
    bool is_due = now != reported || (now != GOOD && now_ms - reported_ms >= REPORT_MS);
    // A line waits for room, and with it what it is to tell.
    if (is_due && out_room() < 110) return;
    absent = clipped = false;
    if (!is_due) return;
    reported = now;
    reported_ms = now_ms;
    put_head(PSTR("fault"), now_ms);
    put(PSTR(",\"gauge\":\""));
    put(now == ABSENT ? PSTR("OPEN") : now == CLIPPED ? PSTR("SATURATED") : PSTR("OK"));
    put(PSTR("\"}\n"));
}

}  // namespace vibrissa
