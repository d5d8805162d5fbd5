// Parameters of the regulator, its valves' gains and the leak: the files params.rs, learning.rs and diagnosis.rs of the
// Rust crate robot/regulator.
#pragma once

#include <stdint.h>

namespace vibrissa {

// Meanings and units: robot/regulator/src/params.rs.
struct Params {
    float max_mpa = 0.2f;
    float sensor_step_mpa = 0.0012207031f;
    static constexpr float reading_low_mpa = -0.02f;
    static constexpr float reading_high_mpa = 0.5f;
    static constexpr float supply_mpa = 0.25f;
    static constexpr float supply_margin_mpa = 0.005f;
    static constexpr float gain_first_per_s = 12.0f;
    static constexpr float gain_least_per_s = 0.3f;
    static constexpr float dead_first_us = 5000.0f;
    static constexpr float dead_most_us = 30000.0f;
    static constexpr uint32_t pulse_most_us = 1000000;
    static constexpr uint32_t settle_us = 80000;
    static constexpr uint32_t settle_readings = 6;
    static constexpr uint32_t hold_interval_us = 2000000;
    static constexpr uint32_t refill_interval_us = 250000;
    static constexpr float filter_us = 300000.0f;
    static constexpr uint32_t leak_after_us = 3000000;
    static constexpr float leak_report_mpa_per_s = 0.00005f;
    static constexpr float leak_burst_mpa_per_s = 0.02f;
    static constexpr uint32_t reach_us = 10000000;
    static constexpr uint32_t sensor_us = 300000;
    static constexpr uint32_t retry_us = 10000000;
    static constexpr bool vent_on_fault = true;
    static constexpr uint32_t vent_on_fault_us = 20000000;
};

inline float least(float a, float b) { return a < b ? a : b; }
inline float most(float a, float b) { return a > b ? a : b; }
inline float clamped(float value, float low, float high) { return value < low ? low : value > high ? high : value; }
inline float size_of(float value) { return value < 0 ? -value : value; }
inline uint32_t plus(uint32_t a, uint32_t b) { return a > UINT32_MAX - b ? UINT32_MAX : a + b; }
inline uint32_t minus(uint32_t a, uint32_t b) { return a > b ? a - b : 0; }

enum Answer : uint8_t { UNCLEAR, YES, NO };

// learning.rs
struct Gain {
    static constexpr float GAIN_STEPS = 4.0f, ANSWER_STEPS = 3.0f, DRIVE_LEAST_MPA = 0.005f;
    float per_s, dead_us, least_per_s, boost = 1.0f, expected_mpa = 0.0f, measured_mpa = 0.0f;
    bool learned = false;

    explicit Gain(const Params &p)
        : per_s(p.gain_first_per_s), dead_us(p.dead_first_us), least_per_s(p.gain_least_per_s) {}

    uint32_t pulse_us(const Params &p, float change_mpa, float drive_mpa, bool cautious) const {
        float rate = per_s * most(drive_mpa, DRIVE_LEAST_MPA);
        float us = dead_us + change_mpa / rate * 1e6f * boost;
        float proof_us = p.dead_most_us
            + ANSWER_STEPS * p.sensor_step_mpa / (least_per_s * most(drive_mpa, DRIVE_LEAST_MPA)) * 1.05e6f;
        float most_us = learned || !cautious ? (float)p.pulse_most_us : least(proof_us, (float)p.pulse_most_us);
        return (uint32_t)least(us, most_us);
    }

    Answer learn(const Params &p, float pulse_us, float drive_mpa, float change_mpa, bool early) {
        float step = p.sensor_step_mpa;
        float rate = per_s * most(drive_mpa, DRIVE_LEAST_MPA);
        float predicted = rate * most(pulse_us - dead_us, 0.0f) * 1e-6f;
        boost = change_mpa < 0.3f * predicted ? least(boost * 1.5f, 16.0f) : 1.0f;
        if (predicted >= GAIN_STEPS * step || (change_mpa >= GAIN_STEPS * step && pulse_us > 3.0f * dead_us)) {
            float ratio = clamped(change_mpa / most(predicted, 0.5f * step), 0.5f, 2.0f);
            float weight = learned ? 0.5f : 1.0f;
            per_s = clamped(per_s * (1.0f + weight * (ratio - 1.0f)), 0.5f * p.gain_least_per_s, 100.0f);
            if (change_mpa >= GAIN_STEPS * step) {
                learned = true;
                least_per_s = 0.3f * per_s;
            }
        } else {
            float error_us = clamped((predicted - change_mpa) / rate * 1e6f, -3000.0f, 3000.0f);
            dead_us = clamped(dead_us + 0.5f * error_us, 0.0f, p.dead_most_us);
        }
        float idle_us = learned ? 1.5f * dead_us + 2000.0f : p.dead_most_us;
        expected_mpa += least_per_s * drive_mpa * most(pulse_us - idle_us, 0.0f) * 1e-6f;
        measured_mpa += early ? most(change_mpa, predicted) : change_mpa;
        if (expected_mpa < ANSWER_STEPS * step) return UNCLEAR;
        Answer answer = measured_mpa > 0.25f * expected_mpa ? YES : NO;
        expected_mpa = 0.0f;
        measured_mpa = 0.0f;
        return answer;
    }
};

enum Tightness : uint8_t { UNKNOWN, TIGHT, LEAKS, BURSTS, RISES };

// diagnosis.rs
struct Leak {
    static constexpr float MEMORY_US = 60e6f, SEGMENT_US = 5e6f, LEAK_STEPS = 2.5f, RISE_STEPS = 6.0f;
    float lost_mpa = 0, time_us = 0, start_mpa = 0, segment_us = 0;

    void begin(float mpa) {
        start_mpa = mpa;
        segment_us = 0;
    }
    void pass(float dt_us, float mpa) {
        segment_us += dt_us;
        if (segment_us > SEGMENT_US) end(mpa);
    }
    void end(float mpa) {
        if (segment_us > 0) {
            lost_mpa += start_mpa - mpa;
            time_us += segment_us;
        }
        segment_us = 0;
        start_mpa = mpa;
        if (time_us > MEMORY_US) {
            lost_mpa *= 0.5f;
            time_us *= 0.5f;
        }
    }
    float rate(float mpa) const {
        float time = time_us + segment_us;
        return time < 0.5e6f ? 0.0f : (lost_mpa + start_mpa - mpa) / time * 1e6f;
    }
    Tightness verdict(const Params &p, float mpa) const {
        float lost = lost_mpa + start_mpa - mpa, now = rate(mpa), step = p.sensor_step_mpa;
        if (lost > LEAK_STEPS * step) {
            if (now > p.leak_burst_mpa_per_s && lost > 4.0f * LEAK_STEPS * step) return BURSTS;
            if (now > p.leak_report_mpa_per_s) return LEAKS;
        }
        if (-lost > RISE_STEPS * step && -now > 10.0f * p.leak_report_mpa_per_s) return RISES;
        if (time_us + segment_us > 0.5f * MEMORY_US && now < 0.5f * p.leak_report_mpa_per_s) return TIGHT;
        return UNKNOWN;
    }
};

}  // namespace vibrissa
