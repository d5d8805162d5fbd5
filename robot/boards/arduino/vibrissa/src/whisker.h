// One whisker of the board: its valves, its regulator, its watchdog and its samples.
#pragma once

#include "gauge.h"
#include "regulator.h"
#include "settings.h"
#include "text.h"

namespace vibrissa {

// A line of strain has about 10 samples, and a few more if it has to wait for room.
static const uint8_t SAMPLES = 10, SAMPLES_MOST = 14;

// Whiskers with an open valve.
extern uint8_t open_valves;

class Whisker {
  public:
    // Both valves are closed. With a broken configuration they stay closed, and no pin becomes an output.
    void begin(const WhiskerSettings &settings, bool locked, uint8_t slot);
    // Closes the valves, and lets go of their pins: the resistors to ground keep the valves closed.
    void release();
    // Ends a pulse that is over.
    void end_pulse() {
        if (open_pin != NO_PIN && micros() - pulse_begin_us >= pulse_us) close_valves();
    }
    // Whether a line with these fields is for this whisker.
    bool is_named(Part array, Part whisker) const;
    // An order for this whisker: `set_pressure` or `valve`.
    __attribute__((noinline)) void obey(const char *line, bool is_pressure);
    // Without an order for 5 s the setpoint becomes 0.
    void watch();
    __attribute__((noinline)) void regulate();
    // Takes a sample if one is due, and puts a line if it is full and `may_put`. `tick` is called often meanwhile.
    // Returns whether it has put a line.
    __attribute__((noinline)) bool sample(void (*tick)(), bool may_put);
    // Sends a line of pressure if one is due.
    __attribute__((noinline)) void report();

  private:
    const WhiskerSettings *set;
    // `refused`: an order above the limit is to be answered.
    bool locked, by_hand, silent, refused;
    uint8_t open_pin;
    uint32_t pulse_begin_us, pulse_us, last_order_ms, last_pressure_ms;
    float pressure_mpa;
    Regulator regulator;

    Gauge gauge;
    uint32_t period_us, due_us, first_us, last_us, first_ms;
    // Strain in units of 1e-7, way in 0.01 mm.
    int32_t strains[SAMPLES_MOST];
    int16_t ways[SAMPLES_MOST];
    uint8_t count;
    // Since the last line, and as reported.
    bool clipped, absent;
    Sample reported;
    uint32_t bad_ms, reported_ms;

    bool has_slide() const { return set->slide_pin != NO_PIN && set->slide_mm != 0.0f; }
    void open_valve(uint8_t pin, uint32_t us);
    void close_valves();
    void heard();
    void put_head(const char *type_in_flash, uint32_t ms) const;
    __attribute__((noinline)) void put_samples(void (*tick)());
    __attribute__((noinline)) void put_gauge();
};

}  // namespace vibrissa
