// Regulates the pressure of a chamber with two on/off valves: the algorithm of the Rust crate robot/regulator,
// function by function. docs/regulator.md explains it. A test runs both on the same readings and compares each command
// and condition. The microcontroller has no 64-bit floats and little memory, and its Rust compiler is not a stable one:
// hence this second implementation.
#pragma once

#include "regulator_parts.h"

namespace vibrissa {

enum Kind : uint8_t { NONE, FILL, VENT, CLOSE };
struct Command {
    Kind kind;
    uint32_t us;
};

enum Condition : uint8_t { OK, FILLING, VENTING, SUPPLY_LOW, LEAK, FAULT };
inline const char *word(Condition condition) {
    static const char *const words[] = {"OK", "FILLING", "VENTING", "SUPPLY_LOW", "LEAK", "FAULT"};
    return words[condition];
}

enum Fault : uint8_t { NO_FAULT, SENSOR, NO_RESPONSE, FILL_VALVE, BURST };

// robot/regulator/src/regulator
class Regulator {
    static constexpr uint32_t GAP_US = 2000000;
    static constexpr uint8_t APPROACHES = 12;
    static constexpr float LOW_STEPS = 8.0f, FAR_MPA = 3.4e38f;
    enum Phase : uint8_t { READY, PULSE, SETTLE };
    enum Aim : uint8_t { NOTHING, SETPOINT, PROBE, PURGE };
    enum Way : uint8_t { UP, DOWN };

    Params p;
    bool has_setpoint = false, begun = false, known = false;
    float setpoint_mpa = 0, slew_mpa_per_s = 0, ramp_mpa = 0, filtered_mpa = 0, quick_mpa = 0;
    uint32_t last_us = 0, bad_us = 0, good_us = 0;
    Phase phase = READY;
    Way way = UP;
    Aim aim = SETPOINT;
    uint32_t pulse_us_ = 0, left_us = 0;
    float before_mpa = 0, drive_mpa = 0, aim_mpa = 0, sum_mpa = 0;
    bool early = false;
    uint16_t count = 0;
    uint32_t since_pulse_us = UINT32_MAX, off_us = 0, elapsed_us = 0;
    bool reached = false;
    uint8_t approaches = 0;
    uint32_t travel_us = 0, short_us = 0, held_us = 0;
    float nearest_mpa = FAR_MPA, floor_mpa = 0;
    Gain fill, vent;
    Leak leak;
    bool leaks = false, supply_low = false, supply_given = false, supply_dead = false;
    uint8_t tries = 0, probes = 0;
    uint32_t vented_us = 0;
    float probe_mpa = 0;
    Aim next = NOTHING;
    Fault fault_ = NO_FAULT;

  public:
    __attribute__((noinline)) explicit Regulator(const Params &params = Params())
        : p(params), fill(params), vent(params) {}

    // A pressure beyond the limits is cut to them. A changed setpoint ends a fault.
    void set_target(float mpa, float slew) {
        if (mpa != mpa) return;
        mpa = clamped(mpa, 0.0f, p.max_mpa);
        slew_mpa_per_s = slew > 0.0f ? slew : 0.0f;
        if (has_setpoint && setpoint_mpa == mpa) return;
        has_setpoint = true;
        setpoint_mpa = mpa;
        ramp_mpa = filtered_mpa;
        leak = Leak();
        start_travel();
        clear_fault();
    }

    void clear_fault() {
        fault_ = NO_FAULT;
        vented_us = 0;
        tries = 0;
        probes = 0;
        next = NOTHING;
    }

    float pressure_mpa() const { return filtered_mpa; }
    float target_mpa() const { return setpoint_mpa; }
    Fault fault() const { return fault_; }

    Condition condition() const {
        if (fault_ != NO_FAULT) return FAULT;
        if (supply_low) return SUPPLY_LOW;
        if (leaks) return LEAK;
        if (has_setpoint && known && !reached) return setpoint_mpa > filtered_mpa ? FILLING : VENTING;
        return OK;
    }

    // The time may wrap around. A supply that is not measured is not a number.
    Command step(uint32_t now_us, float reading_mpa, float supply) {
        uint32_t gap_us = begun ? now_us - last_us : 0;
        begun = true;
        last_us = now_us;
        if (gap_us > GAP_US) start_anew();
        return advance(gap_us < GAP_US ? gap_us : GAP_US, reading_mpa, supply);
    }

  private:
    static Command nothing() { return {NONE, 0}; }
    static Command close() { return {CLOSE, 0}; }
    static bool finite(float value) { return value - value == 0.0f; }

    void start_anew() {
        phase = READY;
        known = false;
        leak = Leak();
        start_travel();
    }

    void start_travel() {
        reached = false;
        approaches = 0;
        travel_us = 0;
        nearest_mpa = FAR_MPA;
        short_us = 0;
        held_us = 0;
        elapsed_us = 0;
    }

    __attribute__((noinline)) Command advance(uint32_t dt_us, float reading, float supply) {
        since_pulse_us = plus(since_pulse_us, dt_us);
        elapsed_us = plus(elapsed_us, dt_us);
        bool good = reading >= p.reading_low_mpa && reading <= p.reading_high_mpa;
        if (!good) return bad_reading(dt_us);
        good_us = plus(good_us, dt_us);
        if (good_us > p.sensor_us) {
            bad_us = 0;
            if (fault_ == SENSOR) {
                clear_fault();
                start_anew();
            }
        }
        float dt = (float)dt_us;
        if (known) {
            float filter_us = reached ? p.filter_us : 0.3f * p.filter_us;
            filtered_mpa += (reading - filtered_mpa) * dt / (filter_us + dt);
            quick_mpa += (reading - quick_mpa) * dt / (p.filter_us / 6.0f + dt);
        } else {
            filtered_mpa = reading;
            quick_mpa = reading;
            ramp_mpa = reading;
            known = true;
            leak.begin(reading);
        }
        if (fault_ != NO_FAULT) return stopped(dt_us, reading);
        if (!has_setpoint) return nothing();
        move_ramp(dt);
        see_supply(supply);
        if (phase == PULSE) return pulse(dt_us, reading);
        if (phase == SETTLE) return settle(dt_us, reading);
        return ready(dt_us, reading, supply);
    }

    Command bad_reading(uint32_t dt_us) {
        good_us = 0;
        bad_us = plus(bad_us, dt_us);
        if (fault_ != NO_FAULT) return stopped(dt_us, p.reading_high_mpa);
        if (bad_us > p.sensor_us) return fail(SENSOR);
        if (phase == READY) return nothing();
        phase = READY;
        return close();
    }

    Command fail(Fault fault) {
        fault_ = fault;
        phase = READY;
        left_us = 0;
        vented_us = 0;
        leak = Leak();
        return close();
    }

    Command stopped(uint32_t dt_us, float reading) {
        left_us = minus(left_us, dt_us);
        bool empty = fault_ != NO_RESPONSE && reading < 2.0f * p.sensor_step_mpa;
        bool over = reading > p.max_mpa && fault_ != SENSOR;
        bool may = vented_us < p.vent_on_fault_us || over;
        if (left_us > 0 || !p.vent_on_fault || empty || !may) return nothing();
        left_us = p.pulse_most_us;
        vented_us = plus(vented_us, p.pulse_most_us);
        return {VENT, p.pulse_most_us};
    }

    void move_ramp(float dt) {
        if (slew_mpa_per_s > 0.0f) {
            float limit = slew_mpa_per_s * dt * 1e-6f;
            ramp_mpa += clamped(setpoint_mpa - ramp_mpa, -limit, limit);
        } else {
            ramp_mpa = setpoint_mpa;
        }
    }

    void see_supply(float supply) {
        supply_given = finite(supply);
        if (!supply_given) {
            supply_low = supply_dead;
            return;
        }
        supply_dead = false;
        float margin = (supply_low ? 1.1f : 1.0f) * p.supply_margin_mpa;
        supply_low = supply < setpoint_mpa + margin;
    }

    __attribute__((noinline)) Command pulse(uint32_t dt_us, float reading) {
        left_us = minus(left_us, dt_us);
        float half = 0.5f * p.sensor_step_mpa;
        bool past = way == UP ? reading > aim_mpa + half : reading < aim_mpa - half;
        bool cut = past && left_us > 0;
        if (cut) {
            pulse_us_ -= left_us;
            early = true;
        }
        if (cut || left_us == 0) {
            phase = SETTLE;
            left_us = p.settle_us;
            sum_mpa = 0;
            count = 0;
        }
        return cut ? close() : nothing();
    }

    __attribute__((noinline)) Command settle(uint32_t dt_us, float reading) {
        left_us = minus(left_us, dt_us);
        if (left_us <= p.settle_us / 2) {
            sum_mpa += reading;
            count += 1;
        }
        if (left_us > 0 || count < p.settle_readings) return nothing();
        float mean = sum_mpa / (float)count;
        filtered_mpa = mean;
        quick_mpa = mean;
        leak.begin(mean);
        phase = READY;
        since_pulse_us = 0;
        Gain &gain = way == UP ? fill : vent;
        float change = way == UP ? mean - before_mpa : before_mpa - mean;
        Answer answer = gain.learn(p, (float)pulse_us_, drive_mpa, change, early);
        if (aim == SETPOINT) return answered(answer, mean, change);
        if (aim == PROBE) return probed(probe_mpa - mean);
        return nothing();
    }

    Command answered(Answer answer, float mpa, float change) {
        if (way == UP && change > 1.5f * p.sensor_step_mpa) {
            supply_dead = false;
            tries = 0;
        }
        bool low = mpa < LOW_STEPS * p.sensor_step_mpa;
        if (answer != NO) return nothing();
        if (way == DOWN) {
            if (!low) return fail(NO_RESPONSE);
            floor_mpa = mpa;
            return nothing();
        }
        if (!low) {
            next = PROBE;
            return nothing();
        }
        if (supply_given || tries >= 3) return fail(NO_RESPONSE);
        tries += 1;
        supply_dead = true;
        next = PURGE;
        return nothing();
    }

    Command probed(float change) {
        if (change < 1.5f * p.sensor_step_mpa) {
            probes += 1;
            if (probes >= 5) return fail(NO_RESPONSE);
            next = PROBE;
            return nothing();
        }
        probes = 0;
        if (supply_given) return fail(FILL_VALVE);
        supply_dead = true;
        return nothing();
    }

    __attribute__((noinline)) Command ready(uint32_t dt_us, float reading, float supply) {
        float step = p.sensor_step_mpa;
        float supply_mpa = finite(supply) ? supply : p.supply_mpa;
        Aim now = next;
        next = NOTHING;
        if (now == PROBE) {
            if (probes == 0) probe_mpa = filtered_mpa;
            return begin(DOWN, PROBE, (float)(4 << probes) * step, supply_mpa);
        }
        if (now == PURGE) return begin(DOWN, PURGE, p.max_mpa, supply_mpa);
        if (reading > p.max_mpa + step && filtered_mpa > p.max_mpa + 0.5f * step) {
            return begin(DOWN, SETPOINT, reading - least(setpoint_mpa, ramp_mpa), supply_mpa);
        }
        bool moving = ramp_mpa != setpoint_mpa;
        float against = leaks ? most(leak.rate(filtered_mpa), 0.0f) : 0.0f;
        float lead = least(against * (float)p.refill_interval_us * 0.5e-6f, 0.4f * step);
        float error = ramp_mpa + lead - filtered_mpa;
        Fault fault = watch(dt_us, error);
        elapsed_us = 0;
        if (fault != NO_FAULT) return fail(fault);
        float size = size_of(error);
        float band = (moving ? 1.0f : 0.55f) * step;
        if (!moving && !reached) {
            bool near = approaches >= APPROACHES && size < 2.0f * step;
            if (size <= band || near || at_floor(error)) {
                reached = true;
                held_us = 0;
            }
        }
        bool fast = against > 4.0f * p.leak_report_mpa_per_s || size > 4.0f * step;
        uint32_t wait_us = !reached ? 0 : fast ? p.refill_interval_us : p.hold_interval_us;
        off_us = size <= band ? 0 : plus(off_us, dt_us);
        bool hasty = reached && !fast && off_us < (uint32_t)p.filter_us * 2;
        if (size <= band || hasty || at_floor(error) || since_pulse_us < wait_us) return nothing();
        if (error < 0.0f) return begin(DOWN, SETPOINT, size, supply_mpa);
        bool low = supply_low && (supply_given || since_pulse_us < p.retry_us);
        if (low || supply_mpa < filtered_mpa + 0.5f * p.supply_margin_mpa) return nothing();
        float limit = supply_dead ? 5.0f * step : size;
        return begin(UP, SETPOINT, least(size, limit), supply_mpa);
    }

    bool at_floor(float error) const { return error < 0.0f && filtered_mpa <= floor_mpa + p.sensor_step_mpa; }

    Fault watch(uint32_t dt_us, float error) {
        float step = p.sensor_step_mpa;
        if (!reached) return watch_travel(error);
        bool far = error > LOW_STEPS * step && !supply_low;
        short_us = far ? plus(short_us, elapsed_us) : 0;
        if (short_us > p.reach_us / 2) return BURST;
        held_us = plus(held_us, dt_us);
        if (held_us < p.leak_after_us) {
            leak.begin(filtered_mpa);
            return NO_FAULT;
        }
        leak.pass((float)dt_us, filtered_mpa);
        Tightness verdict = leak.verdict(p, filtered_mpa);
        if (verdict == TIGHT) leaks = false;
        if (verdict == LEAKS) leaks = true;
        return verdict == BURSTS ? BURST : verdict == RISES ? FILL_VALVE : NO_FAULT;
    }

    Fault watch_travel(float error) {
        float step = p.sensor_step_mpa;
        short_us = 0;
        if (ramp_mpa != setpoint_mpa || supply_low) {
            travel_us = 0;
            nearest_mpa = FAR_MPA;
            return NO_FAULT;
        }
        if (size_of(error) < nearest_mpa - 2.0f * step) {
            nearest_mpa = size_of(error);
            travel_us = 0;
        }
        travel_us = plus(travel_us, elapsed_us);
        if (travel_us < p.reach_us) return NO_FAULT;
        if (error < -4.0f * step) return FILL_VALVE;
        leaks = true;
        return error > 4.0f * step && travel_us > 2 * p.reach_us ? BURST : NO_FAULT;
    }

    Command begin(Way to, Aim why, float change, float supply_mpa) {
        float mpa = quick_mpa, step = p.sensor_step_mpa;
        leak.end(mpa);
        const Gain &gain = to == UP ? fill : vent;
        float drive = to == UP ? most(supply_mpa - mpa, 0.0f) : most(mpa, 0.0f);
        bool far = change > 8.0f * step;
        bool limit = to == UP && mpa + change > p.max_mpa - 4.0f * step;
        float part = far ? (limit ? 0.7f : 0.85f) : limit ? 0.6f : reached ? 0.8f : 1.0f;
        pulse_us_ = gain.pulse_us(p, part * change, drive, to == UP);
        phase = PULSE;
        way = to;
        aim = why;
        left_us = pulse_us_;
        early = false;
        before_mpa = mpa;
        drive_mpa = drive;
        if (approaches < APPROACHES) approaches++;
        aim_mpa = to == UP ? mpa + change : mpa - change;
        return {to == UP ? FILL : VENT, pulse_us_};
    }
};

}  // namespace vibrissa
